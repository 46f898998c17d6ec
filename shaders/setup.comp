// SPDX-License-Identifier: MIT
// One invocation a slot of the draw list. With kBin it also bins small triangles, while their corners are at hand, in their one or two
// tiles.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/setup.h"
#include "edges.glsl"

layout(constant_id = 2) const bool kBin = false;
layout(constant_id = 3) const bool kBothSides = false;  // back faces are drawn, and turned round here

layout(push_constant, scalar) uniform Push { SetupPush push; };
layout(binding = 1) uniform usamplerBuffer triangles;
layout(binding = 2) uniform usamplerBuffer screen;
layout(binding = 3) uniform usamplerBuffer sources;  // triangle of each slot; kNoTriangle: a slot of a clip fan
layout(binding = 4, scalar) writeonly buffer Draws { uvec4 draws[]; };
layout(binding = 5, scalar) buffer Tiles { uint tiles[]; };                // counts
layout(binding = 6, scalar) writeonly buffer Entries { uint entries[]; };  // lists, as the bin pass leaves them
// Overflow bits of each slot: bit i, its i-th tile had no room left.
layout(binding = 7, scalar) writeonly buffer Overflow { uint overflow[]; };

// True when the triangle may touch the tile: no edge has the whole tile outside. `most`: greatest value of each edge in the tile.
bool touches(ivec3 most) { return (most.x | most.y | most.z) >= 0; }

// Puts a triangle on a tile's list. True on overflow: no room was left.
bool put(bool touched, uint tile, uint slot) {
    uint number = 0u;
    if (touched) number = atomicAdd(tiles[tile], 1u);
    if (touched && number < push.room) entries[tile * push.room + number] = slot;
    return touched && number >= push.room;
}

uint listIn(ivec2 p0, ivec2 p1, ivec2 p2, bool drawn, uint slot) {
    ivec4 box = tileBox(p0, p1, p2, push.frame);
    ivec2 extent = highest(p0, p1, p2) - lowest(p0, p1, p2);
    bool small = drawn && inTwoTiles(box) && isNarrow(extent.x, extent.y);
    bool wide = box.z > box.x;
    bool two = small && (wide || box.w > box.y);
    ivec2 origin = ivec2(box.x * kTileWidth, box.y * kTileHeight) * kSubpixels + kHalfPixel;
    Edges e;
    narrowEdges(p0 - origin, p1 - origin, p2 - origin, e);
    ivec3 here = e.q + max(e.a, 0) * (kTileWidth - 1) + max(e.b, 0) * (kTileHeight - 1);
    ivec3 there = here + (wide ? e.a * kTileWidth : e.b * kTileHeight);
    uint tile = uint(box.y) * push.tilesX + uint(box.x);
    uint overflowed = put(small && touches(here), tile, slot) ? 1u : 0u;
    return overflowed | (put(two && touches(there), tile + (wide ? 1u : push.tilesX), slot) ? 2u : 0u);
}

void main() {
    uint item = itemIndex();
    uint source = texelFetch(sources, int(min(item, push.slotCount - 1u))).x;
    bool drawn = item < push.slotCount && source != kNoTriangle;
    source = drawn ? source : 0u;
    uvec4 corners = texelFetch(triangles, int(source));
    ivec2 p0 = ivec2(texelFetch(screen, int(corners.x)).xy);
    ivec2 p1 = ivec2(texelFetch(screen, int(corners.y)).xy);
    ivec2 p2 = ivec2(texelFetch(screen, int(corners.z)).xy);
    DrawTriangle d;
    if (kBothSides)
        d = drawTriangle(corners.x, corners.y, corners.z, p0, p1, p2, source);
    else
        d = frontTriangle(corners.x, corners.y, corners.z, p0, p1, p2, source);
    if (drawn) draws[item] = uvec4(d.vertex[0], d.vertex[1], d.vertex[2], d.source);
    if (kBin) {
        bool back = kBothSides && facing(p0, p1, p2) < 0;
        uint overflowed = listIn(p0, back ? p2 : p1, back ? p1 : p2, drawn, item);
        if (item < push.slotCount) overflow[item] = overflowed;
    }
    finish(push.statusSlot, 0u);
}
