// SPDX-License-Identifier: MIT
// Where a mesh's own coordinates start. float32 spaces its numbers by their distance from 0, so a mesh far from 0 would lose digits that a near one keeps.
#pragma once

#include <glm/glm.hpp>

namespace plumb {

// Half extents (the largest of the three) from 0 up to which an axis keeps its origin at 0. At the limit float32 is two bits coarser than in a mesh about 0:
// a fraction of a vertex's snap to 1/256 px in any picture that shows the whole of the mesh. Meshes as they are modelled lie within 3.
inline constexpr double kNearHalfExtents = 4;

// Largest of the half extents over the spacing of origins: p - origin of float32 numbers is then a float32 number again (mesh_origin_test).
inline constexpr int kOriginBits = 3;

// What is taken out of a mesh whose box is [low, high], axis by axis: 0 where it is near, else the middle of the box on a grid of at least 1/16 of the largest
// half extent. Not finite, or low above high: 0.
glm::dvec3 originOfBox(const glm::dvec3& low, const glm::dvec3& high);

}  // namespace plumb
