// SPDX-License-Identifier: MIT
#include "pipeline/passes/encode.h"

#include "host/error.h"

#include <algorithm>
#include <cmath>

namespace plumb {

namespace {

// Linear value of an sRGB code. long double has a significand of 64 bits, far more than float32. No threshold comes that close to a float
// (tests/unit/encode_test.cpp checks the distances).
long double linearOfCode(long double code) {
    const long double s = code / 255.0L;
    return s <= 0.04045L ? s / 12.92L : std::pow((s + 0.055L) / 1.055L, 2.4L);
}

}  // namespace

const std::array<float, 256>& srgbThresholds() {
    static const std::array<float, 256> kTable = [] {
        std::array<float, 256> t{};
        for (int c = 1; c < 256; ++c) {
            const long double exact = linearOfCode(c - 0.5L);
            float f = float(exact);
            if (static_cast<long double>(f) < exact) f = std::nextafter(f, 2.0f);
            t[size_t(c)] = f;
        }
        return t;
    }();
    return kTable;
}

const std::vector<uint32_t>& srgbBucketTable() {
    static const std::vector<uint32_t> kTable = [] {
        std::vector<uint32_t> t;
        const std::array<float, 256>& thresholds = srgbThresholds();
        for (int bucket = 0; bucket < gpu::kEncodeBuckets; ++bucket) {
            const int firstBits = (bucket + gpu::kEncodeFirstBucket) << 16;
            const float first = gpu::realOf(firstBits);
            // Codes below the bucket: thresholds not above its first float, unless one is that float's successor or later.
            const auto after = std::lower_bound(thresholds.begin() + 1, thresholds.end(), first);
            const uint32_t below = uint32_t(after - thresholds.begin()) - 1;
            uint32_t low = 0x10000u;
            if (after != thresholds.end() && gpu::bitsOf(*after) <= (firstBits | 0xffff)) {
                low = uint32_t(gpu::bitsOf(*after)) & 0xffffu;
                PLUMB_ASSERT(after + 1 == thresholds.end() || gpu::bitsOf(*(after + 1)) > (firstBits | 0xffff));
            }
            t.push_back(below << 17 | low);
        }
        return t;
    }();
    return kTable;
}

uint32_t encodeSrgbCpu(float linear) {
    const std::array<float, 256>& t = srgbThresholds();
    uint32_t low = 0, high = 256;  // t[low] <= linear < t[high]; NaN and negative values stay at 0
    while (high - low > 1) {
        const uint32_t middle = (low + high) / 2;
        (linear >= t[middle] ? low : high) = middle;
    }
    return low;
}

uint32_t encodePixelCpu(uint32_t encoding, const float* linear, uint32_t alpha) {
    uint32_t word = alpha << 24;
    for (int i = 0; i < 3; ++i) {
        const uint32_t code = encoding == gpu::kEncodeSrgb     ? encodeSrgbCpu(linear[i])
                              : encoding == gpu::kEncodeNative ? uint32_t(gpu::encodeNative(linear[i]))
                                                               : uint32_t(gpu::encodeLinear(linear[i]));
        word |= code << (8 * i);
    }
    return word;
}

}  // namespace plumb
