// SPDX-License-Identifier: MIT
// Contract of the lines pass (wire frame): each edge once, clipped to the near plane and to the frame in clip space, then stepped by
// an exact integer DDA: along its major axis, pixel centres in [from, to), the other coordinate floor of the exact line.
// Where lines cross, the lowest edge owns the pixel, whatever the order of drawing.
#ifndef PLUMB_LINES_H
#define PLUMB_LINES_H
#include "transform.h"
SHARED_BEGIN

struct LinesPush {
    uint statusSlot;
    uint firstEdge, edgeCount;          // of one object, in the edge list at hand
    uint edgeNumber;                    // of the first edge in the whole frame: what owns a pixel
    uint object;
    uint rowPixels;                     // pitch of the owner plane
    int width, height;
    int firstRow, rows;                 // of the band
    Viewport viewport;                  // guardX, guardY: half the frame and one pixel
};

SHARED_CONST uint kNoEdge = 0xffffffffu;

// A wire frame's sides are limited so that 256 times a coordinate fits 32 bits.
SHARED_CONST int kLineFrameLimit = 16384;

struct LineEnds {
    float x0, y0, w0, x1, y1, w1;
};

// Cuts at one plane, computed from the inside end. False: nothing is left.
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
    int start;                          // minor sub-pixel coordinate of the lower end
    int offset;                         // from the lower end to the first pixel centre, sub-pixels, 0..255
    int rise, run;                      // sub-pixels, run > 0
    int steep;                          // 1: major axis is y
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
    w.start = pick(swapped, minorB, minorA);
    w.rise = pick(swapped, minorA, minorB) - w.start;
    w.run = max(high - low, 1);  // no plant: a line without length has no pixel; 1 keeps its division defined
    w.first = firstPixel(low);
    // Centres below `high`: the end belongs to the next line.
    w.count = firstPixel(high) - w.first;
    w.offset = w.first * kSubpixels + kHalfPixel - low;
    return w;
}

SHARED_END
#endif
