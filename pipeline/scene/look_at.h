// SPDX-License-Identifier: MIT
// A camera by where it stands and what it looks at.
#pragma once

#include "pipeline/scene/scene.h"

#include <glm/glm.hpp>

namespace plumb {

// Turns a camera to look along `forward`. Where `up` is parallel to it (a view from the top), -Z is up in the picture, as on a map; and where
// that is parallel as well, +Y.
void orient(Camera&, const glm::dvec3& forward, const glm::dvec3& up, bool leftHanded = false);

// Camera at the point `eye` that looks at the point `at` of the world, in scene units. fovYDegrees: angle between the upper and the lower edge
// of the picture, 0.001 to 179. Throws Error(input) for a point that is no number up to 2^100, and where both are the same.
Camera lookAt(const glm::dvec3& eye, const glm::dvec3& at, const glm::dvec3& up = {0, 1, 0}, double fovYDegrees = 45,
              bool leftHanded = false);

}  // namespace plumb
