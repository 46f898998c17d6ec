// SPDX-License-Identifier: MIT
// One invocation 32 triangles: one bit a triangle and class, no atomics. The host adds up the bits and gives each invocation of the set-up
// pass its first slot in the draw list.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/cull.h"

layout(push_constant, scalar) uniform Push { CullPush push; };
layout(binding = 1) uniform usamplerBuffer triangles;  // three vertices, material
layout(binding = 2) uniform usamplerBuffer screen;
layout(binding = 3, scalar) writeonly buffer Records { CullRecord records[]; };

void main() {
    uint item = itemIndex();
    uint first = item * kTrianglesPerLane;
    CullRecord r = CullRecord(0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
    uint k = 0u;
    do {
        uint t = first + k;
        uint bit = t < push.triangleCount ? 1u << k : 0u;
        uvec4 corners = texelFetch(triangles, int(min(t, push.triangleCount - 1u)));
        uvec4 v0 = texelFetch(screen, int(corners.x));
        uvec4 v1 = texelFetch(screen, int(corners.y));
        uvec4 v2 = texelFetch(screen, int(corners.z));
        ivec2 p0 = ivec2(v0.xy);
        ivec2 p1 = ivec2(v1.xy);
        ivec2 p2 = ivec2(v2.xy);
        bool rejected = (v0.w & v1.w & v2.w) != 0u;
        bool cut = !rejected && (v0.w | v1.w | v2.w) != 0u;
        uint kind = classify(p0, p1, p2, push.frame, push.cullBackFaces);
        bool whole = !rejected && !cut;
        bool drawn = whole && kind == kDrawn;
        ivec2 extent = highest(p0, p1, p2) - lowest(p0, p1, p2);
        r.drawn |= drawn ? bit : 0u;
        r.clip |= cut ? bit : 0u;
        ivec4 box = tileBox(p0, p1, p2, push.frame);
        bool large = tilesInBox(box) > kSmallTiles;
        bool wide = !isNarrow(extent.x, extent.y);
        r.large |= drawn && large ? bit : 0u;
        r.wide |= drawn && wide ? bit : 0u;
        r.medium |= drawn && !large && !wide && !inTwoTiles(box) ? bit : 0u;
        r.backFacing |= whole && kind == kBackFacing ? bit : 0u;
        r.zeroArea |= whole && kind == kZeroArea ? bit : 0u;
        r.outside |= rejected || (whole && kind == kOutside) ? bit : 0u;
        k++;
    } while (k < kTrianglesPerLane);
    if (first < push.triangleCount) records[item] = r;
    finish(push.statusSlot, k < kTrianglesPerLane ? kFaultLoop : 0u);
}
