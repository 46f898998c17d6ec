// SPDX-License-Identifier: MIT
// Records of the start-up self-test and of the canaries. What each answer should be is written twice: in selftest.comp
// for the device, in host/selftest.cpp with the host's own IEEE arithmetic.
#ifndef PLUMB_SELFTEST_H
#define PLUMB_SELFTEST_H
#include "bridge.h"
SHARED_BEGIN

SHARED_CONST uint kSelfTestGroupSize = 64u;
SHARED_CONST uint kSelfTestVectors = 65536u;
SHARED_CONST uint kCanaryLanes = 8u;
SHARED_CONST uint kCanaryIterations = 80000u;  // above the 65,535 at which lavapipe ends loops in silence

struct SelfTestVector {
    float x;  // normal, |x| in [2^-60, 2^60], so every answer is normal or zero
    float y;  // normal, |y| in [2^-60, 2^60]
    uint i;
    uint j;
    float converted;  // |converted| < 2^31
};

struct SelfTestAnswer {
    float sum;
    float difference;
    float product;
    float sumOfProducts;  // x * y + x as two operations: shows a contraction
    float floatOfInt;
    float floatOfUint;
    int intOfFloat;
    uint uintOfFloat;  // |converted| as an integer
    uint unsignedHigh;
    uint unsignedLow;
    int signedHigh;
    int signedLow;
    float nativeQuotient;
    float nativeRoot;  // square root of |x|
    float emulatedQuotient;
    float emulatedRoot;
};

// Vectors of the self-test of binary64, each number as two words. It runs only on a device that shall transform in binary64.
SHARED_CONST uint kDoubleVectors = 4096u;
struct DoubleVector {
    uint aLow, aHigh, bLow, bHigh;  // |a|, |b| in [2^-60, 2^60]
    float x;                        // normal, |x| in [2^-60, 2^60]
};
struct DoubleAnswer {
    uint sumLow, sumHigh;          // words of a + b
    uint productLow, productHigh;  // words of a x
    uint bothLow, bothHigh;        // words of a x + b as two operations: shows a contraction
    float rounded;                 // a as float32
};

struct CanaryAnswer {
    uint iterations;
    uint state;  // state of the generator nextState() after `iterations` steps
    float sum;
    float product;
    float quotient;
    float root;
};

struct SelfTestPush {
    uint statusSlot;
    uint iterations;  // iterations of the canary loop; unknown to the compiler
};

// Numerical Recipes' generator: no closed form a compiler would replace the loop with.
SHARED_FN uint nextState(uint state) { return state * 1664525u + 1013904223u; }
SHARED_FN float canaryOperand(uint lane, uint salt) { return realOf(int(0x3f800000u + (lane * 0x9e3779u + salt) % 0x1000000u)); }

SHARED_END
#endif
