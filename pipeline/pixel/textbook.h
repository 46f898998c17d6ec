// SPDX-License-Identifier: MIT
// The formulas of the lecture notes as a reader types them in, once for two kinds of number: float (the column "textbook float32") and
// Interval (the column "truth"). Errata A12 and A13 are corrected; nothing else is made better. Shares no function with the passes.
#pragma once

#include "pipeline/pixel/interval.h"
#include "pipeline/scene/scene.h"

#include <cstddef>
#include <glm/glm.hpp>
#include <map>
#include <string>
#include <vector>

namespace plumb::textbook {

template <class R>
struct Vector {
    R x{}, y{}, z{};

    Vector() = default;
    Vector(R a, R b, R c) : x(a), y(b), z(c) {}
    explicit Vector(const glm::dvec3& v) : x(R(v.x)), y(R(v.y)), z(R(v.z)) {}
    friend Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Vector operator*(const Vector& a, const R& s) { return {a.x * s, a.y * s, a.z * s}; }
    friend Vector operator/(const Vector& a, const R& s) { return {a.x / s, a.y / s, a.z / s}; }
    Vector operator-() const { return {-x, -y, -z}; }
    std::vector<R> list() const { return {x, y, z}; }
};

// 11.9: P.Q.
template <class R>
R dot(const Vector<R>& p, const Vector<R>& q) {
    return p.x * q.x + p.y * q.y + p.z * q.z;
}
// 11.10: P x Q.
template <class R>
Vector<R> cross(const Vector<R>& p, const Vector<R>& q) {
    return {p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
}
// Square of a component, which an interval around 0 must not make negative.
inline float squareOf(float x) { return x * x; }
inline Interval squareOf(const Interval& x) {
    const Interval square = x * x;
    return {x.hasZero() ? 0.0 : square.low, square.high};
}
// 11.6: |V|.
template <class R>
R magnitude(const Vector<R>& v) {
    return rootOf(squareOf(v.x) + squareOf(v.y) + squareOf(v.z));
}
// 11.7: V / |V|.
template <class R>
Vector<R> unit(const Vector<R>& v) {
    return v / magnitude(v);
}

// 12: P, Q, N, D, and N.V - D of a polygon whose first three vertices are given; `viewpoint` is V.
template <class R>
struct Plane {
    Vector<R> p, q, n, unitN;
    R magnitudeN, d, nv, result;
    Plane(const Vector<R>& p0, const Vector<R>& p1, const Vector<R>& p2, const Vector<R>& viewpoint)
        : p(p1 - p0), q(p2 - p0), n(cross(p, q)) {
        magnitudeN = magnitude(n);
        unitN = n / magnitudeN;
        d = dot(unitN, p0);
        nv = dot(unitN, viewpoint);
        result = nv - d;
    }
};

// Values by name, of one kind of number.
template <class R>
using Values = std::map<std::string, std::vector<R>>;

// 16: illumination of one point by every light, under names that begin with `prefix`.
template <class R>
struct Point {
    Vector<R> position, normal, view;  // relative to the eye, world axes; unit normal and unit view vector
};
template <class R>
Vector<R> colourOf(const glm::vec3& c) {
    return Vector<R>(glm::dvec3(c));
}
template <class R>
Vector<R> times(const Vector<R>& a, const Vector<R>& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}
// `reaches`: the share of each light that shadows leave; empty: all of every light.
template <class R>
Vector<R> illuminate(const Scene& scene, const Material& m, const Point<R>& at, const std::string& prefix, Values<R>& out,
                     const std::vector<R>& reaches = {}) {
    out[prefix + "N"] = at.normal.list();
    out[prefix + "V"] = at.view.list();
    Vector<R> colour = times(colourOf<R>(m.ambient), colourOf<R>(scene.ambient)) + colourOf<R>(m.emission);
    out[prefix + "ambient"] = colour.list();
    size_t number = 0;
    for (const Light& light : scene.lights) {
        if (light.intensity == glm::vec3(0)) continue;
        const auto name = [&](const char* what) { return prefix + what + std::to_string(number); };
        const Vector<R> toLight =
            light.directional ? Vector<R>(light.direction) : Vector<R>(light.position) - Vector<R>(scene.camera->eye) - at.position;
        const R distance = magnitude(toLight);
        const Vector<R> l = toLight / distance;
        R fade = R(1);
        if (!light.directional && light.attenuation == Attenuation::inverse) fade = R(1) / distance;
        if (!light.directional && light.attenuation == Attenuation::inverseSquare) fade = R(1) / (distance * distance);
        const R nl = dot(at.normal, l), lit = isPositive(nl);
        const Vector<R> r = at.normal * (R(2) * nl) - l;
        const R rv = dot(r, at.view), power = lit * powerOf(atLeast0(rv), double(m.shininess));
        Vector<R> intensity = colourOf<R>(light.intensity) * fade;
        if (number < reaches.size()) intensity = intensity * reaches[number];
        const Vector<R> diffuse = times(intensity, colourOf<R>(m.diffuse)) * atLeast0(nl),
                        specular = times(intensity, colourOf<R>(m.specular)) * power;
        out[name("L")] = l.list();
        if (!light.directional) out[name("d")] = {distance};
        out[name("fade")] = {fade};
        out[name("NL")] = {nl};
        out[name("R")] = r.list();
        out[name("RV")] = {rv};
        out[name("power")] = {power};
        out[name("diffuse")] = diffuse.list();
        out[name("specular")] = specular.list();
        colour = colour + diffuse + specular;
        ++number;
    }
    out[prefix + "sum"] = colour.list();
    return colour;
}

}  // namespace plumb::textbook
