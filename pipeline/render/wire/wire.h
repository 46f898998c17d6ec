// SPDX-License-Identifier: MIT
// Wire frames: the lines pass on either side, then one piece of host code that turns edge owners into pixels.
#pragma once

#include "pipeline/render/prepare.h"

namespace plumb {

void drawWireCpu(const Scene& scene, const Prepared& prepared, const RenderRequest& request, RenderResult& result);
void drawWireGpu(Device& device, const Scene& scene, const Prepared& prepared, const RenderRequest& request, RenderResult& result);

}  // namespace plumb
