// SPDX-License-Identifier: MIT
// `--fill notes`: polygons, not triangles, through the scanline pass. Projection, rounding to pixels and back-face culling are host
// code in binary64, the same for device and twin; illumination and fill are passes on either side.
#pragma once

#include "pipeline/passes/scanline.h"
#include "pipeline/render/prepare.h"
#include "pipeline/render/technique.h"

#include <cstdint>

namespace plumb {

// A polygon of the list: where it comes from.
struct NotesPolygon {
    uint32_t range;     // of the draw list
    uint32_t face;      // of its mesh
    uint32_t triangle;  // the face's first, of the scene
    uint32_t material;
};

extern const Technique kPolygons;

// Throws for a choice of the trade that the notes' fill does not have.
void refuseOtherTrade(const RenderRequest& request);

}  // namespace plumb
