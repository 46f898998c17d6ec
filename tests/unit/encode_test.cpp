// SPDX-License-Identifier: MIT
// The arithmetic that both sides share, against witnesses in long double that share none of it.
#include "pipeline/passes/encode.h"

#include "shaders/shared/fixed_point.h"
#include "shaders/shared/shade.h"
#include "shaders/shared/transform.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ios>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace plumb {
namespace {

constexpr float kUnitRoundoff = 0x1p-24f;  // u of binary32

// The sRGB code of a linear value before rounding: IEC 61966-2-1, the direction opposite to the one that the table is made from.
long double exactCode(long double linear) {
    return 255.0L * (linear <= 0.0031308L ? 12.92L * linear : 1.055L * std::pow(linear, 1.0L / 2.4L) - 0.055L);
}

// As the device: clamp, look the bucket up, compare once.
uint32_t encodeByBucket(float linear) {
    const float clamped = gpu::clampUnit(linear);
    return uint32_t(gpu::encodeInBucket(clamped, int(srgbBucketTable()[size_t(gpu::encodeBucket(clamped))])));
}

float floatOf(uint32_t bits) { return std::bit_cast<float>(bits); }

TEST(Encode, ThresholdsAreTheLeastFloatsOfTheirCodes) {
    for (uint32_t code = 1; code < 256; ++code) {
        // The least float whose exact code is at least code - 1/2; floats in [0, 1] are ordered as their bits are.
        uint32_t below = 0, atLeast = std::bit_cast<uint32_t>(1.0f);
        while (atLeast - below > 1) {
            const uint32_t middle = (below + atLeast) / 2;
            (exactCode(floatOf(middle)) >= code - 0.5L ? atLeast : below) = middle;
        }
        EXPECT_EQ(std::bit_cast<uint32_t>(srgbThresholds()[code]), atLeast) << "threshold of code " << code;
    }
}

// The linear piece of the curve ends between two thresholds, so which of IEC's two rounded joints is used does not matter; and no
// exact threshold lies so close to a float that long double could fall on the wrong side of it.
TEST(Encode, NoThresholdIsInDoubt) {
    for (uint32_t code = 1; code < 256; ++code) {
        const float t = srgbThresholds()[code];
        // pow in long double errs by a few units in its 64th bit: 2^-60 of the code is far above that.
        EXPECT_GT(std::abs(exactCode(t) - (code - 0.5L)), code * 0x1p-60L) << code;
        EXPECT_GT(std::abs(exactCode(std::nextafter(t, 0.0f)) - (code - 0.5L)), code * 0x1p-60L) << code;
    }
    const std::array<float, 256>& t = srgbThresholds();
    for (size_t code = 1; code < 256; ++code) EXPECT_FALSE(t[code] > 0.00313f && t[code] < 0.003132f) << "the joint of the curve";
}

TEST(Encode, NoBucketHoldsTwoThresholds) {
    int last = -1;
    for (size_t code = 1; code < 256; ++code) {
        const int bucket = gpu::encodeBucket(srgbThresholds()[code]);
        EXPECT_GT(bucket, last) << "codes " << code - 1 << " and " << code;
        last = bucket;
    }
    ASSERT_EQ(srgbBucketTable().size(), size_t(gpu::kEncodeBuckets));
    EXPECT_EQ(gpu::encodeBucket(1.0f), gpu::kEncodeBuckets - 1);
    EXPECT_EQ(gpu::encodeBucket(0.0f), 0);
}

void expectSameCode(uint32_t bits) {
    const float f = floatOf(bits);
    ASSERT_EQ(encodeByBucket(f), encodeSrgbCpu(f)) << "of " << f << ", bits " << std::hex << bits;
}

TEST(Encode, BucketsAgreeWithTheSearchAroundEveryThreshold) {
    constexpr uint32_t kAround = 1000;
    for (size_t code = 1; code < 256; ++code) {
        const uint32_t at = std::bit_cast<uint32_t>(srgbThresholds()[code]);
        for (uint32_t bits = at - kAround; bits <= at + kAround; ++bits) expectSameCode(bits);
        EXPECT_EQ(encodeSrgbCpu(floatOf(at)), code);
        EXPECT_EQ(encodeSrgbCpu(floatOf(at - 1)), code - 1);
    }
}

TEST(Encode, BucketsAgreeWithTheSearchInStepsOverAllFloats) {
    constexpr uint32_t kStep = 997;  // a prime: every bucket boundary is approached at another distance
    uint32_t bits = 0;
    do expectSameCode(bits);
    while (!HasFatalFailure() && (bits += kStep) >= kStep);
    for (int bucket = 0; bucket < gpu::kEncodeBuckets; ++bucket)
        for (uint32_t low : {0u, 1u, 0xfffeu, 0xffffu}) expectSameCode(uint32_t(bucket + gpu::kEncodeFirstBucket) << 16 | low);
}

// All 2^32 floats; minutes, so only with PLUMB_LONG=1 (toolchain/test.sh --long); else every 65,537th.
TEST(Encode, LONG_BucketsAgreeWithTheSearchForAllFloats) {
    const char* asked = std::getenv("PLUMB_LONG");
    const uint64_t step = asked && *asked == '1' ? 1 : 65537;
    for (uint64_t bits = 0; bits <= 0xffffffffu; bits += step) {
        const float f = floatOf(uint32_t(bits));
        if (encodeByBucket(f) != encodeSrgbCpu(f)) expectSameCode(uint32_t(bits));
        if (HasFatalFailure()) return;
    }
}

TEST(Encode, ExtremesAreClamped) {
    for (float f : {-0.0f, -1.0f, -INFINITY, std::numeric_limits<float>::quiet_NaN(), floatOf(1)}) {
        EXPECT_EQ(encodeByBucket(f), 0u) << f;
        EXPECT_EQ(encodeSrgbCpu(f), 0u) << f;
        EXPECT_EQ(gpu::encodeLinear(f), 0) << f;
    }
    for (float f : {1.0f, 2.0f, std::numeric_limits<float>::max(), INFINITY}) {
        EXPECT_EQ(encodeByBucket(f), 255u) << f;
        EXPECT_EQ(encodeSrgbCpu(f), 255u) << f;
        EXPECT_EQ(gpu::encodeLinear(f), 255) << f;
    }
}

// The product 255 x is rounded to float32, below 256 by 2^-17 at most; then the code is the nearest, a half the even one. By whole numbers from
// the bits of x: 255 x = m 2^e exactly.
constexpr long double kLinearProductError = 0x1p-17L;
int linearCodeOf(float x) {
    if (!(x > 0)) return 0;
    if (x >= 1) return 255;
    const uint32_t bits = std::bit_cast<uint32_t>(x);
    const int exponent = std::max(1, int(bits >> 23)) - 150;  // x = significand 2^exponent, exponent <= -24
    if (exponent < -24 - 12) return 0;                        // 255 x below 1/8
    const uint64_t product = 255 * uint64_t((bits & 0x7fffffu) | 0x800000u);
    const auto halfToEven = [](uint64_t value, int drop) {
        const uint64_t whole = value >> drop, rest = value & ((uint64_t(1) << drop) - 1), half = uint64_t(1) << (drop - 1);
        return whole + (rest > half || (rest == half && (whole & 1)) ? 1 : 0);
    };
    const int drop = int(std::bit_width(product)) - 24;  // to float32
    const uint64_t rounded = halfToEven(product, drop);
    return int(halfToEven(rounded, -(exponent + drop)));
}
void expectLinear(uint32_t bits) {
    const float f = floatOf(bits);
    ASSERT_EQ(gpu::encodeLinear(f), linearCodeOf(f)) << f;
    if (f >= 0 && f <= 1) {
        ASSERT_LE(std::abs(gpu::encodeLinear(f) - 255.0L * f), 0.5L + kLinearProductError) << f;
    }
}

TEST(Encode, LinearCodesAreTheNearestAndHalvesTheEvenOnes) {
    for (int code = 0; code < 256; ++code) EXPECT_EQ(gpu::encodeLinear(float(code) / 255.0f), code);
    // A half that float32 has: 255 x is a half for the float nearest to it.
    int halves = 0;
    for (int code = 0; code < 255; ++code) {
        const float x = (float(code) + 0.5f) / 255.0f;
        if (x * 255.0f != float(code) + 0.5f) continue;
        ++halves;
        EXPECT_EQ(gpu::encodeLinear(x), code + code % 2) << code;
    }
    EXPECT_GT(halves, 200);
    EXPECT_EQ(gpu::encodeLinear(0.3f), 76) << "76.5";
    for (uint64_t bits = 0; bits <= 0xffffffffu && !HasFatalFailure(); bits += 997) expectLinear(uint32_t(bits));
}

// All 2^32 floats with PLUMB_LONG=1.
TEST(Encode, LONG_LinearCodesAreTheNearestForAllFloats) {
    const char* asked = std::getenv("PLUMB_LONG");
    const uint64_t step = asked && *asked == '1' ? 1 : 65537;
    for (uint64_t bits = 0; bits <= 0xffffffffu; bits += step) {
        const float f = floatOf(uint32_t(bits));
        if (gpu::encodeLinear(f) != linearCodeOf(f)) expectLinear(uint32_t(bits));
        if (HasFatalFailure()) return;
    }
}

TEST(Encode, PixelsAreBytesInOrder) {
    const float colour[3] = {1.0f, 0.0f, 0.5f};
    EXPECT_EQ(encodePixelCpu(gpu::kEncodeSrgb, colour, 0x7f), 0x7fbc00ffu);
    EXPECT_EQ(encodePixelCpu(gpu::kEncodeLinear, colour, 255), 0xff8000ffu);
}

// shade.h: relative error below 4 u, and exact scaling by powers of four.
TEST(Shade, ReciprocalRootKeepsItsBound) {
    std::mt19937 engine(5);
    const auto check = [](float x) {
        const long double exact = 1.0L / std::sqrt(static_cast<long double>(x));
        ASSERT_LT(std::abs(gpu::reciprocalRoot(x) - exact) / exact, 4 * kUnitRoundoff) << x;
        ASSERT_LT(std::abs(gpu::reciprocal(x) * static_cast<long double>(x) - 1), 9 * kUnitRoundoff) << x;
        ASSERT_EQ(gpu::reciprocalRoot(x * 4) * 2, gpu::reciprocalRoot(x)) << x;
    };
    for (int i = 0; i < 2000000; ++i) check(floatOf(0x3f800000u + engine() % 0x1000000u));  // two octaves: all others are scaled
    for (int e = -120; e < 120; ++e) check(std::ldexp(1.37f, e));
    for (uint32_t bits = 0x3f800000u; bits < 0x3f800000u + 4096; ++bits) check(floatOf(bits));
    EXPECT_TRUE(std::isfinite(gpu::reciprocalRoot(0.0f)));
}

// shade.h: the polynomials err by 1.7e-7 (log2, relative) and 7.5e-8 (exp2). With p = n log2(1 - delta) the power errs by
// p ln 2 (1.7e-7 + roundings) + 7.5e-8 + roundings: evaluating y x + e and n times it rounds a handful of times.
constexpr long double kLogError = 1.7e-7L + 6 * 0x1p-24L;
constexpr long double kExpError = 7.5e-8L + 6 * 0x1p-24L;
long double powerBound(long double p) { return std::abs(p) * 0.6931472L * kLogError + kExpError; }

TEST(Shade, SpecularPowerKeepsItsBound) {
    std::mt19937 engine(9);
    const std::vector<float> exponents = {0, 0.5f, 1, 2, 3.5f, 10, 32, 100, 1000, 5e3f, 65536, 1e6f};
    long double worst = 0;
    for (float n : exponents)
        for (int i = 0; i < 100000; ++i) {
            // Deltas of every size: most of a highlight lies where n delta is about 1.
            const float delta = i % 2 ? float(engine()) * 0x1p-32f : std::ldexp(1.0f + float(engine()) * 0x1p-32f, -int(engine() % 40) - 1);
            if (delta > 1 - 0x1p-20f) continue;  // below, the contract's clamp
            const long double p = n * std::log2(1.0L - delta), exact = std::exp2(p);
            const long double got = gpu::specularPower(delta, n, n == 0 ? 1.0f : 0.0f);
            if (p < -119) {
                ASSERT_LE(got, 0x1p-118L);  // the contract's least power
                continue;
            }
            const long double share = std::abs(got - exact) / exact / powerBound(p);
            worst = std::max(worst, share);
            ASSERT_LE(share, 1) << "n " << n << ", delta " << delta << ": " << double(got) << " for " << double(exact);
        }
    RecordProperty("worst_share_of_the_bound", std::to_string(double(worst)));
}

TEST(Shade, SpecularPowerAtItsEnds) {
    for (float n : {0.0f, 0.5f, 1.0f, 32.0f, 1e6f}) {
        const float zeroPower = n == 0 ? 1.0f : 0.0f;
        EXPECT_EQ(gpu::specularPower(0.0f, n, zeroPower), 1.0f) << n;
        EXPECT_EQ(gpu::specularPower(1.0f, n, zeroPower), zeroPower) << n;  // R.V = 0
        EXPECT_EQ(gpu::specularPower(2.0f, n, zeroPower), zeroPower) << n;  // R.V = -1
        EXPECT_LE(gpu::specularPower(0x1p-24f, n, zeroPower), 1.0f) << n;
        const float justInside = gpu::specularPower(std::nextafter(1.0f, 0.0f), n, zeroPower);
        EXPECT_TRUE(std::isfinite(justInside) && justInside >= 0.0f && justInside <= 1.0f) << n;
    }
}

TEST(FixedPoint, SnapsToTheNearestSubpixelTiesToEven) {
    const float limit = 1000;
    for (int half = -2001; half <= 2001; ++half) {
        const int want = half % 2 == 0 ? half / 2 : 2 * int(std::lround(double(half) / 4));
        EXPECT_EQ(gpu::snapToSubpixel(float(half) / 512.0f, limit), want) << half;
    }
    EXPECT_EQ(gpu::snapToSubpixel(1e30f, limit), 256000);
    EXPECT_EQ(gpu::snapToSubpixel(-INFINITY, limit), -256000);
    EXPECT_EQ(gpu::snapToSubpixel(std::numeric_limits<float>::quiet_NaN(), limit), -256000);
}

TEST(FixedPoint, PixelsOfABoxAreThoseWhoseCentresItHolds) {
    for (int low = -600; low <= 600; ++low) {
        int first = -4, last = 4;
        while (256 * first + 128 < low) ++first;
        while (256 * last + 128 > low) --last;
        EXPECT_EQ(gpu::firstPixel(low), first) << low;
        EXPECT_EQ(gpu::lastPixel(low), last) << low;
    }
}

// Two triangles on both sides of an edge: exactly one of them owns a sample on it.
TEST(FixedPoint, OneOfTwoNeighboursOwnsTheirEdge) {
    for (int a = -3; a <= 3; ++a)
        for (int b = -3; b <= 3; ++b)
            if (a != 0 || b != 0) {
                EXPECT_EQ(gpu::edgeBias(a, b) + gpu::edgeBias(-a, -b), 1) << a << ' ' << b;
            }
    EXPECT_EQ(gpu::edgeBias(1, 0), 0);  // a left edge: the interior is at greater x
    EXPECT_EQ(gpu::edgeBias(0, 1), 0);  // a top edge: the interior is at greater y
}

TEST(FixedPoint, NarrowTrianglesFitThirtyTwoBits) {
    // The claim of fixed_point.h: with its tiles added on every side the box is below 2^23 pixels and 2^22 sub-pixels long.
    for (int w = 1; w <= 8192; w += 61) {
        const int h = std::min(8192, (gpu::kNarrowAreaPixels - 1) / w);
        const bool narrow = gpu::isNarrow((w - 1) * 256, (h - 1) * 256);
        EXPECT_TRUE(narrow || h == 8192 || w * h >= gpu::kNarrowAreaPixels) << w << 'x' << h;
        if (narrow) {
            EXPECT_LT(int64_t(w + 32) * (h + 24), int64_t(1) << 23) << w << 'x' << h;
        }
    }
    EXPECT_FALSE(gpu::isNarrow(gpu::kNarrowExtent, 0));
    EXPECT_FALSE(gpu::isNarrow(0, gpu::kNarrowExtent));
    EXPECT_TRUE(gpu::isNarrow(gpu::kNarrowExtent - 1, 256));
    EXPECT_FALSE(gpu::isNarrow(gpu::kNarrowExtent - 1, gpu::kNarrowExtent - 1));
}

}  // namespace
}  // namespace plumb
