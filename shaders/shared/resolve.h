// SPDX-License-Identifier: MIT
// Contract of the resolve pass: s x s samples -> one pixel, in linear light. Samples are added row by row. They are the pixel's own, or its
// four corners, which it shares with its neighbours (stride 1).
// Opaque: the mean of all samples, background included. Transparent: the mean of the covered samples, and their share as alpha.
#ifndef PLUMB_RESOLVE_H
#define PLUMB_RESOLVE_H
#include "encode.h"
#include "exact.h"
SHARED_BEGIN

struct ResolvePush {
    uint statusSlot;
    uint pixelQuads;      // output pixels / 4, row pitch included
    uint rowQuads;        // row pitch of the output
    uint sampleRowQuads;  // row pitch of the sample planes
    uint samplePlaneQuads;
    uint zSlot, linearSlot;  // plane numbers in the sample planes
    uint side;               // s: 1, 2 or 4
    uint stride;             // samples from pixel to pixel: s, or 1 where neighbours share their corners (s = 2)
    uint transparent;
};

// Share of covered samples as an 8-bit code, rounded to nearest.
SHARED_FN uint coverageCode(uint covered, uint samples) { return (covered * 255u + (samples >> 1u)) / samples; }

SHARED_END
#endif
