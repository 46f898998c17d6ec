// SPDX-License-Identifier: MIT
#include "pipeline/render/planes.h"

#include "pipeline/passes/encode.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/passes/resolve.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace plumb {

PlaneWriter::PlaneWriter(const Prepared& prepared, const RenderRequest& request, Frame& frame)
    : prepared_(prepared), planes_(request.planes), transparent_(request.transparent), frame_(frame) {
    restart();
}

void PlaneWriter::restart() {
    const size_t pixels = size_t(prepared_.width) * prepared_.height;
    frame_.coveredPixels = 0;
    frame_.width = prepared_.width;
    frame_.height = prepared_.height;
    forEachPlane([&](const auto& row, auto plane) {
        if (planes_ & row.plane) (frame_.*plane).assign(row.channels * pixels, row.undrawn);
    });
    frame_.rgba.assign(pixels, prepared_.undrawn);
    if (!(planes_ & kPlaneLinear)) return;
    for (size_t i = 0; i < pixels; ++i) std::copy_n(&prepared_.undrawnLinear.x, 3, frame_.linear.begin() + ptrdiff_t(3 * i));
}

uint64_t PlaneWriter::takeColours(uint32_t firstRow, uint32_t rows, const DeviceRows& from) {
    const uint32_t width = prepared_.width;
    const uint32_t opaque = transparent_ ? 0u : 0xff000000u;
    uint64_t covered = 0;
    for (uint32_t y = 0; y < rows; ++y) {
        const uint32_t* words = from.words.data() + size_t(y) * from.pitch;
        uint32_t* to = frame_.rgba.data() + size_t(firstRow + y) * width;
        for (uint32_t x = 0; x < width; ++x) {
            covered += words[x] >> 31;
            to[x] = words[x] | opaque;
        }
    }
    for (size_t i = 0; i < 3 && wants(kPlaneLinear); ++i)
        for (uint32_t y = 0; y < rows; ++y) {
            const uint32_t* words = from.linear[i] + size_t(y) * from.linearPitch;
            float* to = frame_.linear.data() + 3 * size_t(firstRow + y) * width + i;
            for (uint32_t x = 0; x < width; ++x) to[3 * size_t(x)] = std::bit_cast<float>(words[x]);
        }
    return covered;
}

void PlaneWriter::takeColours(uint32_t firstRow, uint32_t rows, const HostRows& from, uint32_t threads) {
    const size_t first = size_t(firstRow) * prepared_.width, pixels = size_t(rows) * prepared_.width;
    const std::span<uint32_t> rgba(frame_.rgba.data() + first, pixels);
    const uint32_t encoding = prepared_.choices.encoding, side = from.layout.side;
    const float* linear = from.linear.data();
    if (side > 1) {
        resolved_.resize(3 * pixels);
        resolveCpu(prepared_.width, rows, side, transparent_, encoding, from.linear, from.drawn, resolved_, rgba, threads,
                   from.layout.stride);
        linear = resolved_.data();
    } else {
        parallelBands(pixels, 4096, threads, [&](uint64_t begin, uint64_t end) {
            for (uint64_t i = begin; i < end; ++i)
                if (from.drawn[i]) rgba[i] = encodePixelCpu(encoding, &from.linear[3 * i], 255);
        });
    }
    if (wants(kPlaneLinear)) std::copy_n(linear, 3 * pixels, frame_.linear.begin() + ptrdiff_t(3 * first));
}

void PlaneWriter::replaceColour(uint32_t x, uint32_t y, uint32_t word, const float* linear, size_t step) {
    const size_t at = size_t(y) * prepared_.width + x;
    frame_.rgba[at] = word | (transparent_ ? 0u : 0xff000000u);
    for (size_t i = 0; i < 3 && wants(kPlaneLinear); ++i) frame_.linear[3 * at + i] = linear[i * step];
}

}  // namespace plumb
