// SPDX-License-Identifier: MIT
// Decisions of the contracts that scenes hardly ever reach, asked directly.
#include "shared/fill.h"
#include "shared/shade.h"

#include <cmath>
#include <gtest/gtest.h>

namespace plumb::gpu {
namespace {

constexpr FrameBox kFrame{16, 16, 0, 16};

// Centres lie at 128 + 256 k.
TEST(Classify, ATriangleBetweenTwoColumnsOfCentresIsOutside) {
    EXPECT_EQ(classify({129, 300}, {383, 1400}, {129, 2000}, kFrame, 0), kOutside);
    EXPECT_EQ(classify({128, 300}, {383, 1400}, {128, 2000}, kFrame, 0), kDrawn);
}

TEST(Classify, ATriangleBetweenTwoRowsOfCentresIsOutside) {
    EXPECT_EQ(classify({300, 129}, {1400, 383}, {2000, 129}, kFrame, 0), kOutside);
    EXPECT_EQ(classify({300, 128}, {1400, 383}, {2000, 128}, kFrame, 0), kDrawn);
}

TEST(DepthBits, StayInTheRangeOfTheCorners) {
    const int low = bitsOf(0.25f), high = bitsOf(0.5f);
    EXPECT_EQ(depthBits(1.0f, 0.0f, 0.25f, 0.0f, 0.375f, low, high), high);
    EXPECT_EQ(depthBits(1.0f, 0.0f, -0.25f, 0.0f, 0.375f, low, high), low);
    EXPECT_EQ(depthBits(1.0f, 0.0f, -1.0f, 0.0f, 0.375f, low, high), low) << "a negative depth";
    EXPECT_EQ(depthBits(1.0f, 0.0f, 0.0f, 0.0f, 0.375f, low, high), bitsOf(0.375f));
}

TEST(CoarseDepth, IsTheNextMultipleAndNeverNothing) {
    for (const uint bits : {16u, 24u}) {
        const float step = std::ldexp(1.0f, -int(bits));
        for (float z = 1.0f; z > 0x1p-40f; z *= 0.99f) {
            const float coarse = realOf(coarseDepth(bitsOf(z), bits));
            EXPECT_GE(coarse, z);
            EXPECT_LT(double(coarse) - z, step);
            EXPECT_EQ(std::fmod(coarse, step), 0.0f);
            EXPECT_LE(coarse, 1.0f);
        }
        EXPECT_EQ(realOf(coarseDepth(bitsOf(0x1p-60f), bits)), step) << "what is drawn is above 0";
        EXPECT_EQ(realOf(coarseDepth(bitsOf(step), bits)), step);
        EXPECT_EQ(realOf(coarseDepth(bitsOf(std::nextafter(step, 1.0f)), bits)), 2 * step);
    }
}

TEST(SnapCoarsely, GoesToTheNearestSixteenthTiesToEven) {
    for (int k = -500; k <= 500; ++k) {
        const float pixels = float(k) / 512.0f;   // ties of 1/256 px, and every sixteenth one of 1/16 px
        EXPECT_EQ(snapCoarsely(pixels, 100.0f, 4u), int(std::nearbyint(double(pixels) * 16)) * 16) << k;
        EXPECT_EQ(snapCoarsely(pixels, 100.0f, 0u), snapToSubpixel(pixels, 100.0f)) << k;
    }
    EXPECT_EQ(snapCoarsely(1e9f, 100.0f, 4u), 25600);
}

// Rounding: reciprocal 9 u, its argument 3 u, the product 1 u, all of at most 1; x itself is exact here.
TEST(SchlickPower, LiesAbovePowerByAtMostItsExcess) {
    constexpr double kRounding = 16 * 0x1p-24;
    double most = 0;
    for (double n = 1; n <= 1e6; n *= 1.0625)
        for (double t = 0; t <= 64; t += 0.0078125) {
            const float delta = float(t / n);
            if (!(delta < 1)) break;
            const float x = 1.0f - delta;
            if (double(x) + double(delta) != 1) continue;   // x is rounded: another argument
            const double excess = double(schlickPower(delta, float(n), 0.0f)) - std::pow(1 - double(delta), double(float(n)));
            ASSERT_GE(excess, -kRounding) << n << ' ' << delta;
            ASSERT_LE(excess, double(kSchlickExcess) + kRounding) << n << ' ' << delta;
            most = std::max(most, excess);
        }
    EXPECT_GT(most, 0.203) << "the bound is met nearly";
    for (const float n : {0.0f, 0.5f, 1.0f, 50.0f, 1e6f}) {
        const float zeroPower = n == 0 ? 1.0f : 0.0f;
        EXPECT_NEAR(schlickPower(0.0f, n, zeroPower), 1.0f, kRounding) << n;
        EXPECT_EQ(schlickPower(1.0f, n, zeroPower), zeroPower) << n;
        EXPECT_EQ(schlickPower(2.0f, n, zeroPower), zeroPower) << n;
    }
}

TEST(Wins, IsATotalOrderThatDoesNotDependOnVisits) {
    EXPECT_TRUE(wins(2, 9, 1, 3));
    EXPECT_FALSE(wins(1, 3, 2, 9));
    EXPECT_TRUE(wins(2, 3, 2, 9));
    EXPECT_FALSE(wins(2, 9, 2, 3));
    EXPECT_FALSE(wins(2, 3, 2, 3)) << "not before itself";
    EXPECT_FALSE(wins(1, 1, 2, 0)) << "what was there before wins ties only";
    EXPECT_FALSE(wins(2, 1, 2, 0));
}

}  // namespace
}  // namespace plumb::gpu
