// SPDX-License-Identifier: MIT
// Contract of the bin pass: for each tile of 16 x 8 pixels the drawn triangles that may cover one of its pixels. A triangle is listed
// when its box touches the tile and no edge has the whole tile outside; the same test in the set-up pass, the bin pass and the twin.
// The order within a list is free (sets are compared). Each tile has room for so many entries; what finds none is counted all the
// same and marked with a bit, and the host lists it in the end (pipeline/passes/tile_lists.h): nothing is lost however crowded a tile is.
#ifndef PLUMB_BIN_H
#define PLUMB_BIN_H
#include "fill.h"
SHARED_BEGIN

struct BinPush {
    uint statusSlot;
    uint itemCount;           // drawn triangles, places in a list of them, or strips
    uint tilesX, tilesY;      // of the band
    uint room;                // entries of tile t are at t * room
    uint firstClippedVertex;  // triangles of clip fans (vertices from here on) come in strips
    FrameBox frame;
};

// Tiles side by side in the box of one triangle: place in the draw list, tile x | y << 16 of the band, tiles. A bit of a word each.
SHARED_CONST uint kStripTiles = 32u;

SHARED_END
#endif
