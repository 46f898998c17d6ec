// SPDX-License-Identifier: MIT
// Requests to the loader and the renderer, from flags.
#pragma once

#include "host/device.h"
#include "pipeline/cli/options.h"
#include "pipeline/cli/progress.h"
#include "pipeline/render/render.h"
#include "pipeline/scene/load.h"

#include <array>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb {

// Options of a load. It is shown as "load", from one share of the progress to another, where it takes longer than a moment; an interrupt
// ends it.
LoadOptions loadOptionsOf(const Options&, Progress* progress = nullptr, double from = 0, double to = 1);
DeviceRequest deviceRequestOf(const Options&);
// What the scene states, and the flags, which override it.
RenderRequest requestOf(const Options&, const Scene&, glm::uvec2 size);
// Verdict of docs/accuracy.md on the picture: "bits" or "bounded".
const char* determinismOf(const RenderRequest&);
// Packed pixel of the background.
uint32_t backgroundPixel(const RenderRequest&);

}  // namespace plumb
