// SPDX-License-Identifier: MIT
// Cost of division and root: kSteps of them one after another for each pair of operands. One step is bound by memory, many by arithmetic.
#version 450
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/exact.h"
#include "shared/status.h"

layout(constant_id = 2) const int kSteps = 1;
layout(constant_id = 3) const bool kRoots = false;

struct CostPush {
    uint statusSlot;
    uint count;
};
layout(push_constant, scalar) uniform Push { CostPush push; };
layout(binding = 1, scalar) readonly buffer Operands { vec2 operands[]; };
layout(binding = 2, scalar) writeonly buffer Answers { float answers[]; };

void main() {
    uint item = itemIndex();
    if (item < push.count) {
        vec2 v = operands[item];
        float x = v.x;
        // The result stays near 1: quotients by numbers around 1, roots of a product with one.
        for (int i = 0; i < kSteps; ++i) {
            if (kRoots)
                x = exactRoot(x * v.y);
            else
                x = exactDivide(v.y, x);
        }
        answers[item] = x;
    }
    finish(push.statusSlot, 0u);
}
