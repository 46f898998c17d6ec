// SPDX-License-Identifier: MIT
// The twin of the raster: the whole list at once, the frame in bands of rows to bound memory.
#pragma once

#include "pipeline/render/planes.h"
#include "pipeline/render/prepare.h"

namespace plumb {

void drawRasterCpu(const Prepared& prepared, const RenderRequest& request, PlaneWriter& writer, RenderResult& result);

}  // namespace plumb
