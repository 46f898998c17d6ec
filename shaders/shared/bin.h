// SPDX-License-Identifier: MIT
// Contract of the bin pass: for each tile of 16 x 8 pixels the drawn triangles that may cover one of its pixels, counted first and
// then listed, so that no list can overflow. A triangle is listed when its box touches the tile and no edge has the whole tile
// outside; the same test in both steps and in the twin. The order within a list is free (sets are compared).
#ifndef PLUMB_BIN_H
#define PLUMB_BIN_H
#include "fill.h"
SHARED_BEGIN

struct BinPush {
    uint statusSlot;
    uint itemCount;                     // drawn triangles, or (large triangle, tile row) pairs
    uint tilesX, tilesY;                // of the band
    uint firstLarge, rowsPerLarge;      // of large triangles: the first in their list, and more tile rows than any of these has in the band
    uint ends;                          // word of the first tile's end in the buffer of tiles, while lists are written
    uint firstClippedVertex;            // triangles of clip fans (vertices from here on) are all binned row by row
    FrameBox frame;
};

SHARED_END
#endif
