// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/bench/raster.h"
#include "pipeline/passes/draw_list.h"

#include <cstdint>
#include <span>

namespace plumb {

// Agreement of two pictures. `passes` has `pitch` pixels a row, `baseline` has no padding; alpha 0 is "not drawn".
Agreement agreementOf(const DrawList& list, uint32_t width, uint32_t height, std::span<const uint32_t> passes, uint32_t pitch,
                      std::span<const uint32_t> baseline);

}  // namespace plumb
