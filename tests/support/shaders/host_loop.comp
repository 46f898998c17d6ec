// SPDX-License-Identifier: MIT
// Loops as often as asked and says so when a loop was cut: by the device, or by being asked for fewer steps than are wanted.
#version 450
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"

struct LoopPush {
    uint statusSlot;
    uint iterations;
    uint items;
    uint wanted;
};
layout(push_constant, scalar) uniform Push { LoopPush push; };
layout(binding = 1, scalar) writeonly buffer States { uint states[]; };

void main() {
    uint state = gl_LocalInvocationIndex;
    uint done = 0u;
    do {
        state = state * 1664525u + 1013904223u;
        ++done;
    } while (done < push.iterations);
    uint item = itemIndex();
    if (item < push.items) states[item] = state;
    finish(push.statusSlot, pick(done < push.wanted, kFaultLoop, 0u));
}
