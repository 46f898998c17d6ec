// SPDX-License-Identifier: MIT
// Contract of the scanline pass: the polygon fill with Z-buffer of the lecture notes (sections 13 and 14, attributes as in 17),
// their errata A4 to A8 and A10 corrected, A9 kept: both ends of a line and both ends of an edge are painted.
//
// Corners are display coordinates rounded to whole pixels, kept real. A polygon's edges stand in its table with the smaller y
// first, without horizontal ones, sorted by y. Two edges are active; each line adds the edges' steps (X, Z and what is carried),
// left and right are decided anew on every line, and an edge that ends is replaced by the next of the table, which starts one step
// below its corner, because the corner's line is painted already (A4, A5). Across a line X runs leftX, leftX + 1, ... <= rightX and
// paints column floor(X + 1/2) of colour and depth alike (A8). A pixel is taken when its Z is less than the stored one: the
// smaller Z is nearer, equal Z keeps the first polygon. Without a Z-buffer (section 13) every pixel is taken, by one polygon after the other.
#ifndef PLUMB_SCANLINE_H
#define PLUMB_SCANLINE_H
#include "exact.h"
SHARED_BEGIN

// Lines of a polygon and columns of a line, canvas or not: an invocation may loop 65,535 times in all.
SHARED_CONST int kScanLimit = 60000;
SHARED_CONST uint kNoPolygon = 0xffffffffu;
SHARED_CONST float kScanFarthest = 3.0e38f;  // beyond every Z

struct ScanCorner {
    float x, y;    // display, whole pixels
    float z;       // Zps: grows with the distance
    vec3 carried;  // linear colour, or normal
};

struct ScanEdge {
    uint top, bottom;  // corners; y of top < y of bottom
};

struct ScanPolygon {
    uint firstEdge, edgeCount;  // sorted by y of the top corner; at least two
    int firstLine, lineCount;
    uint firstSpan;                // of the lines within the canvas
    int firstStored, storedCount;  // those lines
};

// An active edge on a line, or its step to the next line.
struct ScanWalk {
    float x, z;
    vec3 carried;
};

struct ScanSpan {
    float leftX, rightX, leftZ, rightZ;
    vec3 left, right;
};

struct ScanPush {
    uint statusSlot;
    uint firstPolygon, polygonCount;  // of this dispatch
    int width, height;                // of the canvas
    uint zBuffer;                     // 0: section 13's fill without one, what is painted later is seen
};

// a / b for b >= 1. What is too small for the emulated division is 0.
SHARED_FN float scanQuotient(float a, float b) { return exactDivide(snapTiny(a), b); }

SHARED_FN ScanWalk scanDifference(ScanWalk to, ScanWalk from, float steps) {
    ScanWalk d;
    d.x = scanQuotient(to.x - from.x, steps);
    d.z = scanQuotient(to.z - from.z, steps);
    d.carried.x = scanQuotient(to.carried.x - from.carried.x, steps);
    d.carried.y = scanQuotient(to.carried.y - from.carried.y, steps);
    d.carried.z = scanQuotient(to.carried.z - from.carried.z, steps);
    return d;
}

SHARED_FN ScanWalk scanStart(ScanCorner c) {
    ScanWalk w;
    w.x = c.x;
    w.z = c.z;
    w.carried = c.carried;
    return w;
}
SHARED_FN ScanWalk scanStep(ScanCorner top, ScanCorner bottom) {
    return scanDifference(scanStart(bottom), scanStart(top), bottom.y - top.y);
}
SHARED_FN ScanWalk scanNext(ScanWalk w, ScanWalk stepped) {
    w.x = w.x + stepped.x;
    w.z = w.z + stepped.z;
    w.carried.x = w.carried.x + stepped.carried.x;
    w.carried.y = w.carried.y + stepped.carried.y;
    w.carried.z = w.carried.z + stepped.carried.z;
    return w;
}

// After the line y an edge to `bottomY` gives way, unless the polygon ends there.
SHARED_FN bool scanEdgeEnds(int y, int lastLine, float bottomY) { return float(y) >= bottomY && y < lastLine; }

SHARED_FN ScanSpan scanSpan(ScanWalk i, ScanWalk j) {
    bool iIsLeft = i.x < j.x;
    ScanSpan s;
    s.leftX = pick(iIsLeft, i.x, j.x);
    s.rightX = pick(iIsLeft, j.x, i.x);
    s.leftZ = pick(iIsLeft, i.z, j.z);
    s.rightZ = pick(iIsLeft, j.z, i.z);
    s.left.x = pick(iIsLeft, i.carried.x, j.carried.x);
    s.left.y = pick(iIsLeft, i.carried.y, j.carried.y);
    s.left.z = pick(iIsLeft, i.carried.z, j.carried.z);
    s.right.x = pick(iIsLeft, j.carried.x, i.carried.x);
    s.right.y = pick(iIsLeft, j.carried.y, i.carried.y);
    s.right.z = pick(iIsLeft, j.carried.z, i.carried.z);
    return s;
}

SHARED_FN ScanWalk scanLeft(ScanSpan s) {
    ScanWalk w;
    w.x = s.leftX;
    w.z = s.leftZ;
    w.carried = s.left;
    return w;
}

// Step from pixel to pixel. The divisor is the difference of X (A7); below 1 the line is one pixel and no step is taken.
SHARED_FN ScanWalk scanAcross(ScanSpan s) {
    ScanWalk right;
    right.x = s.rightX;
    right.z = s.rightZ;
    right.carried = s.right;
    float wide = s.rightX - s.leftX;
    bool several = wide >= 1.0f;  // no plant: at 1 both choices are 1
    // no plant: a step below one pixel is not taken; the choice keeps the division in its range
    ScanWalk d = scanDifference(right, scanLeft(s), pick(several, wide, 1.0f));
    d.x = 1.0f;
    return d;
}

SHARED_FN bool scanWithin(float x, float rightX) { return x <= rightX; }
SHARED_FN int scanColumn(float x) { return toInt(floorReal(x + 0.5f)); }
SHARED_FN bool scanOnCanvas(int column, int width) { return column >= 0 && column < width; }
SHARED_FN bool scanTakes(float z, float stored, uint zBuffer) { return z < stored || zBuffer == 0u; }

SHARED_END
#endif
