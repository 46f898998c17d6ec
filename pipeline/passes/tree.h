// SPDX-License-Identifier: MIT
// BVH that rays walk: built on the host, the same for device and twin and from run to run.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

struct TriangleTree {
    std::vector<glm::uvec4> nodes;  // gpu::kNodeChildren children a node, two words each (shaders/shared/trace.h)
    std::vector<uint32_t> leaves;   // triangles in the order in which a walk from the first child to the last meets them
    uint32_t depth = 0;             // most nodes one below another
};

// BVH over triangles. `corners` are positions relative to the eye, three a triangle. Children whose boxes are nearer to the eye stand
// first, so primary rays meet near triangles first. Empty for no triangles.
TriangleTree treeOfTriangles(std::span<const glm::vec3> corners);

}  // namespace plumb
