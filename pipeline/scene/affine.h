// SPDX-License-Identifier: MIT
// What scene readers ask of vectors and matrices, in double. Matrices are to-From, for column vectors.
#pragma once

#include "pipeline/scene/text.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace plumb {

inline double largestMagnitude(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// v / |v| without overflow or underflow of the squares. v is not zero.
inline glm::dvec3 unitVector(const glm::dvec3& v) {
    const glm::dvec3 scaled = v / largestMagnitude(v);
    return scaled / std::sqrt(glm::dot(scaled, scaled));
}

// No NaN, and nothing above kMaxCoordinate.
inline bool entriesUsable(const glm::dmat4& m) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!(std::abs(m[column][row]) <= kMaxCoordinate)) return false;
    return true;
}

// A 3x3 matrix scaled to a largest entry of 1 has an inverse with entries below 2^101 when its determinant is above this.
inline constexpr double kMinDeterminant = 0x1p-100;

// Normals need the inverse transpose of the upper 3x3.
inline bool hasInverse(const glm::dmat4& m) {
    using glm::dvec3;
    const double scale = std::max({largestMagnitude(dvec3(m[0])), largestMagnitude(dvec3(m[1])), largestMagnitude(dvec3(m[2]))});
    if (!(scale > 0)) return false;
    const glm::dmat3 linear(dvec3(m[0]) / scale, dvec3(m[1]) / scale, dvec3(m[2]) / scale);
    return std::abs(glm::determinant(linear)) >= kMinDeterminant;
}

// Two unit vectors whose cross product is shorter than this are parallel to a camera: its direction is rounding error.
inline constexpr double kMinCross = 0x1p-40;

}  // namespace plumb
