// SPDX-License-Identifier: MIT
// One operation on one question an invocation, for `plumb devices --fingerprint`. Outside the exact subset on purpose: it asks what each
// operation of the device gives. The variant _loose has no NoContraction, _sweep makes its operands from their bits.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/fingerprint.h"

layout(constant_id = 2) const uint kOperation = 0u;

layout(push_constant, scalar) uniform Push { FingerprintPush push; };
#ifdef PLUMB_SWEEP
layout(binding = 1, scalar) writeonly buffer Answers { uint answers[]; };
#else
layout(binding = 1, scalar) readonly buffer Questions { uvec4 questions[]; };
layout(binding = 2, scalar) buffer Answers { uint answers[]; };
#endif

uint answerTo(uvec4 q) {
    float x = uintBitsToFloat(q.x), y = uintBitsToFloat(q.y), z = uintBitsToFloat(q.z);
    if (kOperation == kAskAdd) return floatBitsToUint(x + y);
    if (kOperation == kAskSubtract) return floatBitsToUint(x - y);
    if (kOperation == kAskMultiply) return floatBitsToUint(x * y);
    if (kOperation == kAskDivide) return floatBitsToUint(x / y);
    if (kOperation == kAskSqrt) return floatBitsToUint(sqrt(x));
    if (kOperation == kAskInverseSqrt) return floatBitsToUint(inversesqrt(x));
    if (kOperation == kAskExp2) return floatBitsToUint(exp2(x));
    if (kOperation == kAskLog2) return floatBitsToUint(log2(x));
    if (kOperation == kAskExp) return floatBitsToUint(exp(x));
    if (kOperation == kAskLog) return floatBitsToUint(log(x));
    if (kOperation == kAskPow) return floatBitsToUint(pow(x, y));
    if (kOperation == kAskSin) return floatBitsToUint(sin(x));
    if (kOperation == kAskCos) return floatBitsToUint(cos(x));
    if (kOperation == kAskFma) return floatBitsToUint(fma(x, y, z));
    if (kOperation == kAskMod) return floatBitsToUint(mod(x, y));
    if (kOperation == kAskDot) return floatBitsToUint(dot(vec2(x, y), vec2(z, uintBitsToFloat(q.w))));
    if (kOperation == kAskIntToFloat) return floatBitsToUint(float(int(q.x)));
    if (kOperation == kAskUintToFloat) return floatBitsToUint(float(q.x));
    if (kOperation == kAskFloatToInt) return uint(int(x));
    if (kOperation == kAskFloatToUint) return uint(x);
    if (kOperation == kAskPackHalf) return packHalf2x16(vec2(x, y));
    if (kOperation == kAskUnpackHalf) return floatBitsToUint(unpackHalf2x16(q.x).y);
    if (kOperation == kAskWholeNumbers) {
        float whole = q.w == 0u ? floor(x) : q.w == 1u ? ceil(x) : q.w == 2u ? trunc(x) : roundEven(x);
        return floatBitsToUint(whole);
    }
    if (kOperation == kAskProductAndSum) return floatBitsToUint(x * y + z);
    if (kOperation == kAskSumLessSummand) return floatBitsToUint((x + y) - x);
    if (kOperation == kAskSignedZero) return floatBitsToUint(q.w == 0u ? x + y : q.w == 1u ? x - y : x * y);
    if (kOperation == kAskCompare) {
        uint bits = x == y ? 1u : 0u;
        bits |= x != y ? 2u : 0u;
        bits |= x < y ? 4u : 0u;
        bits |= x >= y ? 8u : 0u;
        bits |= isnan(x) ? 16u : 0u;
        return bits;
    }
    if (kOperation == kAskMinMax) return floatBitsToUint(q.w == 0u ? min(x, y) : max(x, y));
    if (kOperation == kAskInfinity) {
        float r = q.w == 0u ? x + y : q.w == 1u ? x - y : q.w == 2u ? x * y : x / y;
        return isnan(r) ? 0x7fc00000u : floatBitsToUint(r);
    }
    if (kOperation == kAskIntegerSum) return q.w == 0u ? q.x + q.y : q.x - q.y;
    if (kOperation == kAskIntegerProduct) return q.x * q.y;
    if (kOperation == kAskLongProduct) {
        uint high, low;
        int signedHigh, signedLow;
        umulExtended(q.x, q.y, high, low);
        imulExtended(int(q.x), int(q.y), signedHigh, signedLow);
        return q.w == 0u ? high : uint(signedHigh);
    }
    if (kOperation == kAskUnsignedQuotient) return q.w == 0u ? q.x / q.y : q.x % q.y;
    if (kOperation == kAskSignedQuotient) return uint(q.w == 0u ? int(q.x) / int(q.y) : int(q.x) % int(q.y));
    if (kOperation == kAskShift) return q.w == 0u ? q.x << q.y : q.w == 1u ? q.x >> q.y : uint(int(q.x) >> q.y);
    if (kOperation == kAskBits) {
        if (q.w == 0u) return uint(bitCount(q.x));
        if (q.w == 1u) return uint(findLSB(q.x));
        if (q.w == 2u) return uint(findMSB(q.x));
        return q.w == 3u ? bitfieldReverse(q.x) : uint(findMSB(int(q.x)));
    }
    return 0u;
}

void main() {
    uint item = itemIndex();
#ifdef PLUMB_SWEEP
    if (item < push.items) answers[item] = answerTo(uvec4(push.base + item, 0u, 0u, 0u));
#else
    if (item < push.items) answers[item] = answerTo(questions[item]);
#endif
    finish(push.statusSlot, 0u);
}
