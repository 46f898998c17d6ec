// SPDX-License-Identifier: MIT
// Contract of the cull and clip passes: which triangles are drawn, and as what.
// A triangle is culled when all its vertices are outside one plane, when no pixel centre lies in its box, or by its integer area: zero
// (counted), or negative (it shows its back).
// A triangle with a vertex outside a plane is clipped, plane by plane. Each cut is computed from the inside vertex, so both owners of an
// edge compute the same bits and no crack opens.
#ifndef PLUMB_CULL_H
#define PLUMB_CULL_H
#include "transform.h"
SHARED_BEGIN

SHARED_CONST uint kClipFan = 6u;  // a triangle cut by five planes has at most 8 corners: 6 triangles
SHARED_CONST uint kClipCorners = 8u;
SHARED_CONST uint kTrianglesPerLane = 32u;
SHARED_CONST int kSmallTiles = 32;  // a triangle whose box touches more tiles is binned in strips
SHARED_CONST int kTileWidth = 16;
SHARED_CONST int kTileHeight = 8;

struct FrameBox {
    int width, height;   // frame in pixels (samples when supersampled)
    int firstRow, rows;  // rows of the band
};

// Result of the cull pass for 32 triangles: one word a class, one bit a triangle.
struct CullRecord {
    uint drawn;                          // bit t: drawn as it is
    uint clip;                           // bit t: crosses a plane and is clipped
    uint large;                          // bit t, subset of drawn: binned in strips
    uint wide;                           // bit t, subset of drawn: needs the 64-bit set-up
    uint backFacing, zeroArea, outside;  // bit t each; read for the counters
    uint medium;  // bit t, subset of drawn: neither large nor wide, but its box touches more than two tiles of the frame
};

struct CullPush {
    uint statusSlot;
    uint triangleCount;
    uint cullBackFaces;
    FrameBox frame;
};

struct DrawTriangle {
    uint vertex[3];  // lowest (y, x) first, then counter-clockwise as seen
    uint source;     // triangle of the chunk
};

SHARED_CONST uint kOutside = 0u;
SHARED_CONST uint kBackFacing = 1u;
SHARED_CONST uint kZeroArea = 2u;
SHARED_CONST uint kDrawn = 3u;

// Twice the area of a triangle that faces the viewer is positive.
SHARED_FN int facing(ivec2 p0, ivec2 p1, ivec2 p2) { return signOfDifference(p1.y - p0.y, p2.x - p0.x, p1.x - p0.x, p2.y - p0.y); }

SHARED_FN ivec2 lowest(ivec2 a, ivec2 b, ivec2 c) { return min(min(a, b), c); }
SHARED_FN ivec2 highest(ivec2 a, ivec2 b, ivec2 c) { return max(max(a, b), c); }

// Class of a triangle inside every plane: kDrawn, kBackFacing, kZeroArea or kOutside. `frame` is the whole frame, not a band.
SHARED_FN uint classify(ivec2 p0, ivec2 p1, ivec2 p2, FrameBox frame, uint cullBackFaces) {
    ivec2 low = lowest(p0, p1, p2);
    ivec2 high = highest(p0, p1, p2);
    bool outside = lastPixel(high.x) < 0 || lastPixel(high.y) < 0 || firstPixel(low.x) >= frame.width ||
                   firstPixel(low.y) >= frame.height || firstPixel(low.x) > lastPixel(high.x) || firstPixel(low.y) > lastPixel(high.y);
    int sign = facing(p0, p1, p2);
    uint kind = pick(outside, kOutside, kDrawn);
    kind = pick(sign < 0 && cullBackFaces != 0u, kBackFacing, kind);
    return pick(sign == 0, kZeroArea, kind);
}

// First and last tile of a triangle's box in the frame, x and y.
SHARED_FN ivec4 tileBox(ivec2 p0, ivec2 p1, ivec2 p2, FrameBox frame) {
    ivec2 low = lowest(p0, p1, p2);
    ivec2 high = highest(p0, p1, p2);
    int x0 = max(firstPixel(low.x), 0) / kTileWidth;
    int x1 = min(lastPixel(high.x), frame.width - 1) / kTileWidth;
    int y0 = max(firstPixel(low.y), 0) / kTileHeight;
    int y1 = min(lastPixel(high.y), frame.height - 1) / kTileHeight;
    return ivec4(x0, y0, x1, y1);
}
SHARED_FN int tilesInBox(ivec4 box) { return (box.z - box.x + 1) * (box.w - box.y + 1); }
// True for boxes of at most two tiles; the set-up pass bins these triangles itself.
SHARED_FN bool inTwoTiles(ivec4 box) { return tilesInBox(box) <= 2; }

// True when corner a comes before corner b: lower y, then lower x. A drawn triangle runs counter-clockwise as seen and begins at its first
// corner in this order, so everything after it is the same whichever corner the file names first.
SHARED_FN bool before(ivec2 a, ivec2 b) { return a.y < b.y || (a.y == b.y && a.x < b.x); }
SHARED_FN uint firstCorner(ivec2 p0, ivec2 p1, ivec2 p2) {
    uint first = pick(before(p1, p0), 1u, 0u);
    bool second = before(p2, p0) && before(p2, p1);
    return pick(second, 2u, first);
}

// Intersection of the edge from an inside vertex to an outside one with a plane. Distances: inside >= 0 > outside.
SHARED_FN ClipVertex intersect(int plane, ClipVertex inside, ClipVertex outside, float dInside, float dOutside, Viewport v) {
    float t = exactDivide(dInside, dInside - dOutside);
    ClipVertex r;
    r.x = inside.x + t * (outside.x - inside.x);
    r.y = inside.y + t * (outside.y - inside.y);
    r.w = inside.w + t * (outside.w - inside.w);
    r.attributes.x = inside.attributes.x + t * (outside.attributes.x - inside.attributes.x);
    r.attributes.y = inside.attributes.y + t * (outside.attributes.y - inside.attributes.y);
    r.attributes.z = inside.attributes.z + t * (outside.attributes.z - inside.attributes.z);
    // The clipped coordinate is assigned, not computed.
    if (plane == kPlaneNear) r.w = v.near;
    if (plane == kPlaneLeft) r.x = -(v.guardX * r.w);
    if (plane == kPlaneRight) r.x = v.guardX * r.w;
    if (plane == kPlaneTop) r.y = -(v.guardY * r.w);
    if (plane == kPlaneBottom) r.y = v.guardY * r.w;
    return r;
}

// Projects a corner that clipping has made. Its outcode is not asked, because the corner lies on its planes only up to a rounding.
SHARED_FN ScreenVertex projectClipped(ClipVertex c, Viewport v) {
    ScreenVertex s;
    s.outcode = 0u;
    float limit = v.guardX + v.centreX;
    s.x = snapCoarsely(exactDivide(c.x, c.w) + v.centreX, limit, v.droppedBits);
    limit = v.guardY + v.centreY;
    s.y = snapCoarsely(exactDivide(c.y, c.w) + v.centreY, limit, v.droppedBits);
    s.z = exactDivide(v.near, c.w);
    return s;
}

SHARED_END
#endif
