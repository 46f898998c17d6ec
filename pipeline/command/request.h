// SPDX-License-Identifier: MIT
// From flags to what the loader and the renderer take.
#pragma once

#include "pipeline/cli/options.h"
#include "pipeline/cli/progress.h"
#include "pipeline/render/render.h"
#include "pipeline/scene/load.h"

#include <array>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb {

// The load is shown as "load", from one share of the progress to another, where it takes longer than a moment; an interrupt ends it.
LoadOptions loadOptionsOf(const Options&, Progress* progress = nullptr, double from = 0, double to = 1);
RenderRequest requestOf(const Options&, const Scene&, glm::uvec2 size);
// The verdict of docs/accuracy.md on what is drawn: "bits" or "bounded".
const char* determinismOf(const RenderRequest&);
// The packed pixel that shows where nothing is drawn.
uint32_t backgroundPixel(const RenderRequest&);

}  // namespace plumb
