// SPDX-License-Identifier: MIT
// Objects whose matrix has no inverse: a scale of 0 flattens them to a plane, a line or a point.
#pragma once

#include "pipeline/scene/mesh.h"

#include <glm/glm.hpp>

namespace plumb {

// True when the matrix turns triangles around: its determinant is below 0 by more than the rounding of a few products of matrices. A matrix
// that flattens turns nothing, whatever sign its rounding has.
bool mirrors(const glm::dmat4& worldFromObject);

// True when no triangle of the mesh has an area under the matrix, so that only a wire frame shows something.
bool leavesNoArea(const TriangleMesh& mesh, const glm::dmat4& worldFromObject);

}  // namespace plumb
