// SPDX-License-Identifier: MIT
// Origin of a mesh's own coordinates. float32 spaces its numbers by their distance from 0, so a mesh far from 0 would lose digits that a
// near one keeps.
#pragma once

#include <glm/glm.hpp>

namespace plumb {

// Distance from 0, in half extents (the largest of the three), up to which an axis keeps its origin at 0. At the limit float32 is two bits
// coarser than in a mesh about 0: a fraction of a vertex's snap to 1/256 px in any picture that shows the whole mesh. Meshes as they are
// modelled lie within 3.
inline constexpr double kNearHalfExtents = 4;

// Bits of the origin's grid: the largest half extent over the spacing of origins. So p - origin of float32 numbers is a float32 number
// again (mesh_origin_test).
inline constexpr int kOriginBits = 3;

// Origin for a mesh whose box is [low, high]. An axis has 0 where the box is near 0, else the box's middle on a grid of at least 1/16 of
// the largest half extent. 0 where a bound is not finite or low is above high.
glm::dvec3 originOfBox(const glm::dvec3& low, const glm::dvec3& high);

}  // namespace plumb
