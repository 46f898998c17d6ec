// SPDX-License-Identifier: MIT
// How the device runs a program, for `plumb devices --fingerprint`: loops, stores, large indices, memory of a workgroup, atomics.
// A workgroup works on one question; kRunStores and kRunMemory have one answer an invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/fingerprint.h"

layout(constant_id = 2) const uint kOperation = 0u;

layout(push_constant, scalar) uniform Push { FingerprintPush push; };
layout(binding = 1, scalar) readonly buffer Questions { uvec4 questions[]; };
layout(binding = 2, scalar) buffer Answers { uint answers[]; };

shared uint words[kRunLanes];

// Steps of three loops: `outer` times `inner`, then `behind`. The state has no closed form that a compiler could use instead.
uint loops(uvec4 q) {
    uint count = 0u, state = 1u, i = 0u;
    do {
        uint j = 0u;
        do {
            state = max(state ^ (count * 5u), 1u);
            ++count;
            ++j;
        } while (j < q.y);
        ++i;
    } while (i < q.x);
    if (q.z > 0u) {
        i = 0u;
        do {
            state = max(state ^ (count * 3u), 1u);
            ++count;
            ++i;
        } while (i < q.z);
    }
    return q.w == 0u ? count : state;
}

void main() {
    uint index = itemIndex(), lane = gl_LocalInvocationIndex, group = index >> 6;
    if (kOperation == kRunLoops) {
        uint steps = loops(questions[min(group, push.items - 1u)]);
        if (lane == 0u && group < push.items) answers[group] = steps;
    }
    if (kOperation == kRunStores) {
        if (index < push.items) answers[index] = ~index;
    }
    if (kOperation == kRunIndices) {
        // The even questions write their index where it points, the odd ones read what the host left there.
        if (lane == 0u && group < push.items) {
            uvec4 q = questions[group];
            if (q.y == 0u)
                answers[q.x] = ~q.x;
            else
                answers[q.z] = answers[q.x];
        }
    }
    if (kOperation == kRunMemory) {
        words[lane] = index;
        barrier();
        uint other = words[kRunLanes - 1u - lane];
        if (index < push.items) answers[index] = ~other;
    }
    if (kOperation == kRunAtomics) {
        // Words of the whole dispatch: sum, smallest, largest, or, and, exclusive or.
        if (index < push.base) {
            uint value = questions[index].x;
            atomicAdd(answers[0], value);
            atomicMin(answers[1], value);
            atomicMax(answers[2], value);
            atomicOr(answers[3], value);
            atomicAnd(answers[4], value);
            atomicXor(answers[5], value);
        }
    }
    finish(push.statusSlot, 0u);
}
