// SPDX-License-Identifier: MIT
// Which steps draw a picture by a request, for each way to draw.
#pragma once

#include "pipeline/render/prepare.h"

namespace plumb {

// Adds the steps of the picture to `prepared`.plan: those of the device, or those of the twin, each with those of the host.
void planSteps(const Scene& scene, const RenderRequest& request, RunsOn side, Prepared& prepared);

}  // namespace plumb
