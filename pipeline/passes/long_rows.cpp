// SPDX-License-Identifier: MIT
#include "pipeline/passes/long_rows.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb {

namespace {

constexpr int kEntryBits = 30, kLastBits = 61;  // three products below 2^60 plus 2^61 stay below 2^63

// Exponent e with |x| < 2^e.
int exponentAbove(double x) { return x == 0 ? -1000 : std::ilogb(x) + 1; }

gpu::Word64 wordOf(int64_t value) { return {int(value >> 32), uint32_t(value)}; }

}  // namespace

int blockExponent(double reach) { return std::clamp(exponentAbove(reach) - kEntryBits, -126, 126); }

gpu::LongRow longRow(const glm::dvec4& row, int exponent) {
    // Unit of the row. The last entry counts units of the products: where it is large, units are larger.
    const int largest = exponentAbove(std::max({std::abs(row.x), std::abs(row.y), std::abs(row.z)}));
    const int unit = std::max(largest - kEntryBits, exponentAbove(row.w) - kLastBits - exponent);
    gpu::LongRow r{};
    for (int i = 0; i < 3; ++i) r.m[i] = int(std::lrint(std::ldexp(row[i], -unit)));
    r.exponent = unit + exponent;
    r.last = wordOf(std::llrint(std::ldexp(row.w, -r.exponent)));
    for (int i = 0; i < 4; ++i) {
        const auto bits = std::bit_cast<uint64_t>(row[i]);
        glm::uvec4& words = i < 2 ? r.double01 : r.double23;
        words[2 * (i % 2)] = uint32_t(bits);
        words[2 * (i % 2) + 1] = uint32_t(bits >> 32);
    }
    return r;
}

}  // namespace plumb
