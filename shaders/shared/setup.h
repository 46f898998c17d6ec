// SPDX-License-Identifier: MIT
// Contract of the set-up pass: the drawn triangles of a chunk as one list in the order of the file. A triangle that is drawn whole takes
// one slot of the list. A clipped one takes kClipFan slots; unused ones have three equal vertices. So a smaller slot means a triangle with
// a smaller index.
#ifndef PLUMB_SETUP_H
#define PLUMB_SETUP_H
#include "cull.h"
SHARED_BEGIN

SHARED_CONST uint kNoTriangle = 0xffffffffu;

struct SetupPush {
    uint statusSlot;
    uint slotCount;  // slots of the draw list
    uint tilesX;     // tiles of the frame where small triangles are binned in the same pass (one band); else 0
    uint room;       // entries a tile, as in BinPush
    FrameBox frame;
};

struct ClipJob {
    uint triangle;  // triangle of the chunk
    uint object;
    uint slot;    // first of kClipFan slots in the draw list
    uint vertex;  // first of kClipCorners vertices
};

struct ClipPush {
    uint statusSlot;
    uint jobCount;
    uint cullBackFaces;
    FrameBox frame;
    Viewport viewport;
};

// Draw-list entry of a triangle that faces the viewer.
SHARED_FN DrawTriangle frontTriangle(uint v0, uint v1, uint v2, ivec2 p0, ivec2 p1, ivec2 p2, uint source) {
    uint first = firstCorner(p0, p1, p2);
    DrawTriangle d;
    d.vertex[0] = pick(first == 0u, v0, pick(first == 1u, v1, v2));
    d.vertex[1] = pick(first == 0u, v1, pick(first == 1u, v2, v0));
    d.vertex[2] = pick(first == 0u, v2, pick(first == 1u, v0, v1));
    d.source = source;
    return d;
}

SHARED_FN DrawTriangle drawTriangle(uint v0, uint v1, uint v2, ivec2 p0, ivec2 p1, ivec2 p2, uint source) {
    bool back = facing(p0, p1, p2) < 0;
    uint s1 = pick(back, v2, v1);
    uint s2 = pick(back, v1, v2);
    ivec2 q1 = p1;
    ivec2 q2 = p2;
    if (back) {
        q1 = p2;
        q2 = p1;
    }
    return frontTriangle(v0, s1, s2, p0, q1, q2, source);
}

SHARED_END
#endif
