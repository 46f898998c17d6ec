// SPDX-License-Identifier: MIT
// What scene readers ask of vectors and matrices, in double, beyond the room of transforms. Matrices are to-From, for column vectors.
#pragma once

#include "pipeline/scene/text.h"
#include "pipeline/transform/matrix.h"
#include "pipeline/transform/vector.h"

#include <cmath>
#include <glm/glm.hpp>

namespace plumb {

// No NaN, and nothing above kMaxCoordinate.
inline bool entriesUsable(const glm::dmat4& m) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!(std::abs(m[column][row]) <= kMaxCoordinate)) return false;
    return true;
}

// Two unit vectors whose cross product is shorter than this are parallel to a camera: its direction is rounding error.
inline constexpr double kMinCross = 0x1p-40;

}  // namespace plumb
