// SPDX-License-Identifier: MIT
// Start-up self-test: the operations of the exact subset on one vector an invocation. Judged by host/selftest.cpp.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/exact.h"
#include "shared/selftest.h"

layout(local_size_x = kSelfTestGroupSize) in;
#include "shared/status.h"  // after the local size: itemIndex() reads it

layout(push_constant, scalar) uniform Push { SelfTestPush push; };
layout(binding = 1, scalar) readonly buffer Vectors { SelfTestVector vectors[]; };
layout(binding = 2, scalar) writeonly buffer Answers { SelfTestAnswer answers[]; };

void main() {
    uint item = itemIndex();
    if (item < kSelfTestVectors) {
        SelfTestVector v = vectors[item];
        SelfTestAnswer a;
        a.sum = v.x + v.y;
        a.difference = v.x - v.y;
        a.product = v.x * v.y;
        a.sumOfProducts = v.x * v.y + v.x;
        a.floatOfInt = float(int(v.i));
        a.floatOfUint = float(v.i);
        a.intOfFloat = int(v.converted);
        a.uintOfFloat = uint(abs(v.converted));
        umulExtended(v.i, v.j, a.unsignedHigh, a.unsignedLow);
        imulExtended(int(v.i), int(v.j), a.signedHigh, a.signedLow);
        a.nativeQuotient = nativeDivide(v.x, v.y);
        a.nativeRoot = nativeRoot(abs(v.x));
        a.emulatedQuotient = emulatedDivide(v.x, v.y, 0);
        a.emulatedRoot = emulatedRoot(abs(v.x), 0);
        answers[item] = a;
    }
    finish(push.statusSlot, 0u);
}
