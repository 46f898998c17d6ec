// SPDX-License-Identifier: MIT
// An area light as the lecture notes have it (15.1): many point sources close together, which share its intensity.
#pragma once

#include "pipeline/scene/scene.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb {

// Most points of one area light. Every light of a scene is added at every shaded point, so more is a slip of the pen rather than a light.
inline constexpr uint32_t kMaxAreaPoints = 4096;

// A rectangle (or parallelogram) from `corner` along `u` and `v`, world space; with v = 0 a line along u. It shines to all sides.
struct AreaLight {
    glm::dvec3 corner{0}, u{1, 0, 0}, v{0};
    uint32_t pointsU = 1, pointsV = 1;  // pointsU * pointsV <= kMaxAreaPoints
    glm::vec3 intensity{1.0f};          // linear RGB of all points together
    Attenuation attenuation = Attenuation::none;
};

// Point lights of an area light, in the middles of pointsU x pointsV equal cells, along u first. Point (i, j) is at
//   corner + u (i + 1/2) / pointsU + v (j + 1/2) / pointsV.
// Each has the intensity divided by their number, rounded once. Nothing is random.
std::vector<Light> pointsOf(const AreaLight&);

}  // namespace plumb
