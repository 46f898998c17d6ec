// SPDX-License-Identifier: MIT
// Decisions of the contracts that scenes hardly ever reach, asked directly.
#include "shared/fill.h"

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
