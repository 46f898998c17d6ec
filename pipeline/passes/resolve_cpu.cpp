// SPDX-License-Identifier: MIT
#include "pipeline/passes/resolve.h"

#include "pipeline/passes/encode.h"
#include "pipeline/passes/parallel.h"

#include <algorithm>

namespace plumb {

void resolveCpu(uint32_t width, uint32_t height, uint32_t side, bool transparent, uint32_t encoding, std::span<const float> samples,
                std::span<const int> z, std::span<float> pixels, std::span<uint32_t> rgba, uint32_t threads, uint32_t stride) {
    const uint32_t count = side * side, step = stride ? stride : side;
    const size_t pitch = size_t(width - 1) * step + side;
    parallelBands(height, 8, threads, [&](uint64_t begin, uint64_t end) {
        for (uint64_t y = begin; y < end; ++y)
            for (uint64_t x = 0; x < width; ++x) {
                float sum[3] = {0, 0, 0};
                uint32_t covered = 0;
                for (uint32_t k = 0; k < count; ++k) {
                    const size_t at = size_t(y * step + k / side) * pitch + size_t(x * step + k % side);
                    const bool here = z[at] != 0;
                    covered += here;
                    if (!here && transparent) continue;
                    for (int i = 0; i < 3; ++i) sum[i] += samples[3 * at + size_t(i)];
                }
                const float inverse = gpu::exactDivide(1.0f, transparent ? float(std::max(covered, 1u)) : float(count));
                float* pixel = &pixels[3 * size_t(y * width + x)];
                for (int i = 0; i < 3; ++i) pixel[i] = sum[i] * inverse;
                const uint32_t alpha = transparent ? gpu::coverageCode(covered, count) : 255u;
                rgba[size_t(y * width + x)] = encodePixelCpu(encoding, pixel, alpha);
            }
    });
}

}  // namespace plumb
