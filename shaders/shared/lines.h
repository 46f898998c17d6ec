// SPDX-License-Identifier: MIT
// Contract of the lines pass (wire frame): each edge once, clipped to the near plane and to the frame in clip space, then stepped by
// an exact integer DDA: along its major axis, pixel centres in [from, to), the other coordinate floor of the exact line.
// Where lines cross, the lowest edge owns the pixel, whatever the order of drawing. Hidden lines are removed pixel by pixel by lineShows().
#ifndef PLUMB_LINES_H
#define PLUMB_LINES_H
#include "transform.h"
SHARED_BEGIN

struct LinesPush {
    uint statusSlot;
    uint firstEdge, edgeCount;  // edges of one object, in the edge list of this dispatch
    uint edgeNumber;            // number of the first edge in the whole frame; the smallest number owns a pixel
    uint object;
    uint rowPixels;  // pitch of the owner plane
    int width, height;
    int firstRow, rows;           // rows of the band
    int surfaceRow, surfaceRows;  // rows of the frame in the surfaces buffer (hidden lines removed)
    Viewport viewport;            // guardX, guardY: half the frame and one pixel
};

SHARED_CONST uint kNoEdge = 0xffffffffu;

// Longest side of a wire frame, so that 256 times a coordinate fits 32 bits.
SHARED_CONST int kLineFrameLimit = 16384;

struct LineEnds {
    float x0, y0, w0, x1, y1, w1;
};

// Cuts a line at one plane, computed from its inside end. False when nothing is left.
SHARED_FN bool cutLine(int plane, INOUT(LineEnds) e, Viewport v) {
    float d0 = planeDistance(plane, e.x0, e.y0, e.w0, v);
    float d1 = planeDistance(plane, e.x1, e.y1, e.w1, v);
    bool in0 = !(d0 < 0.0f);
    bool in1 = !(d1 < 0.0f);
    if (in0 && !in1) {
        float t = exactDivide(d0, d0 - d1);
        e.x1 = e.x0 + t * (e.x1 - e.x0);
        e.y1 = e.y0 + t * (e.y1 - e.y0);
        e.w1 = e.w0 + t * (e.w1 - e.w0);
        if (plane == kPlaneNear) e.w1 = v.near;
    }
    if (in1 && !in0) {
        float t = exactDivide(d1, d1 - d0);
        e.x0 = e.x1 + t * (e.x0 - e.x1);
        e.y0 = e.y1 + t * (e.y0 - e.y1);
        e.w0 = e.w1 + t * (e.w0 - e.w1);
        if (plane == kPlaneNear) e.w0 = v.near;
    }
    return in0 || in1;
}

// A line ready to step, major axis first: pixel k has major coordinate first + k and minor coordinate
// floor((start + floor((offset + 256 k) rise / run)) / 256), 0 <= k < count.
struct LineWalk {
    int first, count;
    int start;      // minor sub-pixel coordinate of the lower end
    int offset;     // from the lower end to the first pixel centre, sub-pixels, 0..255
    int rise, run;  // sub-pixels, run > 0
    int steep;      // 1: major axis is y
    int swapped;    // 1: the lower end is the second one
};

SHARED_FN LineWalk walkLine(ivec2 a, ivec2 b) {
    ivec2 d = b - a;
    bool steep = abs(d.y) > abs(d.x);
    int majorA = pick(steep, a.y, a.x);
    int majorB = pick(steep, b.y, b.x);
    int minorA = pick(steep, a.x, a.y);
    int minorB = pick(steep, b.x, b.y);
    bool swapped = majorB < majorA;
    int low = pick(swapped, majorB, majorA);
    int high = pick(swapped, majorA, majorB);
    LineWalk w;
    w.steep = pick(steep, 1, 0);
    w.swapped = pick(swapped, 1, 0);
    w.start = pick(swapped, minorB, minorA);
    w.rise = pick(swapped, minorA, minorB) - w.start;
    w.run = max(high - low, 1);  // no plant: a line without length has no pixel; 1 keeps its division defined
    w.first = firstPixel(low);
    // Centres below `high`: the end belongs to the next line.
    w.count = firstPixel(high) - w.first;
    w.offset = w.first * kSubpixels + kHalfPixel - low;
    return w;
}

// Depth along a line: z = near / w is linear on the screen. Low and high end as in LineWalk; the slope is that of one sub-pixel.
struct LineDepth {
    float start, slope;
};
SHARED_FN LineDepth lineDepth(float z0, float z1, LineWalk w) {
    LineDepth d;
    d.start = pick(w.swapped == 1, z1, z0);
    float end = pick(w.swapped == 1, z0, z1);
    d.slope = exactDivide(end - d.start, float(w.run));
    return d;
}
// Bits of z at pixel k of the walk, at the point of the line on the centre of the pixel's column (row when steep). They never leave the
// range of the ends: at most run - 1 <= 2^22 - 1 sub-pixels from the start, the product is below (1 + 2^-24)^3 (1 - 2^-22) < 1 of the
// difference, and rounding keeps order.
SHARED_FN int lineDepthAt(LineDepth d, LineWalk w, int k) { return bitsOf(d.start + d.slope * float(w.offset + kSubpixels * k)); }

// Face of a pixel of the filled picture where nothing is drawn. The picture has bits of z (0: nothing) and the face a pixel.
SHARED_CONST uint kNoFace = 0xffffffffu;

// True when a pixel of an edge shows although hidden lines are removed. One of three holds:
// - the edge's own polygon is seen there;
// - it is seen at a neighbour across the line, the pixel before or after along the minor axis: the line runs between their centres, and its
// polygon may begin beyond it;
// - the line is not behind what is seen there.
// No tolerance in depth is needed: where the edge lies in the seen surface, that surface is the edge's own.
SHARED_FN bool lineShows(int lineZ, uint edgeFace, uvec2 here, uvec2 before, uvec2 after) {
    return here.y == edgeFace || before.y == edgeFace || after.y == edgeFace || lineZ >= int(here.x);
}

SHARED_END
#endif
