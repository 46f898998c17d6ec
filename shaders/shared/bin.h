// SPDX-License-Identifier: MIT
// Contract of the bin pass: for each tile of 16 x 8 pixels the drawn triangles that may cover one of its pixels. A triangle is listed when
// its box touches the tile and no edge has the whole tile outside. The set-up pass, the bin pass and the twin use the same test.
// The order within a list is free (sets are compared). Each tile has room for a fixed number of entries. An entry beyond that overflows: it
// is counted all the same and noted by an overflow bit, from which the host completes the list (pipeline/passes/tile_lists.h). So no entry
// is lost, however many triangles a tile has.
#ifndef PLUMB_BIN_H
#define PLUMB_BIN_H
#include "fill.h"
SHARED_BEGIN

struct BinPush {
    uint statusSlot;
    uint itemCount;           // drawn triangles, indices in a list of them, or strips
    uint tilesX, tilesY;      // tiles of the band
    uint room;                // entries of tile t are at t * room
    uint firstClippedVertex;  // triangles of clip fans (vertices from here on) come in strips
    FrameBox frame;
};

// Most tiles of a strip: tiles side by side in the box of one triangle, one overflow bit each. A strip is the triangle's slot in the draw
// list, tile x | y << 16 in the band, number of tiles.
SHARED_CONST uint kStripTiles = 32u;

SHARED_END
#endif
