// SPDX-License-Identifier: MIT
// One invocation the drawn triangles among 32: walks its set bits. The loop is not nested and may diverge.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/setup.h"

layout(push_constant, scalar) uniform Push { SetupPush push; };
layout(binding = 1) uniform usamplerBuffer triangles;
layout(binding = 2) uniform usamplerBuffer screen;
layout(binding = 3, scalar) readonly buffer Records { CullRecord records[]; };
layout(binding = 4, scalar) readonly buffer Places { uint places[]; };   // first place of each 32 triangles
layout(binding = 5, scalar) writeonly buffer Draws { uvec4 draws[]; };

void main() {
    uint item = itemIndex();
    uint lane = min(item, push.laneCount - 1u);
    uint drawn = item < push.laneCount ? records[lane].drawn : 0u;
    uint clip = records[lane].clip;
    uint base = places[lane];
    uint steps = 0u;
    uint left = drawn;
    do {
        uint bit = uint(max(findLSB(left), 0));
        uint below = (1u << bit) - 1u;
        uint t = lane * kTrianglesPerLane + bit;
        uvec4 corners = texelFetch(triangles, int(t));
        DrawTriangle d = drawTriangle(corners.x, corners.y, corners.z, ivec2(texelFetch(screen, int(corners.x)).xy),
                                      ivec2(texelFetch(screen, int(corners.y)).xy),
                                      ivec2(texelFetch(screen, int(corners.z)).xy), t);
        uint place = base + uint(bitCount(drawn & below)) + kClipFan * uint(bitCount(clip & below));
        if (left != 0u) draws[place] = uvec4(d.vertex[0], d.vertex[1], d.vertex[2], d.source);
        left = left == 0u ? 0u : left & (left - 1u);
        steps++;
    } while (left != 0u && steps < kTrianglesPerLane);
    finish(push.statusSlot, left != 0u ? kFaultLoop : 0u);
}
