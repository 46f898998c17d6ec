// SPDX-License-Identifier: MIT
// The buffers through which a step of the raster reads what the steps before it left. verify and the twin tests fill the device's from the twin's, so
// that each pass is compared on the twin's input.
#pragma once

#include "pipeline/render/raster/gpu_frame.h"
#include "pipeline/render/raster/twin_frame.h"

namespace plumb {

// What cull left, and the passes before it: the input of setup().
void handOverCulled(const TwinGeometry& twin, const DrawList& list, GpuFrame& frame);
// What setup() left, clipped corners included: the input of bin() and fill().
void handOverSetUp(const TwinGeometry& twin, GpuFrame& frame);

}  // namespace plumb
