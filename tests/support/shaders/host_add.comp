// SPDX-License-Identifier: MIT
// out[i] = pairs[i].x + pairs[i].y * factor + texel[i] + addend. With `skippedGroups`, the last groups never finish.
#version 450
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"

layout(constant_id = 7) const uint kAddend = 0u;
struct AddPush {
    uint statusSlot;
    uint count;
    uint factor;
    uint skippedGroups;
};
layout(push_constant, scalar) uniform Push { AddPush push; };
layout(binding = 1, scalar) readonly buffer Pairs { uvec2 pairs[]; };
layout(binding = 2) uniform utextureBuffer texel;
layout(binding = 3, scalar) writeonly buffer Sums { uint sums[]; };

void main() {
    uint item = itemIndex();
    if (item < push.count) sums[item] = pairs[item].x + pairs[item].y * push.factor + texelFetch(texel, int(item)).x + kAddend;
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (group + push.skippedGroups < gl_NumWorkGroups.x * gl_NumWorkGroups.y) finish(push.statusSlot, 0u);
}
