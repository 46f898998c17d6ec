// SPDX-License-Identifier: MIT
#include "pipeline/passes/fill.h"

#include "pipeline/passes/parallel.h"
#include "pipeline/passes/pixel_shader.h"

#include <algorithm>

namespace plumb {

void fillCpu(const gpu::FrameBox& frame, std::span<const gpu::DrawTriangle> draws, std::span<const gpu::ScreenVertex> screen,
             std::span<int> z, std::span<uint32_t> draw, uint32_t threads, uint32_t depthBits) {
    parallelBands(uint64_t(frame.rows), 8, threads, [&](uint64_t begin, uint64_t end) {
        const int64_t bandFirst = frame.firstRow + int64_t(begin), bandLast = frame.firstRow + int64_t(end) - 1;
        std::fill(z.begin() + ptrdiff_t(begin * frame.width), z.begin() + ptrdiff_t(end * frame.width), 0);
        std::fill(draw.begin() + ptrdiff_t(begin * frame.width), draw.begin() + ptrdiff_t(end * frame.width), 0u);
        for (uint32_t t = 0; t < draws.size(); ++t) {
            const gpu::DrawTriangle& d = draws[t];
            if (d.vertex[0] == d.vertex[1]) continue;  // unused slot of a clip fan
            const int lowY = std::min({screen[d.vertex[0]].y, screen[d.vertex[1]].y, screen[d.vertex[2]].y});
            const int highY = std::max({screen[d.vertex[0]].y, screen[d.vertex[1]].y, screen[d.vertex[2]].y});
            const int64_t firstRow = std::max<int64_t>(gpu::firstPixel(lowY), bandFirst);
            const int64_t lastRow = std::min<int64_t>(gpu::lastPixel(highY), bandLast);
            if (firstRow > lastRow) continue;
            const DrawnTriangle g(d, screen);
            const gpu::DepthPlane plane = g.depth(d, screen);
            for (int64_t row = firstRow; row <= lastRow; ++row) {
                const auto [first, last] = g.span(row, frame.width);
                for (int64_t x = first; x <= last; ++x) {
                    const size_t at = size_t(row - frame.firstRow) * size_t(frame.width) + size_t(x);
                    int here = gpu::depthBits(g.whole(2, x, row), g.whole(0, x, row), plane.k1, plane.k2, plane.zc, plane.low, plane.high);
                    if (depthBits < 32) here = gpu::coarseDepth(here, depthBits);
                    if (depthBits == gpu::kDepthStandard) here = gpu::standardDepth(here);
                    if (!gpu::wins(here, int(t + 1), z[at], int(draw[at]))) continue;
                    z[at] = here;
                    draw[at] = t + 1;
                }
            }
        }
    });
}

void shadeCpu(const gpu::FrameBox& frame, const DrawList& list, const FillChoices& choices, std::span<const gpu::DrawTriangle> draws,
              std::span<const gpu::ScreenVertex> screen, std::span<const glm::vec4> attributes, std::span<const int> z,
              std::span<const uint32_t> draw, std::span<float> linear, std::span<float> normal, uint32_t threads) {
    const PixelShader shader(frame, list, choices, draws, screen, attributes, z, draw);
    parallelBands(uint64_t(frame.rows), 8, threads, [&](uint64_t begin, uint64_t end) {
        for (size_t at = begin * frame.width; at < end * frame.width; ++at) {
            if (!draw[at]) continue;
            float* colour = &linear[3 * at];
            float* unitNormal = normal.empty() ? nullptr : &normal[3 * at];
            const size_t from = choices.coarse ? shader.coarsePixel(at) : at;
            if (from == at || unitNormal) shader.shade(at, colour, unitNormal);
            if (from == at) continue;
            if (from >= begin * frame.width && from < at)
                std::copy_n(&linear[3 * from], 3, colour);
            else
                shader.shade(from, colour, nullptr);
        }
    });
}

}  // namespace plumb
