// SPDX-License-Identifier: MIT
// How many pixels a movement in space can be on the screen.
#pragma once

#include "pipeline/scene/scene.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace plumb::detail {

// Largest factor by which a matrix lengthens a vector, or a little more.
double largestStretch(const glm::dmat3& m);

// How far points of an object may move, so that none moves further than `pixels` on the screen, in units of its mesh.
//
// A point at (x, y, w) of camera axes stands at f (x/w, y/w). Where it moves by v, its image moves by at most (f / w) sqrt(1 + (x^2 + y^2) / w^2) |v|: the
// largest singular value of the derivative. Let s be that root at the frame's corner, `pixels` further out, and W the least depth of the object. Any
// point of the way is then at a depth of W - D or more. So D with D f s / (W - D) = pixels is a movement that keeps it, for points that are seen.
struct Allowed {
    double deviation = 0;      // in units of the mesh; 0: none, for `why`
    double pixelsPerUnit = 0;  // largest projected scale: pixels a unit of the mesh
    const char* why = "";      // reason of 0
};
// The least over the cameras. Camera::near, or its default, must be in front of the whole object.
Allowed allowedDeviation(const Scene& scene, uint32_t object, std::span<const Camera> cameras, glm::uvec2 size, double pixels);

}  // namespace plumb::detail
