// SPDX-License-Identifier: MIT
// The raster: triangles through transform, cull, setup, clip, bin and fill, the nearest at each sample.
#pragma once

#include "pipeline/render/plan_steps.h"
#include "pipeline/render/technique.h"

namespace plumb {

extern const Technique kRaster;

// The passes up to the fill, without illumination: what a picture under lines takes of the raster.
void addSurfaceSteps(StepList& steps, const Prepared& prepared, bool illuminated);

}  // namespace plumb
