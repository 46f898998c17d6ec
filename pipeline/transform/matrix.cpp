// SPDX-License-Identifier: MIT
#include "pipeline/transform/matrix.h"

#include "pipeline/transform/vector.h"

#include <algorithm>
#include <cmath>

namespace plumb {
namespace {

using glm::dmat3;
using glm::dmat4;
using glm::dvec2;
using glm::dvec3;

template <class Matrix, size_t n>
Matrix matrixOfRows(const double (&rows)[n]) {
    Matrix m;
    const int side = Matrix::length();
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) m[column][row] = rows[row * side + column];
    return m;
}

template <class Vector>
Vector centreOf(std::span<const Vector> points) {
    Vector least = points[0], most = points[0];
    for (const Vector& p : points) {
        least = glm::min(least, p);
        most = glm::max(most, p);
    }
    return least / 2.0 + most / 2.0;  // (least + most) / 2 overflows where both are large
}

}  // namespace

dmat3 fromRows(const double (&rows)[9]) { return matrixOfRows<dmat3>(rows); }
dmat4 fromRows(const double (&rows)[16]) { return matrixOfRows<dmat4>(rows); }

dmat3 translation(const dvec2& by) { return fromRows({1, 0, by.x, 0, 1, by.y, 0, 0, 1}); }
dmat4 translation(const dvec3& by) { return fromRows({1, 0, 0, by.x, 0, 1, 0, by.y, 0, 0, 1, by.z, 0, 0, 0, 1}); }
dmat3 scaling(const dvec2& factors) { return fromRows({factors.x, 0, 0, 0, factors.y, 0, 0, 0, 1}); }
dmat4 scaling(const dvec3& factors) { return fromRows({factors.x, 0, 0, 0, 0, factors.y, 0, 0, 0, 0, factors.z, 0, 0, 0, 0, 1}); }

dmat3 rotation(double degrees) {
    const auto [s, c] = sineCosineOfDegrees(degrees);
    return fromRows({c, -s, 0, s, c, 0, 0, 0, 1});
}
dmat4 rotationX(const SineCosine& angle) {
    const auto [s, c] = angle;
    return fromRows({1, 0, 0, 0, 0, c, -s, 0, 0, s, c, 0, 0, 0, 0, 1});
}
dmat4 rotationY(const SineCosine& angle) {
    const auto [s, c] = angle;
    return fromRows({c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0, 0, 0, 0, 1});
}
dmat4 rotationZ(const SineCosine& angle) {
    const auto [s, c] = angle;
    return fromRows({c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
}
dmat4 rotation(const dvec3& axis, double degrees) {
    const auto [s, c] = sineCosineOfDegrees(degrees);
    const double v = 1 - c, x = axis.x, y = axis.y, z = axis.z;
    return fromRows({c + x * x * v, x * y * v - z * s, x * z * v + y * s, 0, y * x * v + z * s, c + y * y * v, y * z * v - x * s, 0,
                     z * x * v - y * s, z * y * v + x * s, c + z * z * v, 0, 0, 0, 0, 1});
}

dmat3 about(const dvec2& point, const dmat3& m) { return translation(point) * m * translation(-point); }
dmat4 about(const dvec3& point, const dmat4& m) { return translation(point) * m * translation(-point); }

std::optional<LineAngles> lineAngles(const dvec3& from, const dvec3& to) {
    const dvec3 way = to - from;
    LineAngles angles{way.x, way.y, way.z, magnitude(dvec2(way.y, way.z)), magnitude(way), {0, 1}, {0, 1}};
    if (!(angles.length > 0)) return std::nullopt;
    // s = 0: the line is parallel to X and lies in the plane Y = 0 already; b/s and c/s would be 0/0.
    if (angles.s > 0) angles.alpha = {angles.b / angles.s, angles.c / angles.s};
    angles.beta = {angles.a / angles.length, angles.s / angles.length};
    return angles;
}

std::optional<std::array<dmat4, 7>> lineRotation(const dvec3& from, const dvec3& to, double degrees) {
    const auto angles = lineAngles(from, to);
    if (!angles) return std::nullopt;
    const auto back = [](const SineCosine& angle) { return SineCosine{-angle.sine, angle.cosine}; };
    return std::array<dmat4, 7>{translation(-from),
                                rotationX(angles->alpha),
                                rotationY(back(angles->beta)),  // from the X axis toward +Z: against the sense of rotationY
                                rotationZ(degrees),
                                rotationY(angles->beta),
                                rotationX(back(angles->alpha)),
                                translation(from)};
}

bool hasInverse(const dmat4& m) {
    const double scale = std::max({largestMagnitude(dvec3(m[0])), largestMagnitude(dvec3(m[1])), largestMagnitude(dvec3(m[2]))});
    if (!(scale > 0)) return false;
    const dmat3 linear(dvec3(m[0]) / scale, dvec3(m[1]) / scale, dvec3(m[2]) / scale);
    return std::abs(glm::determinant(linear)) >= kMinDeterminant;
}

std::optional<dmat4> inverseOf(const dmat4& m) {
    if (!hasInverse(m)) return std::nullopt;
    return glm::inverse(m);
}

std::optional<dmat3> inverseOf(const dmat3& m) {
    const double scale = std::max(largestMagnitude(dvec2(m[0])), largestMagnitude(dvec2(m[1])));
    if (!(scale > 0)) return std::nullopt;
    const glm::dmat2 linear(dvec2(m[0]) / scale, dvec2(m[1]) / scale);
    if (!(std::abs(glm::determinant(linear)) >= kMinDeterminant)) return std::nullopt;
    return glm::inverse(m);
}

dmat4 withZReversed(const dmat4& m) {
    const dmat4 flip = scaling(dvec3(1, 1, -1));
    return flip * m * flip;
}

dvec2 visualCentre(std::span<const dvec2> points) { return centreOf(points); }
dvec3 visualCentre(std::span<const dvec3> points) { return centreOf(points); }

}  // namespace plumb
