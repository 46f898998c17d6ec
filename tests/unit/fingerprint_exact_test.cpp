// SPDX-License-Identifier: MIT
// The arithmetic that judges devices: against hard cases whose results were computed by other means, and against itself.
#include "pipeline/fingerprint/exact.h"
#include "pipeline/fingerprint/functions.h"
#include "pipeline/fingerprint/traits.h"

#include <gtest/gtest.h>
#include <bit>
#include <cmath>
#include <cstdint>
#include <ios>
#include <string>
#include <vector>

namespace plumb {
namespace {

uint32_t bits(float x) { return std::bit_cast<uint32_t>(x); }
float valueOf(uint32_t x) { return std::bit_cast<float>(x); }

// Any float32, often with its significand at an end.
uint32_t anyFloat(fingerprint::Draw& d) {
    switch (d.below(4)) {
        case 0:
            return d.word();
        case 1:
            return (d.word() & 0x80000000u) | d.below(0x01000000u);  // subnormal, or near to it
        default:
            return d.real(-126, 127);
    }
}

void expectSame(uint32_t got, float want, const char* what, uint32_t x, uint32_t y) {
    if (std::isnan(want))
        EXPECT_EQ(got, 0x7fc00000u) << what << std::hex << " " << x << " " << y;
    else
        EXPECT_EQ(got, bits(want)) << what << std::hex << " " << x << " " << y;
}

// The processor's own arithmetic is IEEE 754: a witness that shares nothing with the integers.
TEST(FingerprintExact, RoundsAsTheProcessorDoes) {
    for (uint32_t i = 0; i < 300000; ++i) {
        fingerprint::Draw d("witness", i);
        const uint32_t x = anyFloat(d), y = anyFloat(d), z = anyFloat(d);
        const Exact a = exactOf(x), b = exactOf(y);
        ASSERT_TRUE(std::isnan(valueOf(x)) || nearestFloat(a) == x) << std::hex << x;
        expectSame(nearestFloat(plus(a, b)), valueOf(x) + valueOf(y), "sum", x, y);
        expectSame(nearestFloat(plus(a, negated(b))), valueOf(x) - valueOf(y), "difference", x, y);
        expectSame(nearestFloat(times(a, b)), valueOf(x) * valueOf(y), "product", x, y);
        expectSame(nearestFloat(over(a, b)), valueOf(x) / valueOf(y), "quotient", x, y);
        expectSame(nearestFloat(rootOf(a)), std::sqrt(valueOf(x)), "root", x, 0);
        expectSame(nearestFloat(plus(times(a, b), exactOf(z))), std::fma(valueOf(x), valueOf(y), valueOf(z)), "fma", x, y);
        if (HasFailure()) return;
    }
}

TEST(FingerprintExact, RemaindersAreThoseOfTheFloor) {
    for (uint32_t i = 0; i < 100000; ++i) {
        fingerprint::Draw d("remainders", i);
        const uint32_t x = d.real(-20, 40), y = d.real(-20, 40);
        // fmod is exact, whatever the processor.
        float want = std::fmod(valueOf(x), valueOf(y));
        if (want != 0 && (want < 0) != (valueOf(y) < 0)) {
            if (std::abs(double(want) + double(valueOf(y)) - double(want + valueOf(y))) != 0) continue;  // the sum is no float32
            want += valueOf(y);
        }
        const uint32_t got = nearestFloat(modulo(exactOf(x), exactOf(y)));
        ASSERT_EQ(valueOf(got), want) << std::hex << x << " " << y;
    }
}

struct Hard {
    const char* function;
    uint32_t x, y, want;
};
// Arguments whose result lies nearest to the middle of two float32 among many, large angles, ends of ranges; results by another program
// with 400 bits (tests/oracle/fingerprint_witness.py writes these rows).
constexpr Hard kHard[] = {
#include "tests/unit/fingerprint_hard_cases.inc"
};

Exact resultOf(const Hard& h) {
    const std::string f = h.function;
    return f == "exp2"   ? exp2Of(h.x)
           : f == "exp"  ? expOf(h.x)
           : f == "log2" ? log2Of(h.x)
           : f == "log"  ? logOf(h.x)
           : f == "sin"  ? sinOf(h.x)
           : f == "cos"  ? cosOf(h.x)
           : f == "pow"  ? powOf(h.x, h.y)
                         : inverseRootOf(exactOf(h.x));
}

TEST(FingerprintExact, HardCasesRoundRight) {
    EXPECT_GT(std::size(kHard), 300u);
    for (const Hard& h : kHard) EXPECT_EQ(nearestFloat(resultOf(h)), h.want) << h.function << " " << std::hex << h.x << " " << h.y;
}

TEST(FingerprintExact, PowersOfPowersAreTies) {
    EXPECT_EQ(nearestFloat(powOf(bits(9), bits(0.5f))), bits(3));
    EXPECT_EQ(nearestFloat(powOf(bits(3), bits(4))), bits(81));
    // 4097^2 = 2^24 + 2^13 + 1 lies in the middle of two float32.
    EXPECT_TRUE(isTie(powOf(bits(4097), bits(2))));
    EXPECT_EQ(nearestFloat(powOf(bits(4097), bits(2))), bits(16785408));
}

TEST(FingerprintExact, DistancesAreInUlpOfTheResult) {
    const Exact third = over(exactOf(bits(1)), exactOf(bits(3)));
    // The float32 lies above; what is counted is cut off to whole units.
    EXPECT_EQ(distance(third, bits(1.0f / 3)), kUlp / 3 + 1);
    EXPECT_EQ(distance(third, bits(1.0f / 3) + 1), kUlp / 3 + 1 + kUlp);
    EXPECT_EQ(distance(exactOf(bits(1)), bits(1) - 1), kUlp / 2) << "an ULP of 1 is two steps below it";
    EXPECT_EQ(distance(exactOf(bits(1)), 0x7fc00000u), kMostUlps);
    EXPECT_EQ(distance(exactOf(bits(1)), 0x7f800000u), kMostUlps);
    EXPECT_EQ(distance(exactOf(bits(1)), bits(-1)), 2 * (kUlp << 23));
    EXPECT_EQ(distance(exactOf(0x80000000u), 0), 0u) << "the sign of a zero is a trait of its own";
    EXPECT_EQ(ulpsOfPower(-23, exactOf(bits(1))), kUlp);
}

}  // namespace
}  // namespace plumb
