// SPDX-License-Identifier: MIT
// Objects that cannot be seen: outside the view, or wholly behind a face of another object.
#pragma once

#include "pipeline/render/camera.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb {

// True when the box of the mesh lies beyond one side of the view, by a margin that covers the rounding of the passes (a pixel).
bool outsideView(const TriangleMesh& mesh, const glm::dmat4& worldFromMesh, const Pinhole& view);

// Box of an object's mesh on the screen.
struct ScreenBox {
    bool ahead = false;  // true when the whole box lies beyond the near plane, and not near the guard band's edge: nothing is clipped
    glm::dvec2 low{0}, high{0};        // samples; only where `ahead`
    double nearest = 0, farthest = 0;  // depth w
};
ScreenBox screenBoxOf(const TriangleMesh& mesh, const glm::dmat4& worldFromMesh, const Pinhole& view);

// For each object of the scene, the index of an object in front of it that hides it wholly, or kNone. `outside`: objects to leave aside.
std::vector<uint32_t> hidersOf(const Scene& scene, const Pinhole& view, const std::vector<bool>& outside);

}  // namespace plumb
