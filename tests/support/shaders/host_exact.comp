// SPDX-License-Identifier: MIT
// Division and root, as a pass would have them and with a moved seed.
#version 450
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/exact.h"
#include "shared/status.h"

struct ExactPush {
    uint statusSlot;
    uint count;
    int seedErrorUlp;
};
struct ExactAnswer {
    float quotient;
    float root;
    float emulatedQuotient;
    float emulatedRoot;
    float snapped;
};
layout(push_constant, scalar) uniform Push { ExactPush push; };
layout(binding = 1, scalar) readonly buffer Operands { vec2 operands[]; };
layout(binding = 2, scalar) writeonly buffer Answers { ExactAnswer answers[]; };

void main() {
    uint item = itemIndex();
    if (item < push.count) {
        vec2 v = operands[item];
        answers[item] = ExactAnswer(exactDivide(v.x, v.y), exactRoot(abs(v.x)), emulatedDivide(v.x, v.y, push.seedErrorUlp),
                                    emulatedRoot(abs(v.x), push.seedErrorUlp), snapTiny(v.x));
    }
    finish(push.statusSlot, 0u);
}
