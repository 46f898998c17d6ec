// SPDX-License-Identifier: MIT
// Small triangles: one invocation a drawn triangle, walking the tiles of its box (with kListed only the triangles of a list). Large and
// wide triangles: one invocation a strip of tiles in their box. Each item has a word of overflow bits; bit k: its k-th tile had no room
// left.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/bin.h"
#include "edges.glsl"

layout(constant_id = 2) const bool kStrips = false;
layout(constant_id = 3) const bool kListed = false;
layout(constant_id = 4) const bool kWide = false;  // some triangle needs the 64-bit set-up

layout(push_constant, scalar) uniform Push { BinPush push; };
layout(binding = 1) uniform usamplerBuffer draws;
layout(binding = 2) uniform usamplerBuffer screen;
layout(binding = 3) uniform usamplerBuffer items;            // kStrips: strips; kListed: indices in draws
layout(binding = 4, scalar) buffer Tiles { uint tiles[]; };  // counts
layout(binding = 5, scalar) writeonly buffer Entries { uint entries[]; };
layout(binding = 6, scalar) writeonly buffer Overflow { uint overflow[]; };

void main() {
    uint item = itemIndex();
    bool mine = item < push.itemCount;
    uint safe = min(item, push.itemCount - 1u);
    uvec4 strip = kStrips ? texelFetch(items, int(safe)) : uvec4(0u);
    uint index = kStrips ? strip.x : kListed ? texelFetch(items, int(safe)).x : safe;
    uvec4 d = texelFetch(draws, int(index));
    ivec2 p0 = ivec2(texelFetch(screen, int(d.x)).xy);
    ivec2 p1 = ivec2(texelFetch(screen, int(d.y)).xy);
    ivec2 p2 = ivec2(texelFetch(screen, int(d.z)).xy);
    int x0, x1, y0, steps;
    if (kStrips) {
        x0 = int(strip.y & 0xffffu);
        y0 = int(strip.y >> 16u);
        x1 = -1;
        steps = mine ? int(strip.z) : 0;
    } else {
        ivec2 low = lowest(p0, p1, p2);
        ivec2 high = highest(p0, p1, p2);
        ivec2 extent = high - low;
        int lastRow = push.frame.firstRow + push.frame.rows - 1;
        x0 = max(firstPixel(low.x), 0) / kTileWidth;
        x1 = min(lastPixel(high.x), push.frame.width - 1) / kTileWidth;
        y0 = (max(firstPixel(low.y), push.frame.firstRow) - push.frame.firstRow) / kTileHeight;
        int last = min(lastPixel(high.y), lastRow) - push.frame.firstRow;
        int y1 = last < 0 ? -1 : last / kTileHeight;
        bool isLarge = tilesInBox(tileBox(p0, p1, p2, push.frame)) > kSmallTiles || d.x >= push.firstClippedVertex;
        bool empty = d.x == d.y || x1 < x0 || y1 < y0;
        steps = mine && !empty && !isLarge && isNarrow(extent.x, extent.y) ? (x1 - x0 + 1) * (y1 - y0 + 1) : 0;
    }
    ivec2 origin = ivec2(x0 * kTileWidth, push.frame.firstRow + y0 * kTileHeight) * kSubpixels + kHalfPixel;
    Edges e;
    narrowEdges(p0 - origin, p1 - origin, p2 - origin, e);
    ivec3 most = e.q + max(e.a, 0) * (kTileWidth - 1) + max(e.b, 0) * (kTileHeight - 1);
    ivec3 stepX = e.a * kTileWidth;
    ivec3 stepY = e.b * kTileHeight;
    ivec3 atRow = most;
    int x = x0;
    uint tile = uint(y0) * push.tilesX + uint(x0);
    uint overflowed = 0u;
    int k = 0;
    do {
        if (kStrips && kWide) {
            wideEdges(p0 - origin, p1 - origin, p2 - origin, e);
            most = e.q + max(e.a, 0) * (kTileWidth - 1) + max(e.b, 0) * (kTileHeight - 1);
            origin.x += kTileWidth * kSubpixels;
        }
        bool touched = k < steps && (most.x | most.y | most.z) >= 0;
        uint number = 0u;
        if (touched) number = atomicAdd(tiles[tile], 1u);
        if (touched && number < push.room) entries[tile * push.room + number] = index;
        overflowed |= touched && number >= push.room ? 1u << uint(k) : 0u;
        bool wrap = x == x1;
        x = wrap ? x0 : x + 1;
        tile += wrap ? push.tilesX - uint(x1 - x0) : 1u;
        atRow += wrap ? stepY : ivec3(0);
        most = wrap ? atRow : most + stepX;
        k++;
    } while (k < steps);
    if (mine) overflow[item] = overflowed;
    finish(push.statusSlot, k < steps ? kFaultLoop : 0u);
}
