// SPDX-License-Identifier: MIT
// Points illuminated by the pass, on the device and by the twin (equal bytes), for the entries of sections 16 and 17.
#pragma once

#include "pipeline/passes/illuminate.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::golden {

struct LitPoint {
    glm::dvec3 normal, toViewer;  // any length
    uint32_t material = 0;
};

// Colours of the points under one light. `light`: a direction toward it, or with `kind` 1 a place relative to the point.
std::vector<glm::vec4> lit(const std::vector<LitPoint>& points, const std::vector<gpu::MaterialRecord>& materials,
                           const std::vector<gpu::LightRecord>& lights);

}  // namespace plumb::golden
