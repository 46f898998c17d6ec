// SPDX-License-Identifier: MIT
// Vectors for three precisions: binary64; where that with its bound leaves a decision open, the 64 bits of x87; then binary128.
#pragma once

#include <cmath>
#include <glm/glm.hpp>

namespace plumb::truth {

__extension__ typedef __float128 Quad;  // NOLINT(modernize-use-using): the keyword is the compiler's own

// Unit round-off of a type.
template <class Real>
inline constexpr double kUnitOf = 0x1p-53;
template <>
inline constexpr double kUnitOf<long double> = 0x1p-64;
template <>
inline constexpr double kUnitOf<Quad> = 0x1p-113;

inline double rootOf(double x) { return std::sqrt(x); }
inline long double rootOf(long double x) { return std::sqrt(x); }
// Square root: one Newton step from 64 bits, within 2 u of binary128. x >= 0 and within the range of binary64.
inline Quad rootOf(Quad x) {
    if (!(x > 0)) return 0;
    const Quad seed = std::sqrt(static_cast<long double>(x));
    return (seed + x / seed) / 2;
}
// Floor for |x| below 2^1000.
inline double floorOf(double x) { return std::floor(x); }
inline long double floorOf(long double x) { return std::floor(x); }
inline Quad floorOf(Quad x) {
    Quad whole = std::floor(double(x));
    while (whole > x) whole -= 1;
    while (x - whole >= 1) whole += std::floor(double(x - whole));
    return whole;
}

template <class Real>
struct Vec3 {
    Real x = 0, y = 0, z = 0;

    Vec3() = default;
    Vec3(Real a, Real b, Real c) : x(a), y(b), z(c) {}
    template <class Vector>
    explicit Vec3(const Vector& v) : x(v.x), y(v.y), z(v.z) {}

    friend Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Vec3 operator*(const Vec3& a, Real s) { return {a.x * s, a.y * s, a.z * s}; }
    Vec3 operator-() const { return {-x, -y, -z}; }
};
template <class Real>
Real along(const Vec3<Real>& a, const Vec3<Real>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
Vec3<Real> across(const Vec3<Real>& a, const Vec3<Real>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Real>
Real lengthOf(const Vec3<Real>& v) {
    return rootOf(along(v, v));
}
// Unit vector along v, which is not zero.
template <class Real>
Vec3<Real> unitOf(const Vec3<Real>& v) {
    return v * (1 / lengthOf(v));
}
template <class Real>
glm::dvec3 rounded(const Vec3<Real>& v) {
    return {double(v.x), double(v.y), double(v.z)};
}

}  // namespace plumb::truth
