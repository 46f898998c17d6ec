// SPDX-License-Identifier: MIT
// Vectors and matrices of scene readers, in double, beyond the room of transforms. Matrices are to-From, for column vectors.
#pragma once

#include "pipeline/scene/text.h"
#include "pipeline/transform/matrix.h"
#include "pipeline/transform/vector.h"

#include <cmath>
#include <glm/glm.hpp>

namespace plumb {

// True when no entry is NaN or above kMaxCoordinate.
inline bool entriesUsable(const glm::dmat4& m) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!(std::abs(m[column][row]) <= kMaxCoordinate)) return false;
    return true;
}

// Least length of the cross product of two unit vectors that a camera takes as not parallel. Below it the direction is rounding error.
inline constexpr double kMinCross = 0x1p-40;

}  // namespace plumb
