// SPDX-License-Identifier: MIT
// The transforms of 2-D and 3-D graphics as homogeneous matrices in binary64: 3x3 for the plane, 4x4 for space.
//
// Matrices are for column vectors (matrix * point), as in scene files; rowForm() gives the other notation (point * matrix).
// Angles are in degrees; multiples of 90 are exact. A positive angle takes +X to +Y (about Z), +Z to +X (about Y) and +Y to +Z
// (about X). The same numbers serve both handednesses. A positive turn is counter-clockwise seen from the tip of the axis in a
// right-handed system, and from its tail in a left-handed one.
#pragma once

#include "pipeline/transform/degrees.h"

#include <array>
#include <glm/glm.hpp>
#include <optional>
#include <span>

namespace plumb {

// Matrix from its rows, as they are written on paper.
glm::dmat3 fromRows(const double (&rows)[9]);
glm::dmat4 fromRows(const double (&rows)[16]);

glm::dmat3 translation(const glm::dvec2& by);
glm::dmat4 translation(const glm::dvec3& by);
glm::dmat3 scaling(const glm::dvec2& factors);
glm::dmat4 scaling(const glm::dvec3& factors);  // about the origin; a factor of 0 collapses and has no inverse

glm::dmat3 rotation(double degrees);  // in the plane, about the origin
glm::dmat4 rotationX(const SineCosine&);
glm::dmat4 rotationY(const SineCosine&);
glm::dmat4 rotationZ(const SineCosine&);
inline glm::dmat4 rotationX(double degrees) { return rotationX(sineCosineOfDegrees(degrees)); }
inline glm::dmat4 rotationY(double degrees) { return rotationY(sineCosineOfDegrees(degrees)); }
inline glm::dmat4 rotationZ(double degrees) { return rotationZ(sineCosineOfDegrees(degrees)); }
// Rotation by Rodrigues' formula; `axis` is a unit vector from the origin. No axis is special, unlike in lineRotation().
glm::dmat4 rotation(const glm::dvec3& axis, double degrees);

// Transform T(point) * m * T(-point): `point` stays fixed (in-place rotation and scaling).
glm::dmat3 about(const glm::dvec2& point, const glm::dmat3& m);
glm::dmat4 about(const glm::dvec3& point, const glm::dmat4& m);

// Rotation about the line through two points, as the seven elementary matrices of the classic construction, in order of
// application: T(-from), the X rotation that takes the line into the plane Y = 0, the Y rotation that takes it onto +Z, the
// turn, and the first three undone. Counter-clockwise seen from `from` to `to` in a left-handed system.
struct LineAngles {
    double a, b, c;          // to - from
    double s, length;        // hypot(b, c); |to - from|
    SineCosine alpha, beta;  // angles of the X and Y rotations; alpha is 0 when the line is parallel to X
};
std::optional<LineAngles> lineAngles(const glm::dvec3& from, const glm::dvec3& to);  // none: the points are the same
std::optional<std::array<glm::dmat4, 7>> lineRotation(const glm::dvec3& from, const glm::dvec3& to, double degrees);

// Inverse of a matrix. None: singular, or so nearly that entries of the inverse would overflow (kMinDeterminant).
std::optional<glm::dmat3> inverseOf(const glm::dmat3&);
std::optional<glm::dmat4> inverseOf(const glm::dmat4&);
// True when the upper 3x3 has an inverse transpose, which normals need.
bool hasInverse(const glm::dmat4&);
// Least determinant for an inverse. A 3x3 matrix scaled to a largest entry of 1 has an inverse with entries below 2^101 when its
// determinant is above this.
inline constexpr double kMinDeterminant = 0x1p-100;

// Matrix in the notation point * matrix: the transpose.
inline glm::dmat3 rowForm(const glm::dmat3& m) { return glm::transpose(m); }
inline glm::dmat4 rowForm(const glm::dmat4& m) { return glm::transpose(m); }

// Transformation in coordinates with the Z axis reversed: from left-handed to right-handed and back.
glm::dmat4 withZReversed(const glm::dmat4&);

// Centre of the bounding box, per axis; without overflow. `points` is not empty.
glm::dvec2 visualCentre(std::span<const glm::dvec2> points);
glm::dvec3 visualCentre(std::span<const glm::dvec3> points);

inline glm::dvec2 transformed(const glm::dmat3& m, const glm::dvec2& p) { return glm::dvec2(m * glm::dvec3(p, 1)); }
inline glm::dvec3 transformed(const glm::dmat4& m, const glm::dvec3& p) { return glm::dvec3(m * glm::dvec4(p, 1)); }

}  // namespace plumb
