// SPDX-License-Identifier: MIT
// Operations that `plumb devices --fingerprint` asks a device for, by number. The numbers choose a branch of the kernels by specialization
// constant, so each operation is a module of its own for the driver. What an answer should be stands in pipeline/fingerprint/ alone.
#ifndef PLUMB_FINGERPRINT_H
#define PLUMB_FINGERPRINT_H
#include "bridge.h"
SHARED_BEGIN

// Operations of fingerprint.comp: one question (four words) an invocation, one word of answer.
SHARED_CONST uint kAskAdd = 0u;
SHARED_CONST uint kAskSubtract = 1u;
SHARED_CONST uint kAskMultiply = 2u;
SHARED_CONST uint kAskDivide = 3u;
SHARED_CONST uint kAskSqrt = 4u;
SHARED_CONST uint kAskInverseSqrt = 5u;
SHARED_CONST uint kAskExp2 = 6u;
SHARED_CONST uint kAskLog2 = 7u;
SHARED_CONST uint kAskExp = 8u;
SHARED_CONST uint kAskLog = 9u;
SHARED_CONST uint kAskPow = 10u;
SHARED_CONST uint kAskSin = 11u;
SHARED_CONST uint kAskCos = 12u;
SHARED_CONST uint kAskFma = 13u;
SHARED_CONST uint kAskMod = 14u;
SHARED_CONST uint kAskDot = 15u;
SHARED_CONST uint kAskIntToFloat = 16u;
SHARED_CONST uint kAskUintToFloat = 17u;
SHARED_CONST uint kAskFloatToInt = 18u;
SHARED_CONST uint kAskFloatToUint = 19u;
SHARED_CONST uint kAskPackHalf = 20u;
SHARED_CONST uint kAskUnpackHalf = 21u;
SHARED_CONST uint kAskWholeNumbers = 22u;    // w: 0 floor, 1 ceil, 2 trunc, 3 round to even
SHARED_CONST uint kAskProductAndSum = 23u;   // x y + z
SHARED_CONST uint kAskSumLessSummand = 24u;  // (x + y) - x
SHARED_CONST uint kAskSignedZero = 25u;      // w: 0 x + y, 1 x - y, 2 x y
SHARED_CONST uint kAskCompare = 26u;         // bits: x == y, x != y, x < y, x >= y, isnan(x)
SHARED_CONST uint kAskMinMax = 27u;          // w: 0 min, 1 max
SHARED_CONST uint kAskInfinity = 28u;        // w: 0 x + y, 1 x - y, 2 x y, 3 x / y; a NaN is 0x7fc00000
SHARED_CONST uint kAskIntegerSum = 29u;      // w: 0 x + y, 1 x - y
SHARED_CONST uint kAskIntegerProduct = 30u;
SHARED_CONST uint kAskLongProduct = 31u;       // high word; w: 0 unsigned, 1 signed
SHARED_CONST uint kAskUnsignedQuotient = 32u;  // w: 0 x / y, 1 x % y
SHARED_CONST uint kAskSignedQuotient = 33u;
SHARED_CONST uint kAskShift = 34u;  // w: 0 left, 1 right, 2 right with sign
SHARED_CONST uint kAskBits = 35u;   // w: 0 count, 1 lowest, 2 highest, 3 reversed, 4 highest of a signed number

// Operations of fingerprint_run.comp: how the device runs a program. A question has kRunLanes invocations.
SHARED_CONST uint kRunLoops = 0u;    // x: iterations of the outer loop, y: of the inner one, z: of a loop behind; w: 0 count, 1 state
SHARED_CONST uint kRunStores = 1u;   // every invocation writes ~index at its index
SHARED_CONST uint kRunIndices = 2u;  // x: index into the words; reads there, and writes its own word
SHARED_CONST uint kRunMemory = 3u;   // words of the workgroup, read from the other end
SHARED_CONST uint kRunAtomics = 4u;
SHARED_CONST uint kRunLanes = 64u;  // a power of two

// Operations of fingerprint_subgroup.comp: bits of what does not hold, one word an invocation.
SHARED_CONST uint kSubgroupSize = 0u;  // lanes that a ballot counts
SHARED_CONST uint kSubgroupShuffle = 1u;
SHARED_CONST uint kSubgroupVote = 2u;
SHARED_CONST uint kSubgroupSum = 3u;
SHARED_CONST uint kSubgroupFloatSum = 4u;

struct FingerprintPush {
    uint statusSlot;
    uint items;
    uint base;  // of a kernel that makes its own questions: the bits of the first
};

// Value of lane `lane` in the questions about subgroups.
SHARED_FN uint laneValue(uint lane) { return ((lane * 0x9e3779b1u) >> 7) & 0xffffu; }
SHARED_FN uint laneFloatBits(uint lane) { return 0x41800000u + laneValue(lane) * 929u; }

SHARED_END
#endif
