// SPDX-License-Identifier: MIT
// Contract of the encode pass: linear RGB -> 8-bit codes. sRGB is the number of thresholds not above the value: threshold c is
// the least float whose exact sRGB code is nearer c than c - 1, so every float gets its correctly rounded code (no pow).
// The device reads one word a bucket of 2^16 floats: no bucket holds two thresholds (tests/unit/encode_test.cpp shows it).
#ifndef PLUMB_ENCODE_H
#define PLUMB_ENCODE_H
#include "bridge.h"
SHARED_BEGIN

SHARED_CONST uint kEncodeSrgb = 0u;
SHARED_CONST uint kEncodeLinear = 1u;
SHARED_CONST uint kEncodeNative = 2u;          // sRGB by the device's pow
SHARED_CONST int kEncodeFirstBucket = 0x3900;  // float bits >> 16 of the first bucket: 1.2e-4, below the first threshold
SHARED_CONST int kEncodeBuckets = 1665;        // buckets from the first up to and with that of 1.0

// Clamps to [0, 1]; NaN gives 0.
SHARED_FN Real clampUnit(Real x) {
    x = pick(gt(x, real(0.0f)), x, real(0.0f));
    return pick(gt(real(1.0f), x), x, real(1.0f));
}

// Nearest code, halves to even, as the notes' `round` does: 76.5 is 76. The constant is 3 * 2^22, where floats have steps of 1. So the
// addition rounds (IEEE 754, nearest even), and the subtraction is exact.
SHARED_FN Int encodeLinear(Real x) { return toInt((clampUnit(x) * 255.0f + 12582912.0f) - 12582912.0f); }

// Nearest code by the curve of IEC 61966-2-1 and the device's power.
// For |log2 x| <= 8.4 the power has a relative error of at most 20 2^-23 (nativePowerBound, shade.h, with n = 1/2.4). The code before
// rounding is then off by at most 255 * 1.055 * 20 2^-23 = 6.5e-4, and by 3e-4 more for the float32 operations around it.
// The code differs from the correctly rounded one only where that one is within kNativeEncodeError of a tie, and then by 1.
SHARED_CONST float kNativeEncodeError = 0.001f;  // steps, before rounding
SHARED_FN Int encodeNative(Real x) {
    Real c = clampUnit(x);
    Real curve = nativePow(c, real(0.416666657f)) * 1.055f - 0.055f;
    return toInt(pick(gt(c, real(0.0031308f)), curve, c * 12.92f) * 255.0f + 0.5f);
}

// Index of the bucket of a value in [0, 1].
SHARED_FN Int encodeBucket(Real clamped) { return max((bitsOf(clamped) >> 16) - kEncodeFirstBucket, 0); }

// A bucket's word: code below its threshold << 17 | low 16 bits of the threshold (2^16: no threshold here).
SHARED_FN Int encodeInBucket(Real clamped, Int word) {
    Int below = word >> 17;
    Int low = bitsOf(clamped) & 0xffff;
    // 1 when low >= threshold: the sign of low - threshold
    return below + (((low - (word & 0x1ffff)) >> 31) + 1);
}

SHARED_END
#endif
