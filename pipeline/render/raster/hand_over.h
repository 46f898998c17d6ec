// SPDX-License-Identifier: MIT
// Copies from the twin's buffers to the device's, between the steps of the raster. verify and the twin tests compare each pass on the
// twin's input in this way.
#pragma once

#include "pipeline/render/raster/gpu_frame.h"
#include "pipeline/render/raster/twin_frame.h"

namespace plumb {

// Copies the output of cull and of the passes before it: the input of setup().
void handOverCulled(const TwinGeometry& twin, const DrawList& list, GpuFrame& frame);
// Copies the output of setup(), clipped corners included: the input of bin() and fill().
void handOverSetUp(const TwinGeometry& twin, GpuFrame& frame);

}  // namespace plumb
