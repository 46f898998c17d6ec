// SPDX-License-Identifier: MIT
// Lights that reach nothing of a draw list: no term of the illumination is above 0.
#pragma once

#include "pipeline/passes/fill.h"

#include <cstddef>
#include <cstdint>

namespace plumb {

// True when no material of the list reflects a channel that the light has.
bool isUnreflected(const gpu::LightRecord& light, const DrawList& list);

// Triangles of a list up to which isTurnedAway() is asked: it looks at each.
inline constexpr size_t kMostLookedAt = 4096;
// True when every normal that a drawn triangle is shaded by points away from the light, so that N.L <= 0 at each point whatever rounding does.
bool isTurnedAway(const gpu::LightRecord& light, const DrawList& list, uint32_t shading);

}  // namespace plumb
