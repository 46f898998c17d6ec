// SPDX-License-Identifier: MIT
// Rows of a composite matrix as the more accurate transforms take them (shaders/shared/long_transform.h), on the host.
#pragma once

#include "shaders/shared/long_transform.h"

#include <glm/glm.hpp>

namespace plumb {

// Of an object whose coordinates are nowhere beyond `reach`: the exponent e of X = x 2^-e, |X| at most 2^30.
int blockExponent(double reach);

// row: in binary64, of a point (x, y, z, 1). `exponent` of the object's coordinates, as above.
gpu::LongRow longRow(const glm::dvec4& row, int exponent);

}  // namespace plumb
