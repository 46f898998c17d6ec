// SPDX-License-Identifier: MIT
// The passes of the raster on the device, each on the twin's input, compared with the twin.
#pragma once

#include "pipeline/render/prepare.h"
#include "pipeline/render/stage_check.h"

namespace plumb {

// Compares the passes on one chunk, which is the whole list where that fits. Chunks and bands are compared by the whole chain.
void verifyRasterStages(Device& device, const Prepared& prepared, const RenderRequest& request, StageCheck& check);

}  // namespace plumb
