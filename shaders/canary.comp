// SPDX-License-Identifier: MIT
// Canaries of every start: how far a loop runs, and a few operations. Small, because it is compiled at each cold start.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/exact.h"
#include "shared/selftest.h"

layout(local_size_x = kCanaryLanes) in;
#include "shared/status.h"  // after the local size: itemIndex() reads it

layout(push_constant, scalar) uniform Push { SelfTestPush push; };
layout(binding = 1, scalar) writeonly buffer Answers { CanaryAnswer answers[]; };

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint iterations = 0u;
    uint state = lane;
    do {
        state = nextState(state);
        ++iterations;
    } while (iterations < push.iterations);
    CanaryAnswer a;
    a.iterations = iterations;
    a.state = state;
    float x = canaryOperand(lane, push.iterations);
    float y = canaryOperand(lane, push.iterations * 7u);
    a.sum = x + y;
    a.product = x * y;
    a.quotient = nativeDivide(x, y);
    a.root = nativeRoot(x);
    answers[lane] = a;
    finish(push.statusSlot, 0u);
}
