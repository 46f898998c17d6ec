// SPDX-License-Identifier: MIT
// Small triangles: one invocation a drawn triangle, walking the tiles of its box (with kListed only those that the set-up pass has
// not counted). Large and wide ones: one invocation a triangle and tile row, in 64 bits. The same module counts and, with kList,
// writes the lists, from their ends.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/bin.h"
#include "edges.glsl"

layout(constant_id = 2) const bool kLarge = false;
layout(constant_id = 3) const bool kList = false;
layout(constant_id = 4) const bool kListed = false;

layout(push_constant, scalar) uniform Push { BinPush push; };
layout(binding = 1) uniform usamplerBuffer draws;
layout(binding = 2) uniform usamplerBuffer screen;
layout(binding = 3) uniform usamplerBuffer large;                 // kLarge, kListed: indices into draws
layout(binding = 4, scalar) buffer Tiles { uint tiles[]; };       // counts; with kList, from push.ends on, what is still free of each tile's list
layout(binding = 5, scalar) writeonly buffer Entries { uint entries[]; };

void main() {
    uint item = itemIndex();
    bool mine = item < push.itemCount;
    uint safe = min(item, push.itemCount - 1u);
    uint index = kLarge ? texelFetch(large, int(push.firstLarge + safe / push.rowsPerLarge)).x : kListed ? texelFetch(large, int(safe)).x : safe;
    uvec4 d = texelFetch(draws, int(index));
    ivec2 p0 = ivec2(texelFetch(screen, int(d.x)).xy);
    ivec2 p1 = ivec2(texelFetch(screen, int(d.y)).xy);
    ivec2 p2 = ivec2(texelFetch(screen, int(d.z)).xy);
    ivec2 low = lowest(p0, p1, p2);
    ivec2 high = highest(p0, p1, p2);
    int lastRow = push.frame.firstRow + push.frame.rows - 1;
    int x0 = max(firstPixel(low.x), 0) / kTileWidth;
    int x1 = min(lastPixel(high.x), push.frame.width - 1) / kTileWidth;
    int y0 = (max(firstPixel(low.y), push.frame.firstRow) - push.frame.firstRow) / kTileHeight;
    int last = min(lastPixel(high.y), lastRow) - push.frame.firstRow;
    int y1 = last < 0 ? -1 : last / kTileHeight;
    bool isLarge = tilesInBox(tileBox(p0, p1, p2, push.frame)) > kSmallTiles || d.x >= push.firstClippedVertex;
    ivec2 extent = high - low;
    bool wide = !isNarrow(extent.x, extent.y);
    bool empty = d.x == d.y || x1 < x0 || y1 < y0;
    uint fault = 0u;
    if (kLarge) {
        int row = y0 + int(safe - (safe / push.rowsPerLarge) * push.rowsPerLarge);
        bool touched = mine && !empty && row <= y1;
        int y = push.frame.firstRow + row * kTileHeight;
        int x = x0;
        int steps = touched ? x1 - x0 + 1 : 0;
        int k = 0;
        do {
            ivec2 centre = ivec2(x * kTileWidth, y) * kSubpixels + kHalfPixel;
            Edges e;
            wideEdges(p0 - centre, p1 - centre, p2 - centre, e);
            ivec3 most = e.q + max(e.a, 0) * (kTileWidth - 1) + max(e.b, 0) * (kTileHeight - 1);
            if (k < steps && (most.x | most.y | most.z) >= 0) {
                uint tile = uint(row) * push.tilesX + uint(x);
                if (kList) entries[atomicAdd(tiles[push.ends + tile], 0xffffffffu) - 1u] = index;
                else atomicAdd(tiles[tile], 1u);
            }
            x++;
            k++;
        } while (k < steps);
        fault = k < steps ? kFaultLoop : 0u;
    } else {
        ivec2 origin = ivec2(x0 * kTileWidth, push.frame.firstRow + y0 * kTileHeight) * kSubpixels + kHalfPixel;
        Edges e;
        narrowEdges(p0 - origin, p1 - origin, p2 - origin, e);
        ivec3 most = e.q + max(e.a, 0) * (kTileWidth - 1) + max(e.b, 0) * (kTileHeight - 1);
        ivec3 stepX = e.a * kTileWidth;
        ivec3 stepY = e.b * kTileHeight;
        ivec3 atRow = most;
        int steps = mine && !empty && !wide && !isLarge ? (x1 - x0 + 1) * (y1 - y0 + 1) : 0;
        int x = x0;
        int y = y0;
        int k = 0;
        do {
            if (k < steps && (most.x | most.y | most.z) >= 0) {
                uint tile = uint(y) * push.tilesX + uint(x);
                if (kList) entries[atomicAdd(tiles[push.ends + tile], 0xffffffffu) - 1u] = index;
                else atomicAdd(tiles[tile], 1u);
            }
            bool wrap = x == x1;
            x = wrap ? x0 : x + 1;
            y += wrap ? 1 : 0;
            atRow += wrap ? stepY : ivec3(0);
            most = wrap ? atRow : most + stepX;
            k++;
        } while (k < steps);
        fault = k < steps ? kFaultLoop : 0u;
    }
    finish(push.statusSlot, fault);
}
