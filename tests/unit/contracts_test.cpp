// SPDX-License-Identifier: MIT
// Decisions of the contracts that scenes hardly ever reach, asked directly.
#include "shared/bounds.h"
#include "shared/encode.h"
#include "shared/fill.h"
#include "shared/long_transform.h"
#include "shared/shade.h"
#include "shared/vectors.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

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

// Unit vectors are within 9 u of their length, reciprocals of theirs; a few operations more (shade.h).
constexpr float kFewUlp = 16 * 0x1p-24f;

TEST(Vectors, ALampAtThePlaceShinesFromNowhere) {
    for (const float attenuation : {0.0f, 1.0f, 2.0f}) {
        const Toward at = lampFrom({1, 2, 3, 1}, attenuation, {1, 2, 3});
        EXPECT_EQ(at.x, 0.0f);
        EXPECT_EQ(at.fade, attenuation == 2 ? 0.0f : at.fade);
        EXPECT_LT(at.fade, 0x1p100f);
        const Toward beside = lampFrom({1, 2, 3, 1}, attenuation, {1, 2, 2.5f});
        EXPECT_NEAR(beside.z, 1.0f, kFewUlp);
        EXPECT_NEAR(beside.fade, std::exp2(attenuation), kFewUlp * std::exp2(attenuation));
    }
    EXPECT_EQ(lampFrom({0, 0, 1, 0}, 0, {5, 6, 7}).z, 1.0f) << "no place: the same direction from everywhere";
}

// Every significand at both exponents. The proof of the last step (reciprocal_root.g) starts from an error below 2^-16 after the two before.
TEST(Vectors, ReciprocalRootIsWithinItsBound) {
    constexpr double kUnit = 0x1p-24, kBeforeLast = 0x1p-16;
    double worst = 0, worstReciprocal = 0, before = 0;
    for (int bits = bitsOf(1.0f); bits < bitsOf(4.0f); ++bits) {
        const float x = realOf(bits);
        const double root = std::sqrt(double(x)), y = double(reciprocalRoot(x));
        worst = std::max(worst, std::abs(y * root - 1));
        worstReciprocal = std::max(worstReciprocal, std::abs(double(reciprocal(x)) * double(x) - 1));
        float step = realOf(0x5f375a86 - (bits >> 1));
        for (int i = 0; i < 2; ++i) step = step * ((x * -0.5f * step) * step + 1.5f);
        before = std::max(before, std::abs(double(step) * root - 1));
    }
    EXPECT_LE(worst, kReciprocalRootUnits * kUnit);
    EXPECT_LE(worstReciprocal, kReciprocalUnits * kUnit);
    EXPECT_LE(before, kBeforeLast);
    EXPECT_GT(worst, kUnit) << "nothing was measured";
}

TEST(Vectors, PlacesAndSharesAreThoseOfTheProjection) {
    // The pixel (x, y) at w = near / z: (rayOrigin + rayX x + rayY y) w.
    const Position p = positionOfCorner(3 * 256 + 128, -256, 0.25f, 1.5f, {1, 2, 3}, {0.5f, 0, 0}, {0, 0.25f, 0});
    const float tie = kFewUlp * 18;  // the largest of the three
    EXPECT_NEAR(p.x, (1 + 0.5f * 3.5f) * 6, tie);
    EXPECT_NEAR(p.y, (2 - 0.25f) * 6, tie);
    EXPECT_NEAR(p.z, 18, tie);
    // Edge values g1, g2, g0 belong to the corners 0, 1, 2.
    const Shares s = sharesOf(1, 2, 1, 5, 10, 1);
    EXPECT_NEAR(s.s0, 10.0f / 17, kFewUlp);
    EXPECT_NEAR(s.s1, 2.0f / 17, kFewUlp);
    EXPECT_NEAR(s.s2, 5.0f / 17, kFewUlp);
    EXPECT_EQ(shared3({0.25f, 0.5f, 0.25f}, 4, 2, 8), 4.0f);
    const Toward eye = eyeFrom({0, 3, -4});
    EXPECT_NEAR(eye.y, -0.6f, kFewUlp);
    EXPECT_NEAR(eye.z, 0.8f, kFewUlp);
}

Word64 wordOf(std::int64_t x) { return {int(x >> 32), uint(x)}; }
std::int64_t valueOf(Word64 w) { return std::int64_t(std::uint64_t(uint(w.high)) << 32 | w.low); }
std::uint64_t nextRandom(std::uint64_t& state) { return state = state * 6364136223846793005u + 1442695040888963407u; }

TEST(Word64, AddsNegatesAndMultipliesAsTheProcessorDoes) {
    std::uint64_t state = 3;
    for (int i = 0; i < 20000; ++i) {
        const auto a = std::int64_t(nextRandom(state)) >> (i % 40 + 1), b = std::int64_t(nextRandom(state)) >> (i % 37 + 1);
        ASSERT_EQ(valueOf(sumOfWords(wordOf(a), wordOf(b))), a + b);
        ASSERT_EQ(valueOf(negatedWord(wordOf(a))), -a);
        ASSERT_EQ(valueOf(productOfInts(int(a), int(b))), std::int64_t(int(a)) * int(b));
    }
    EXPECT_EQ(valueOf(negatedWord(wordOf(std::int64_t(1) << 32))), -(std::int64_t(1) << 32));
    EXPECT_EQ(valueOf(sumOfWords(wordOf(0xffffffff), wordOf(1))), std::int64_t(1) << 32);
}

TEST(RealOfWord, RoundsOnceAsTheProcessorDoes) {
    std::vector<std::int64_t> values = {0, 1, -1, 2, 3, 0xff, 0x100, INT64_MAX / 2, -(INT64_MAX / 2), std::int64_t(1) << 61};
    std::uint64_t state = 1;
    for (int i = 0; i < 50000; ++i) values.push_back(std::int64_t(nextRandom(state)) >> (2 + i % 61));
    // Ties, and a unit beside them, at every place.
    for (int place = 25; place < 62; ++place)
        for (int odd : {0, 1})
            for (int beside : {-1, 0, 1}) {
                const std::int64_t tie = ((std::int64_t(1) << 23 | odd) << (place - 23)) + (std::int64_t(1) << (place - 24));
                values.push_back(tie + beside);
                values.push_back(-(tie + beside));
            }
    for (const std::int64_t v : values)
        for (const int exponent : {0, -40, 37, -100}) {
            const float want = std::ldexp(float(v), exponent);
            ASSERT_EQ(realOfWord(wordOf(v), exponent), std::abs(want) < 0x1p-126f ? 0.0f : want) << v << " 2^" << exponent;
        }
    EXPECT_EQ(realOfWord(wordOf(1), -127), 0.0f) << "nothing subnormal";
    EXPECT_EQ(realOfWord(wordOf(3), -128), 0.0f) << "nothing subnormal";
    EXPECT_EQ(realOfWord(wordOf(1), -126), 0x1p-126f);
}

TEST(RowTimesBlock, IsExactBeforeItIsRounded) {
    std::uint64_t state = 7;
    const auto next = [&] { return int(std::int64_t(nextRandom(state)) >> 33) / 2; };
    for (int i = 0; i < 20000; ++i) {
        LongRow row{};
        row.m = {next(), next(), next()};
        row.exponent = -30;
        row.last = wordOf(std::int64_t(next()) * next());
        const ivec3 p(next(), next(), next());
        const auto product = [&](int k) { return std::int64_t(row.m[k]) * p[k]; };
        const std::int64_t sum = product(0) + product(1) + product(2) + valueOf(row.last);
        ASSERT_EQ(rowTimesBlock(row, p), std::ldexp(float(sum), -30));
    }
    EXPECT_EQ(blockPoint({0.5f, -1.5f, 2.5f}, 1.0f), ivec3(0, -2, 2));
}

TEST(SnapCoarsely, GoesToTheNearestSixteenthTiesToEven) {
    for (int k = -500; k <= 500; ++k) {
        const float pixels = float(k) / 512.0f;  // ties of 1/256 px, and every sixteenth one of 1/16 px
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
            if (double(x) + double(delta) != 1) continue;  // x is rounded: another argument
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

TEST(StandardDepth, IsOffByLessThanItsStepAndStaysAboveZero) {
    size_t moved = 0;
    for (float z = 1.0f; z > 0x1p-40f; z *= 0.997f) {
        const float kept = realOf(standardDepth(bitsOf(z)));
        EXPECT_LT(std::abs(double(kept) - double(z)), 0x1p-24) << z;
        EXPECT_GE(kept, 0x1p-24f);
        EXPECT_LE(kept, 1.0f);
        if (z >= 0.5f) {
            EXPECT_EQ(kept, z);
        }
        moved += kept != z;
    }
    EXPECT_GT(moved, 1000u);
    EXPECT_EQ(realOf(standardDepth(bitsOf(0x1p-60f))), 0x1p-24f) << "what is drawn is above 0";
    EXPECT_EQ(realOf(standardDepth(bitsOf(1.0f))), 1.0f);
}

TEST(FirstDrawn, TakesThemInTheirOrder) {
    for (int drawn = 0; drawn < 16; ++drawn) {
        int expected = 4;
        for (int i = 3; i >= 0; --i)
            if (drawn >> i & 1) expected = i;
        EXPECT_EQ(firstDrawn(drawn & 1, drawn & 2, drawn & 4, drawn & 8), expected) << drawn;
    }
}

// A power as Vulkan allows it: log2, its product with n, and exp2 as far off as they may be, either way.
TEST(NativePower, BoundHoldsForEveryPowerThatVulkanAllows) {
    for (double n = 1; n <= 1e6; n *= 4) {
        const auto power = float(n);
        const double bound = double(nativePowerBound(power));
        double most = 0;
        for (double t = 0; t <= 24; t += 0.0625) {
            const auto delta = float(t / n);
            if (!(delta < 1)) break;
            const float x = std::max(1.0f - delta, 0x1p-20f);
            const double truth = std::pow(1 - double(delta), n);
            const double log2OfX = std::log2(double(x)), off = x >= 0.5f ? 0x1p-21 : 3 * std::ldexp(1.0, std::ilogb(log2OfX) - 23);
            for (const double sign : {-1.0, 1.0}) {
                const auto p = double(float(n * (log2OfX + sign * off)));
                const double native = std::exp2(p) * (1 + sign * (3 + 2 * std::abs(p)) * 0x1p-23);
                most = std::max({most, std::abs(native - truth), std::abs(native - double(specularPower(delta, power, 0.0f)))});
            }
            EXPECT_LE(std::abs(double(nativePower(delta, power, 0.0f)) - double(specularPower(delta, power, 0.0f))), bound)
                << n << ' ' << delta;
        }
        EXPECT_LE(most, bound) << n;
        EXPECT_GT(most, bound / 8) << n << ": the bound is not an empty one";
    }
    for (const float n : {0.0f, 0.5f, 50.0f}) {
        const float zeroPower = n == 0 ? 1.0f : 0.0f;
        EXPECT_EQ(nativePower(0.0f, n, zeroPower), 1.0f);
        EXPECT_EQ(nativePower(1.0f, n, zeroPower), zeroPower);
        EXPECT_EQ(nativePower(2.0f, n, zeroPower), zeroPower);
    }
    EXPECT_EQ(nativePower(1.0f - 0x1p-22f, 0.5f, 0.0f), 0x1p-10f) << "no less than 2^-20, as specularPower has it";
    // The choice is what a light is added with.
    size_t apart = 0;
    for (int i = 1; i < 40; ++i) {
        const float angle = 0.01f * float(i), vx = std::sin(angle), vz = std::cos(angle);
        const Surface s{0, 0, 1, vx, 0, vz, 0, 0, 0};
        const Reflectance k{0, 0, 0, 1, 1, 1, 200, 0};
        const float delta = (vx * vx + 0.0f + (1 - vz) * (1 - vz)) * 0.5f;
        Colour c{};
        addLight({0, 0, 1, 0}, {1, 1, 1, 0}, s, k, {true, true, true, kPowerNative}, c);
        EXPECT_EQ(c.r, nativePower(delta, 200, 0));
        apart += c.r != specularPower(delta, 200, 0);
    }
    EXPECT_GT(apart, 5u);
}

TEST(NativeEncode, IsAnotherCodeOnlyNextToATie) {
    size_t near = 0;
    for (int i = 0; i <= 1 << 20; ++i) {
        const float x = float(i) / float(1 << 20);
        const double s = double(x) <= 0.0031308 ? 12.92 * double(x) : 1.055 * std::pow(double(x), 1 / 2.4) - 0.055;
        const int exact = int(std::floor(255 * s + 0.5)), native = encodeNative(x);
        const double fromTie = std::abs(255 * s + 0.5 - std::nearbyint(255 * s + 0.5));
        ASSERT_LE(std::abs(native - exact), fromTie > double(kNativeEncodeError) ? 0 : 1) << x;
        near += fromTie <= double(kNativeEncodeError);
    }
    EXPECT_GT(near, 100u) << "ties were met";
    EXPECT_EQ(encodeNative(-1.0f), 0);
    EXPECT_EQ(encodeNative(7.0f), 255);
    EXPECT_EQ(encodeNative(std::nanf("")), 0);
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
