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
    float y;  // likewise
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
    uint uintOfFloat;  // of |converted|
    uint unsignedHigh;
    uint unsignedLow;
    int signedHigh;
    int signedLow;
    float nativeQuotient;
    float nativeRoot;  // of |x|
    float emulatedQuotient;
    float emulatedRoot;
};

// Of binary64, each number as two words. Asked only of a device that shall transform in it.
SHARED_CONST uint kDoubleVectors = 4096u;
struct DoubleVector {
    uint aLow, aHigh, bLow, bHigh;  // |a|, |b| in [2^-60, 2^60]
    float x;                        // likewise
};
struct DoubleAnswer {
    uint sumLow, sumHigh;          // a + b
    uint productLow, productHigh;  // a x
    uint bothLow, bothHigh;        // a x + b as two operations: shows a contraction
    float rounded;                 // a as float32
};

struct CanaryAnswer {
    uint iterations;
    uint state;  // of the generator below after so many iterations
    float sum;
    float product;
    float quotient;
    float root;
};

struct SelfTestPush {
    uint statusSlot;
    uint iterations;  // of the canary loop; unknown to the compiler
};

// Numerical Recipes' generator: no closed form a compiler would replace the loop with.
SHARED_FN uint nextState(uint state) { return state * 1664525u + 1013904223u; }
SHARED_FN float canaryOperand(uint lane, uint salt) { return realOf(int(0x3f800000u + (lane * 0x9e3779u + salt) % 0x1000000u)); }

SHARED_END
#endif
