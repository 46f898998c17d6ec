// SPDX-License-Identifier: MIT
// Correctly rounded (nearest even) division and square root, from any seed that is a few ULP off.
// Vulkan allows 2.5 ULP for `/` and about 4.5 for sqrt; the seed may be off by 7 ULP of the true result (docs/accuracy.md, The exact subset).
// Which form a device runs is a specialization constant; the recorder sets it from the start-up self-test.
// `nativeDivide` and `nativeRoot` are the only two functions of all modules in which `/` on floats and sqrt may stand.
//
// The emulated forms need normal operands (b != 0, no infinity, no NaN) and give only normal results; a numerator or
// radicand that is zero or subnormal counts as zero. Where a result could leave the normal range the caller snaps or
// refuses first.
#ifndef PLUMB_EXACT_H
#define PLUMB_EXACT_H
#include "bridge.h"
SHARED_BEGIN

SPECIALIZED(0, bool) kNativeDivide = true;
SPECIALIZED(1, bool) kNativeRoot = true;
SHARED_FN float nativeRoot(float a) { return sqrt(a); }
SHARED_FN float nativeDivide(float a, float b) { return a / b; }

// sign | significand * 2^(exponentField - 150), significand given with one guard bit below and rounded to even.
SHARED_FN float roundedToEven(uint sign, uint exponentField, uint significandWithGuard, bool sticky) {
    uint significand = significandWithGuard >> 1;
    // no plant: for the last !=, as no quotient or root of significands is a tie
    bool up = (significandWithGuard & 1u) != 0u && (sticky || (significand & 1u) != 0u);
    // A carry out of the significand runs into the exponent field, which is the wanted result.
    return realOf(int(sign | ((exponentField << 23) + (significand - 0x800000u) + pick(up, 1u, 0u))));
}

// Quotient a / b, correctly rounded. `seedErrorUlp` is 0 but in tests. There it moves the seed by -7 to 4 bit patterns, to show that the
// result does not depend on the seed. (A step past a power of two is two ULP of the result below it.)
SHARED_FN float emulatedDivide(float a, float b, int seedErrorUlp) {
    uint aBits = ubitsOf(a);
    uint bBits = ubitsOf(b);
    uint sign = (aBits ^ bBits) & 0x80000000u;
    uint aExponent = (aBits >> 23) & 255u;
    uint bExponent = (bBits >> 23) & 255u;
    uint aSignificand = (aBits & 0x7fffffu) | 0x800000u;
    uint bSignificand = (bBits & 0x7fffffu) | 0x800000u;
    bool below = aSignificand < bSignificand;
    uint scaleBits = pick(below, 25u, 24u);  // quotient = floor(aSignificand * 2^scaleBits / bSignificand) has 25 bits
    float seed = realOf(bitsOf(nativeDivide(float(aSignificand), float(bSignificand))) + seedErrorUlp);
    // Lower bound of the quotient: 16 units below the seed, of which 1 ULP is 2 units. The remainder, 0 <= remainder < 32 * bSignificand <
    // 2^29, is exact in wrapping 32-bit arithmetic.
    uint quotient = uint(seed * pick(below, 33554432.0f, 16777216.0f)) - 16u;
    uint remainder = (aSignificand << scaleBits) - quotient * bSignificand;
    bool take = remainder >= bSignificand << 4;
    remainder -= pick(take, bSignificand << 4, 0u);
    quotient += pick(take, 16u, 0u);
    take = remainder >= bSignificand << 3;
    remainder -= pick(take, bSignificand << 3, 0u);
    quotient += pick(take, 8u, 0u);
    take = remainder >= bSignificand << 2;
    remainder -= pick(take, bSignificand << 2, 0u);
    quotient += pick(take, 4u, 0u);
    take = remainder >= bSignificand << 1;
    remainder -= pick(take, bSignificand << 1, 0u);
    quotient += pick(take, 2u, 0u);
    take = remainder >= bSignificand;
    // no plant: from here on only whether anything remains counts, and only for ties, which do not occur
    remainder -= pick(take, bSignificand, 0u);
    quotient += pick(take, 1u, 0u);
    float result = roundedToEven(sign, aExponent + 127u - bExponent - pick(below, 1u, 0u), quotient, remainder != 0u);
    return pick(aExponent == 0u, realOf(int(sign)), result);
}

// Step of the root: takes `step` when (root + step)^2 still fits under the radicand. remainder = radicand - root^2.
SHARED_FN void rootStep(INOUT(uint) root, INOUT(uint) remainder, uint stepBits) {
    uint cost = ((root << 1) + (1u << stepBits)) << stepBits;
    bool take = remainder >= cost;
    remainder -= pick(take, cost, 0u);
    root += pick(take, 1u << stepBits, 0u);
}

SHARED_FN float emulatedRoot(float a, int seedErrorUlp) {
    uint bits = ubitsOf(a);
    uint exponentField = (bits >> 23) & 255u;
    uint significand = (bits & 0x7fffffu) | 0x800000u;
    bool odd = (exponentField & 1u) == 0u;  // the bias is odd: an even field is an odd exponent
    uint scaleBits = pick(odd, 26u, 25u);   // root = floor(sqrt(significand * 2^scaleBits)) has 25 bits
    float seed = nativeRoot(float(significand) * pick(odd, 67108864.0f, 33554432.0f));
    // Lower bound of the root, 16 units below the seed as in emulatedDivide(): 0 <= remainder < 32 * 2 * 2^25 = 2^31.
    uint root = uint(realOf(bitsOf(seed) + seedErrorUlp)) - 16u;
    uint remainder = (significand << scaleBits) - root * root;
    rootStep(root, remainder, 4u);
    rootStep(root, remainder, 3u);
    rootStep(root, remainder, 2u);
    rootStep(root, remainder, 1u);
    rootStep(root, remainder, 0u);
    float result = roundedToEven(0u, (exponentField + 127u) >> 1, root, remainder != 0u);
    return pick(exponentField == 0u, 0.0f, result);
}

SHARED_FN float exactDivide(float a, float b) {
    float quotient;
    // no plant: both forms give the same bits
    if (kNativeDivide)
        quotient = nativeDivide(a, b);
    else
        quotient = emulatedDivide(a, b, 0);
    return quotient;
}
SHARED_FN float exactRoot(float a) {
    float root;
    // no plant: both forms give the same bits
    if (kNativeRoot)
        root = nativeRoot(a);
    else
        root = emulatedRoot(a, 0);
    return root;
}

// Flushes |x| < 2^-103 to +0, whatever the driver made of a subnormal product. Sums of flushed values need no flush: they are multiples of
// 2^-126, so 0 or normal (docs/accuracy.md, The exact subset).
SHARED_FN float snapTiny(float x) {
    int bits = bitsOf(x);
    return realOf(pick((bits & 0x7fffffff) < 0x0c000000, 0, bits));
}

SHARED_END
#endif
