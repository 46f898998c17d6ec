// SPDX-License-Identifier: MIT
// `--fill notes`: polygons, not triangles, through the scanline pass. Projection, rounding to pixels and back-face culling are host
// code in binary64, the same for device and twin; illumination and fill are passes on either side.
#pragma once

#include "pipeline/render/technique.h"

namespace plumb {

extern const Technique kPolygons;

// Throws for a choice of the trade that the notes' fill does not have.
void refuseOtherTrade(const RenderRequest& request);

}  // namespace plumb
