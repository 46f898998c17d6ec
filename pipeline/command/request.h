// SPDX-License-Identifier: MIT
// From flags to what the loader and the renderer take.
#pragma once

#include "pipeline/cli/options.h"
#include "pipeline/render/render.h"
#include "pipeline/scene/load.h"

#include <array>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb {

LoadOptions loadOptionsOf(const Options&);
RenderRequest requestOf(const Options&, const Scene&, glm::uvec2 size);
// The verdict of docs/accuracy.md on what is drawn: "bits" or "bounded".
const char* determinismOf(const RenderRequest&);
// The packed pixel that shows where nothing is drawn.
uint32_t backgroundPixel(const RenderRequest&);

}  // namespace plumb
