// SPDX-License-Identifier: MIT
// The tree of boxes that rays walk: built on the host, the same for device and twin and from run to run.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

// Two words a node (shaders/shared/trace.h). `corners` are positions relative to the eye, three a triangle. Of two children the one whose
// box is nearer to the eye stands first, so primary rays meet what is near first. Empty for no triangles.
std::vector<glm::uvec4> treeOfTriangles(std::span<const glm::vec3> corners);

}  // namespace plumb
