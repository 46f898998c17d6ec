// SPDX-License-Identifier: MIT
// shaders/shared/exact.h on the host: the emulated forms against IEEE, whatever the seed.
#include "shared/exact.h"

#include <gtest/gtest.h>
#include <cmath>
#include <cstdint>

#include <ios>
#include <random>

namespace plumb::gpu {
namespace {

// Significands at the ends, with few bits, and random; exponents so that the quotient stays normal.
float operand(std::mt19937& random) {
    const uint32_t bits = uint32_t(random());
    uint32_t significand = bits & 0x7fffffu;
    switch (bits >> 30) {
        case 0:
            significand = bits & 15u;
            break;
        case 1:
            significand = 0x7fffffu - (bits & 15u);
            break;
        case 2:
            significand = ((1u << (bits >> 4) % 23u) + (bits & 7u) - 4u) & 0x7fffffu;
            break;
        default:
            break;
    }
    return realOf(int((uint32_t(random()) & 0x80000000u) | (70u + uint32_t(random()) % 115u) << 23 | significand));
}

class EmulatedArithmetic : public testing::TestWithParam<int> {};

TEST_P(EmulatedArithmetic, DividesAsIeeeDoes) {
    std::mt19937 random(1);
    for (int i = 0; i < 1000000; ++i) {
        const float a = operand(random), b = operand(random);
        ASSERT_EQ(ubitsOf(emulatedDivide(a, b, GetParam())), ubitsOf(a / b)) << std::hexfloat << a << " / " << b;
    }
}

TEST_P(EmulatedArithmetic, TakesTheRootAsIeeeDoes) {
    std::mt19937 random(2);
    for (int i = 0; i < 1000000; ++i) {
        const float a = std::fabs(operand(random));
        ASSERT_EQ(ubitsOf(emulatedRoot(a, GetParam())), ubitsOf(std::sqrt(a))) << std::hexfloat << a;
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, EmulatedArithmetic, testing::Values(-7, -5, -3, -2, -1, 0, 1, 2, 3, 4));

TEST(EmulatedArithmetic, TakesEveryExponentOfARadicand) {
    for (uint32_t exponent = 1; exponent < 255; ++exponent)
        for (uint32_t significand : {0u, 1u, 2u, 0x3fffffu, 0x400000u, 0x7ffffeu, 0x7fffffu}) {
            const float a = realOf(int(exponent << 23 | significand));
            ASSERT_EQ(ubitsOf(emulatedRoot(a, 0)), ubitsOf(std::sqrt(a))) << std::hexfloat << a;
        }
}

TEST(EmulatedArithmetic, SquaresGiveTheirRoots) {
    for (uint32_t i = 1; i < 4096; ++i) ASSERT_EQ(emulatedRoot(float(i * i), 0), float(i));
}

TEST(EmulatedArithmetic, ZeroOverSomethingIsZeroOfTheRightSign) {
    EXPECT_EQ(ubitsOf(emulatedDivide(0.0f, 3.0f, 0)), 0u);
    EXPECT_EQ(ubitsOf(emulatedDivide(0.0f, -3.0f, 0)), 0x80000000u);
    EXPECT_EQ(ubitsOf(emulatedRoot(0.0f, 0)), 0u);
}

// The comparison above must be able to fail: a seed beyond the promise is noticed.
TEST(EmulatedArithmetic, BreaksWithASeedBeyondItsPromise) {
    std::mt19937 random(1);
    int wrong = 0;
    for (int i = 0; i < 10000; ++i) {
        const float a = operand(random), b = operand(random);
        wrong += ubitsOf(emulatedDivide(a, b, 40)) != ubitsOf(a / b);
    }
    EXPECT_GT(wrong, 1000);
}

TEST(ExactArithmetic, IsIeeeOnTheHost) {
    EXPECT_EQ(exactDivide(1.0f, 3.0f), 1.0f / 3.0f);
    EXPECT_EQ(exactRoot(2.0f), std::sqrt(2.0f));
}

TEST(SnapTiny, CutsBelowTheStatedPowerOnly) {
    const float limit = std::ldexp(1.0f, -103);
    EXPECT_EQ(ubitsOf(snapTiny(limit)), ubitsOf(limit));
    EXPECT_EQ(ubitsOf(snapTiny(-limit)), ubitsOf(-limit));
    EXPECT_EQ(ubitsOf(snapTiny(std::nextafter(limit, 0.0f))), 0u);
    EXPECT_EQ(ubitsOf(snapTiny(-std::nextafter(limit, 0.0f))), 0u);
    EXPECT_EQ(ubitsOf(snapTiny(-0.0f)), 0u);
    EXPECT_EQ(ubitsOf(snapTiny(1e-45f)), 0u);
    EXPECT_EQ(snapTiny(-1.5f), -1.5f);
}

}  // namespace
}  // namespace plumb::gpu
