// SPDX-License-Identifier: MIT
// Rows of a composite matrix as the more accurate transforms take them (shaders/shared/long_transform.h), on the host.
#pragma once

#include "shaders/shared/long_transform.h"

#include <glm/glm.hpp>

namespace plumb {

// Exponent e of X = x 2^-e with |X| at most 2^30, for an object whose coordinates are nowhere beyond `reach`.
int blockExponent(double reach);

// Row for points (x, y, z, 1) from a row in binary64. `exponent`: that of the object's coordinates, from blockExponent().
gpu::LongRow longRow(const glm::dvec4& row, int exponent);

}  // namespace plumb
