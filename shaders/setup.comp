// SPDX-License-Identifier: MIT
// One invocation the drawn triangles among 32: walks its set bits. The loop is not nested and may diverge.
// With kCount it bins small triangles at once, while their corners are at hand: it counts them in each of their up to four tiles, and
// keeps the number that it got, so that listing them needs neither corners nor atomics (slots.comp).
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/setup.h"
#include "edges.glsl"

layout(constant_id = 2) const bool kCount = false;
layout(constant_id = 3) const bool kBothSides = false;   // back faces are drawn, and turned round here

layout(push_constant, scalar) uniform Push { SetupPush push; };
layout(binding = 1) uniform usamplerBuffer triangles;
layout(binding = 2) uniform usamplerBuffer screen;
layout(binding = 3, scalar) readonly buffer Records { CullRecord records[]; };
layout(binding = 4, scalar) readonly buffer Places { uint places[]; };   // first place of each 32 triangles
layout(binding = 5, scalar) writeonly buffer Draws { uvec4 draws[]; };
layout(binding = 6, scalar) buffer Tiles { uint tiles[]; };
layout(binding = 7, scalar) writeonly buffer Slots { uvec4 slots[]; };   // as draws[]

// An edge outside of which the whole tile lies, in one of the three.
bool touches(ivec3 most) { return (most.x | most.y | most.z) >= 0; }

uvec4 countIn(ivec2 p0, ivec2 p1, ivec2 p2, bool counted) {
    ivec4 box = tileBox(p0, p1, p2, push.frame);
    bool twoWide = box.z > box.x;
    bool twoHigh = box.w > box.y;
    ivec2 origin = ivec2(box.x * kTileWidth, box.y * kTileHeight) * kSubpixels + kHalfPixel;
    Edges e;
    narrowEdges(p0 - origin, p1 - origin, p2 - origin, e);
    ivec3 here = e.q + max(e.a, 0) * (kTileWidth - 1) + max(e.b, 0) * (kTileHeight - 1);
    ivec3 right = here + e.a * kTileWidth;
    ivec3 down = e.b * kTileHeight;
    uint tile = uint(box.y) * push.tilesX + uint(box.x);
    uvec4 slot = uvec4(kNoSlot);
    if (counted && touches(here)) slot.x = tile | atomicAdd(tiles[tile], 1u) << 16u;
    if (counted && twoWide && touches(right)) slot.y = (tile + 1u) | atomicAdd(tiles[tile + 1u], 1u) << 16u;
    tile += push.tilesX;
    if (counted && twoHigh && touches(here + down)) slot.z = tile | atomicAdd(tiles[tile], 1u) << 16u;
    if (counted && twoWide && twoHigh && touches(right + down)) slot.w = (tile + 1u) | atomicAdd(tiles[tile + 1u], 1u) << 16u;
    return slot;
}

void main() {
    uint item = itemIndex();
    uint lane = min(item, push.laneCount - 1u);
    uint drawn = item < push.laneCount ? records[lane].drawn : 0u;
    uint clip = records[lane].clip;
    uint others = kCount ? records[lane].large | records[lane].wide | records[lane].medium : 0u;
    uint base = places[lane];
    uint steps = 0u;
    uint left = drawn;
    do {
        uint bit = uint(max(findLSB(left), 0));
        uint below = (1u << bit) - 1u;
        uint t = lane * kTrianglesPerLane + bit;
        uvec4 corners = texelFetch(triangles, int(t));
        ivec2 p0 = ivec2(texelFetch(screen, int(corners.x)).xy);
        ivec2 p1 = ivec2(texelFetch(screen, int(corners.y)).xy);
        ivec2 p2 = ivec2(texelFetch(screen, int(corners.z)).xy);
        DrawTriangle d;
        if (kBothSides) d = drawTriangle(corners.x, corners.y, corners.z, p0, p1, p2, t);
        else d = frontTriangle(corners.x, corners.y, corners.z, p0, p1, p2, t);
        uint place = base + uint(bitCount(drawn & below)) + kClipFan * uint(bitCount(clip & below));
        if (left != 0u) draws[place] = uvec4(d.vertex[0], d.vertex[1], d.vertex[2], d.source);
        if (kCount) {
            bool back = kBothSides && facing(p0, p1, p2) < 0;
            uvec4 slot = countIn(p0, back ? p2 : p1, back ? p1 : p2, (left & ~others & (1u << bit)) != 0u);
            if (left != 0u) slots[place] = slot;
        }
        left = left == 0u ? 0u : left & (left - 1u);
        steps++;
    } while (left != 0u && steps < kTrianglesPerLane);
    finish(push.statusSlot, left != 0u ? kFaultLoop : 0u);
}
