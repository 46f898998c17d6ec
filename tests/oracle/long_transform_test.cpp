// SPDX-License-Identifier: MIT
// The transforms that are more accurate than float32, against exact arithmetic: within the bounds that stand beside them, where float32 is far outside.
#include "pipeline/passes/long_rows.h"
#include "pipeline/truth/exact.h"

#include <gtest/gtest.h>
#include <cstdint>
#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <random>

namespace plumb {
namespace {

using truth::Exact;

double errorOf(float got, const Exact& exact) { return std::abs((Exact(double(got)) - exact).rounded()); }

struct Worst {
    double block = 0, binary64 = 0, fp32 = 0;  // errors over the bound of each (fp32: over the block transform's)
};

// reach: of coordinates; entry: of m_0 ... m_2; last: m_3, 0: so that the object is near the eye and the four products cancel.
Worst worstOf(double reach, double entry, double last, uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> within(-1, 1);
    Worst worst;
    for (int i = 0; i < 2000; ++i) {
        const glm::vec3 p(float(reach * within(random)), float(reach * within(random)), float(reach * within(random)));
        glm::dvec4 row(entry * within(random), entry * within(random), entry * within(random), last);
        if (last == 0) row.w = -glm::dot(glm::dvec3(row), glm::dvec3(p)) * (1 + 1e-3 * within(random));
        const int exponent = blockExponent(reach);
        const gpu::LongRow longRow = plumb::longRow(row, exponent);
        gpu::LongRecord record{longRow, longRow, longRow, float(std::ldexp(1.0, -exponent))};
        const Exact exact =
            Exact(row.x) * Exact(double(p.x)) + Exact(row.y) * Exact(double(p.y)) + Exact(row.z) * Exact(double(p.z)) + Exact(row.w);
        const double r = std::abs(exact.rounded()), m = std::max({std::abs(row.x), std::abs(row.y), std::abs(row.z)}), u = 0x1p-24;
        const double sum = std::abs(row.x * double(p.x)) + std::abs(row.y * double(p.y)) + std::abs(row.z * double(p.z)) + std::abs(row.w);
        // shaders/shared/long_transform.h.
        const double block = u * r + 6 * 0x1p-30 * m * reach * (1 + 0x1p-30) + 0x1p-29 * std::abs(row.w);
        const double binary64 = u * r + 0x1p-103 + 4.01 * 0x1p-53 * sum;
        const glm::vec3 fromBlock = gpu::blockClip(record, p), fromDouble = gpu::doubleClip(record, p);
        worst.block = std::max(worst.block, errorOf(fromBlock.x, exact) / block);
        worst.binary64 = std::max(worst.binary64, errorOf(fromDouble.x, exact) / binary64);
        worst.fp32 = std::max(worst.fp32, errorOf(gpu::rowTimesPoint(glm::vec4(row), p), exact) / block);
        EXPECT_EQ(fromBlock.x, fromBlock.y);
        EXPECT_EQ(fromDouble.x, fromDouble.z);
    }
    return worst;
}

TEST(LongTransform, IsWithinItsBoundAtEveryScale) {
    double block = 0, binary64 = 0;
    for (const double reach : {1e-20, 1e-3, 1.0, 1e5, 1e10})
        for (const double entry : {1e-6, 1.0, 700.0})
            for (const double last : {1e-9, 1.0, 1e4, 1e12}) {  // in units of the products; the last takes larger units
                const Worst worst = worstOf(reach, entry, last * reach * entry, 5);
                EXPECT_LE(worst.block, 1) << reach << ' ' << entry << ' ' << last;
                EXPECT_LE(worst.binary64, 1) << reach << ' ' << entry << ' ' << last;
                block = std::max(block, worst.block);
                binary64 = std::max(binary64, worst.binary64);
            }
    EXPECT_GT(block, 0.5) << "a bound that says nothing";
    EXPECT_GT(binary64, 0.5) << "a bound that says nothing";
}

// An object far from its own origin, near the eye: the products cancel, and what float32 lost in them is seen.
TEST(LongTransform, KeepsWhatFloat32Loses) {
    for (const double reach : {1.0, 1e4}) {
        const Worst worst = worstOf(reach, 700, 0, 9);
        EXPECT_LE(worst.block, 1);
        EXPECT_LE(worst.binary64, 1);
        EXPECT_GT(worst.fp32, 4) << "float32 does as well";
    }
}

// Rows of 0, and entries at the ends of what 30 and 61 bits take.
TEST(LongTransform, HoldsTheEnds) {
    const glm::vec3 p(1.0f, -1.0f, 0.0f);
    const auto clip = [&](const glm::dvec4& row) {
        const gpu::LongRow r = longRow(row, blockExponent(1));
        return gpu::blockClip({r, r, r, float(std::ldexp(1.0, -blockExponent(1)))}, p).x;
    };
    EXPECT_EQ(clip({0, 0, 0, 0}), 0.0f);
    EXPECT_EQ(clip({1, 1, 5, 0}), 0.0f);
    EXPECT_EQ(clip({std::nextafter(1.0, 0.0), -1, 1, 0.5}), 2.5f);
    EXPECT_EQ(clip({1, -1, 1, std::nextafter(0x1p60, 0.0)}), 0x1p60f);
    EXPECT_EQ(clip({1, -1, 1, -0x1p61}), -0x1p61f);
    EXPECT_EQ(clip({0, 0, 0, -3}), -3.0f);
}

}  // namespace
}  // namespace plumb
