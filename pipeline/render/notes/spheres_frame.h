// SPDX-License-Identifier: MIT
// `--fill notes` for a scene of spheres: the implicit sphere rendering of 16.5, one pass for all of it. What a scene must be for this is checked by
// prepare(); encoding and the other planes are host code, the same for device and twin.
#pragma once

#include "pipeline/passes/spheres.h"
#include "pipeline/render/prepare.h"

namespace plumb {

void drawSpheresCpu(const Scene& scene, const Prepared& prepared, const RenderRequest& request, RenderResult& result);
void drawSpheresGpu(Device& device, const Scene& scene, const Prepared& prepared, const RenderRequest& request, RenderResult& result);

}  // namespace plumb
