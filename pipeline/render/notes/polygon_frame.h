// SPDX-License-Identifier: MIT
// A picture of the notes' polygons: from the objects of a draw list to its planes, with the passes of one side.
#pragma once

#include "pipeline/render/notes/sides.h"
#include "pipeline/render/planes.h"

namespace plumb {

void drawPolygons(const Scene& scene, const Prepared& prepared, const RenderRequest& request, NotesSide& side, PlaneWriter& writer,
                  RenderResult& result);

}  // namespace plumb
