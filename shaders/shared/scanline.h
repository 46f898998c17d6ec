// SPDX-License-Identifier: MIT
// Contract of the scanline pass: the polygon fill with Z-buffer of the lecture notes (sections 13 and 14, attributes as in 17),
// their errata A4 to A8 and A10 corrected, A9 kept: both ends of an edge are painted, and the last step of a line that does not
// pass its right end.
//
// Corners are display coordinates rounded to whole pixels. A polygon's edges stand in its table with the smaller y first, without
// horizontal ones, sorted by y.
// Two edges are active. Each line adds the edges' dX, and left and right are decided anew on every line. An edge that ends is replaced by
// the next of the table, which starts one step below its corner, because the corner's line is painted already (A4, A5).
// Across a line X runs leftX, leftX + 1, ... <= rightX and paints column floor(X + 1/2) of colour and depth alike (A8). A pixel is taken
// when its Z is less than the stored one: the smaller Z is nearer, equal Z keeps the first polygon. Without a Z-buffer (section 13) every
// pixel is taken, by one polygon after the other.
//
// X is exact: an edge's X is a whole column and a rest over the edge's height, so columns of a line are whole numbers and no sum of
// rounded steps decides them. Z and attributes are counted in whole lines and columns from the farther end and rounded once (scanAlong).
// The nearer end of a polygon that is cut at the near plane may be a million times as large.
#ifndef PLUMB_SCANLINE_H
#define PLUMB_SCANLINE_H
#include "exact.h"
SHARED_BEGIN

// Rounds of an invocation's loops: lavapipe ends them after 65,535. A polygon of more lines or columns is cut into blocks.
SHARED_CONST int kScanLimit = 60000;
SHARED_CONST int kScanBlock = 30000;
SHARED_CONST int kScanFarthestPixel = 536870912;  // 2^29, limit of a corner: 2 height and every product of two heights stay in range
SHARED_CONST uint kNoPolygon = 0xffffffffu;
SHARED_CONST float kScanFarthest = 3.0e38f;  // beyond every Z

struct ScanCorner {
    int x, y;         // display, whole pixels
    float z;          // Zps: grows with the distance
    vec3 attributes;  // linear colour, or normal
};

// X of an edge is column + rest / height, 0 <= rest < height.
struct ScanEdge {
    uint top, bottom;  // indices of corners; y of top < y of bottom
    int column;        // X on the first line of the block that the edge is active on
    uint rest;
    int columnStep;  // dX
    uint restStep;
    uint height;  // lines from top to bottom
};

// A polygon, or a block of a large one.
struct ScanPolygon {
    uint firstEdge, edgeCount;     // first the two edges that are active on the first line, then the others by y of their top
    int firstLine, lineCount;      // lines of the block within the canvas
    int lastLine;                  // last line of the whole polygon
    int firstColumn, columnCount;  // columns of the block within the canvas
    uint firstSpan;
};

struct ScanWalk {
    int column;
    uint rest;
};

struct ScanValues {
    float z;
    vec3 attributes;
};

// Values along an edge: `from` on the line of its farther corner, `step` more a line, `to` at its nearer corner.
struct ScanSlope {
    int fromLine, toLine;
    ScanValues from, step, to;
};

struct ScanSpan {
    int first;          // column of the left end: floor(leftX + 1/2)
    int more;           // columns after it: floor(rightX - leftX)
    float leftX, wide;  // rightX = leftX + wide
    ScanValues left, right;
};

// Values across a line: `from` at X = leftX - offset, `step` more a column, `to` at X = leftX + toSteps.
struct ScanAcross {
    float offset, toSteps;
    ScanValues from, step, to;
};

struct ScanPush {
    uint statusSlot;
    uint firstPolygon, polygonCount;  // polygons of this dispatch
    int width, height;                // canvas
    uint zBuffer;                     // 0: section 13's fill without a Z-buffer, later polygons paint over earlier ones
};

// Flushes |x| < 2^-75 to 0: quotients stay in the range of the emulated division, and each product below is a multiple of 2^-122.
SHARED_FN float scanSnap(float x) {
    int bits = bitsOf(x);
    return realOf(pick((bits & 0x7fffffff) < 0x1a000000, 0, bits));
}
SHARED_FN float scanQuotient(float a, float b) { return scanSnap(exactDivide(scanSnap(a), b)); }

// Value of base + steps * step with one rounding, but for 2^-33 of the larger summand. The rounding errors of product (Dekker) and sum
// (Knuth) are computed and added last.
SHARED_FN float scanUpperHalf(float x) { return realOf(bitsOf(x) & -4096); }
SHARED_FN float scanAlong(float base, float steps, float step) {
    float stepsHigh = scanUpperHalf(steps);
    float stepsLow = steps - stepsHigh;
    float stepHigh = scanUpperHalf(step);
    float stepLow = step - stepHigh;
    float product = steps * step;
    float productError = (((stepsHigh * stepHigh - product) + stepsHigh * stepLow) + stepsLow * stepHigh) + stepsLow * stepLow;
    float sum = base + product;
    float added = sum - base;
    float sumError = (base - (sum - added)) + (product - added);
    return sum + (sumError + productError);
}
SHARED_FN ScanValues scanMoved(ScanValues from, float steps, ScanValues step) {
    ScanValues v;
    v.z = scanAlong(from.z, steps, step.z);
    v.attributes.x = scanAlong(from.attributes.x, steps, step.attributes.x);
    v.attributes.y = scanAlong(from.attributes.y, steps, step.attributes.y);
    v.attributes.z = scanAlong(from.attributes.z, steps, step.attributes.z);
    return v;
}
SHARED_FN ScanValues scanStep(ScanValues from, ScanValues to, float steps) {
    ScanValues d;
    d.z = scanQuotient(to.z - from.z, steps);
    d.attributes.x = scanQuotient(to.attributes.x - from.attributes.x, steps);
    d.attributes.y = scanQuotient(to.attributes.y - from.attributes.y, steps);
    d.attributes.z = scanQuotient(to.attributes.z - from.attributes.z, steps);
    return d;
}
SHARED_FN ScanValues scanChosen(bool first, ScanValues a, ScanValues b) {
    ScanValues v;
    v.z = pick(first, a.z, b.z);
    v.attributes.x = pick(first, a.attributes.x, b.attributes.x);
    v.attributes.y = pick(first, a.attributes.y, b.attributes.y);
    v.attributes.z = pick(first, a.attributes.z, b.attributes.z);
    return v;
}
SHARED_FN ScanValues scanAtCorner(ScanCorner c) {
    ScanValues v;
    v.z = c.z;
    v.attributes = c.attributes;
    return v;
}

SHARED_FN ScanSlope scanSlope(ScanCorner top, ScanCorner bottom) {
    bool topIsFar = top.z >= bottom.z;
    ScanSlope s;
    s.fromLine = pick(topIsFar, top.y, bottom.y);
    s.toLine = pick(topIsFar, bottom.y, top.y);
    s.from = scanChosen(topIsFar, scanAtCorner(top), scanAtCorner(bottom));
    s.to = scanChosen(topIsFar, scanAtCorner(bottom), scanAtCorner(top));
    s.step = scanStep(scanAtCorner(top), scanAtCorner(bottom), toReal(bottom.y - top.y));
    return s;
}
// Values of an edge on line y. Each corner's line has the corner's own values, so that edges meet in one point.
SHARED_FN ScanValues scanOnLine(ScanSlope s, int y) {
    return scanChosen(y == s.toLine, s.to, scanMoved(s.from, toReal(y - s.fromLine), s.step));
}

SHARED_FN ScanWalk scanStart(ScanEdge e) {
    ScanWalk w;
    w.column = e.column;
    w.rest = e.rest;
    return w;
}
SHARED_FN ScanWalk scanNext(ScanWalk w, ScanEdge e) {
    uint rest = w.rest + e.restStep;
    bool carry = rest >= e.height;
    w.column = w.column + e.columnStep + pick(carry, 1, 0);
    w.rest = rest - pick(carry, e.height, 0u);
    return w;
}

// True when, after line y, the edge that ends at `bottomY` is replaced by the next one. False where the polygon ends there.
SHARED_FN bool scanEdgeEnds(int y, int lastLine, int bottomY) { return y >= bottomY && y < lastLine; }

// True when restA / heightA < restB / heightB.
SHARED_FN bool scanIsLess(uint restA, uint heightA, uint restB, uint heightB) {
    int highA, highB;
    uint lowA, lowB;
    multiplyLong(int(restA), int(heightB), highA, lowA);
    multiplyLong(int(restB), int(heightA), highB, lowB);
    return highA < highB || (highA == highB && lowA < lowB);
}
// Fraction rest / height, rounded down to a multiple of 2^-24.
SHARED_FN float scanFraction(uint rest, uint height) {
    return floorReal(exactDivide(toReal(int(rest)), toReal(int(height))) * 16777216.0f) * 5.9604644775390625e-8f;
}

SHARED_FN ScanSpan scanSpan(ScanWalk i, uint heightI, ScanValues valuesI, ScanWalk j, uint heightJ, ScanValues valuesJ) {
    bool iIsLeft = i.column < j.column || (i.column == j.column && scanIsLess(i.rest, heightI, j.rest, heightJ));
    int leftColumn = pick(iIsLeft, i.column, j.column);
    int rightColumn = pick(iIsLeft, j.column, i.column);
    uint leftRest = pick(iIsLeft, i.rest, j.rest);
    uint rightRest = pick(iIsLeft, j.rest, i.rest);
    uint leftHeight = pick(iIsLeft, heightI, heightJ);
    uint rightHeight = pick(iIsLeft, heightJ, heightI);
    float leftFraction = scanFraction(leftRest, leftHeight);
    ScanSpan s;
    s.first = leftColumn + pick(2u * leftRest >= leftHeight, 1, 0);
    s.more = rightColumn - leftColumn - pick(scanIsLess(rightRest, rightHeight, leftRest, leftHeight), 1, 0);
    s.leftX = toReal(leftColumn) + leftFraction;
    s.wide = toReal(rightColumn - leftColumn) + (scanFraction(rightRest, rightHeight) - leftFraction);
    s.left = scanChosen(iIsLeft, valuesI, valuesJ);
    s.right = scanChosen(iIsLeft, valuesJ, valuesI);
    return s;
}

// Values across a line. The divisor is the difference of X (A7). A line of one pixel has the left end's values.
SHARED_FN ScanAcross scanAcross(ScanSpan s) {
    bool several = s.more > 0;
    bool fromRight = s.right.z > s.left.z;
    ScanAcross a;
    a.offset = pick(fromRight, -s.wide, 0.0f);
    a.toSteps = pick(fromRight, 0.0f, pick(several, s.wide, -1.0f));
    a.from = scanChosen(fromRight, s.right, s.left);
    a.to = scanChosen(fromRight, s.left, s.right);
    // no plant: without a second pixel no step is taken; the choice keeps the division in its range
    a.step = scanStep(s.left, s.right, pick(several, s.wide, 1.0f));
    return a;
}

// First and last step of a line that paint columns of the block; none when first > last.
SHARED_FN int scanFirstStep(ScanSpan s, ScanPolygon p) { return max(0, p.firstColumn - s.first); }
SHARED_FN int scanLastStep(ScanSpan s, ScanPolygon p) { return min(s.more, p.firstColumn + p.columnCount - 1 - s.first); }
SHARED_FN int scanColumn(ScanSpan s, int steps) { return s.first + steps; }
// Values of a pixel. On an end of the line they are the end's own, so that neighbouring polygons are equal there.
SHARED_FN ScanValues scanPixel(ScanAcross a, int steps) {
    float x = toReal(steps);
    return scanChosen(x == a.toSteps, a.to, scanMoved(a.from, x + a.offset, a.step));
}
SHARED_FN bool scanTakes(float z, float stored, uint zBuffer) { return z < stored || zBuffer == 0u; }

SHARED_END
#endif
