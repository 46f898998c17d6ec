// SPDX-License-Identifier: MIT
// The screen grid and exact integer geometry on it (docs/illumination.md, Polygons without rays). Pixel (x, y) is sampled at its
// centre (256 x + 128, 256 y + 128) in sub-pixels, y down. A triangle that faces the viewer runs counter-clockwise as
// seen, and then every edge value below is positive inside.
#ifndef PLUMB_FIXED_POINT_H
#define PLUMB_FIXED_POINT_H
#include "bridge.h"
SHARED_BEGIN

SHARED_CONST int kSubpixelBits = 8;
SHARED_CONST int kSubpixels = 256;
SHARED_CONST int kHalfPixel = 128;

// Guard band: how far in pixels a vertex may lie outside the frame before its triangles are clipped. A frame must satisfy (width + 2 guard)
// * (height + 2 guard) < 2^31 pixels, so that twice an area is below 2^47 square sub-pixels.
SHARED_CONST float kGuardPixels = 8192.0f;

// A triangle is narrow when its box, with the 16 x 8 pixel tiles that it touches added on every side, is below 2^23 pixels
// (so |E| < 2^39 and E / 256 fits 32 bits) and 2^22 sub-pixels long: (W + 32)(H + 24) <= W H + 56 * 8192 + 768 for
// W, H <= 8192. Others take the 64-bit set-up.
SHARED_CONST int kNarrowExtent = 2097152;
SHARED_CONST int kNarrowAreaPixels = 7900000;

SHARED_FN bool isNarrow(int extentX, int extentY) {
    bool shortEnough = extentX < kNarrowExtent && extentY < kNarrowExtent;  // first: keeps the product below in range
    int pixelsX = pick(shortEnough, (extentX >> kSubpixelBits) + 1, 0);
    int pixelsY = pick(shortEnough, (extentY >> kSubpixelBits) + 1, 0);
    return shortEnough && pixelsX * pixelsY < kNarrowAreaPixels;
}

// First and last pixel whose centre lies in [low, high] sub-pixels.
SHARED_FN int firstPixel(int low) { return (low + 127) >> kSubpixelBits; }
SHARED_FN int lastPixel(int high) { return (high - kHalfPixel) >> kSubpixelBits; }

// Edge (a, b) = (y1 - y0, x0 - x1): E(p) = a (px - x0) + b (py - y0). A sample exactly on an edge belongs to the
// triangle only when the edge is a left or a top one; the bias makes `E - bias >= 0` say so.
SHARED_FN int edgeBias(int a, int b) { return pick(a > 0 || (a == 0 && b > 0), 0, 1); }

SHARED_END
#endif
