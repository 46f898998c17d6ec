// SPDX-License-Identifier: MIT
// Vectors in double where their squares may overflow or underflow.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace plumb {

inline double largestMagnitude(const glm::dvec2& v) { return std::max(std::abs(v.x), std::abs(v.y)); }
inline double largestMagnitude(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// Unit vector v / |v| without overflow or underflow of the squares. v is finite and not zero.
template <class Vector>
Vector unitVector(const Vector& v) {
    const Vector scaled = v / largestMagnitude(v);
    return scaled / std::sqrt(glm::dot(scaled, scaled));
}

// Length |v| without overflow or underflow of the squares; 0 for the zero vector. The scale is a power of two, so scaling rounds nothing.
template <class Vector>
double magnitude(const Vector& v) {
    const double largest = largestMagnitude(v);
    if (!(largest > 0)) return largest;
    const int exponent = std::ilogb(largest);
    Vector scaled = v;
    for (int i = 0; i < Vector::length(); ++i) scaled[i] = std::scalbn(v[i], -exponent);
    return std::scalbn(std::sqrt(glm::dot(scaled, scaled)), exponent);
}

}  // namespace plumb
