// SPDX-License-Identifier: MIT
// Binary64 as the transform of --trade transform=fp64 uses it, one vector an invocation. Judged by host/binary64.cpp.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/selftest.h"

layout(local_size_x = kSelfTestGroupSize) in;
#include "shared/status.h"  // after the local size: itemIndex() reads it

layout(push_constant, scalar) uniform Push { SelfTestPush push; };
layout(binding = 1, scalar) readonly buffer Vectors { DoubleVector vectors[]; };
layout(binding = 2, scalar) writeonly buffer Answers { DoubleAnswer answers[]; };

void main() {
    uint item = itemIndex();
    if (item < kDoubleVectors) {
        DoubleVector v = vectors[item];
        double a = packDouble2x32(uvec2(v.aLow, v.aHigh));
        double b = packDouble2x32(uvec2(v.bLow, v.bHigh));
        double product = a * double(v.x);
        uvec2 words = unpackDouble2x32(a + b);
        DoubleAnswer answer;
        answer.sumLow = words.x;
        answer.sumHigh = words.y;
        words = unpackDouble2x32(product);
        answer.productLow = words.x;
        answer.productHigh = words.y;
        words = unpackDouble2x32(product + b);
        answer.bothLow = words.x;
        answer.bothHigh = words.y;
        answer.rounded = float(a);
        answers[item] = answer;
    }
    finish(push.statusSlot, 0u);
}
