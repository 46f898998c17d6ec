// SPDX-License-Identifier: MIT
// Values of the planes of a picture of triangles at a pixel, from z and triangle of the sample that stands for it. Device and twin use this
// same host code.
#pragma once

#include "pipeline/render/planes.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb {

class TriangleSeen : public SeenNothing {
public:
    explicit TriangleSeen(const Prepared& prepared) : p_(prepared) {}

    const TriangleSeen& at(uint32_t x, uint32_t y, int zBits, uint32_t triangle, const glm::vec3& normal) {
        x_ = x;
        y_ = y;
        z_ = gpu::realOf(zBits);
        triangle_ = triangle;
        normal_ = normal;
        return *this;
    }

    float z() const { return z_; }
    float depth() const { return p_.near / z_; }
    float distance() const {
        const uint32_t middle = p_.side / 2;
        const double side = p_.side, centre = double(middle) + 0.5;
        const double sx = x_ * side + centre, sy = y_ * side + centre;
        const glm::dvec3 ray = glm::dvec3(p_.rayOrigin) + glm::dvec3(p_.rayX) * sx + glm::dvec3(p_.rayY) * sy;
        return float(double(depth()) * std::sqrt(glm::dot(ray, ray)));
    }
    glm::vec3 normal() const { return normal_; }
    uint32_t triangle() const { return triangle_; }
    uint32_t primitive() const { return p_.list.facePrimitive[p_.list.triangleFace[triangle_]]; }
    uint32_t object() const {
        const auto holds = [&](const DrawList::Range& r) {
            return triangle_ >= r.firstTriangle && triangle_ < r.firstTriangle + r.triangleCount;
        };
        if (!holds(p_.list.ranges[range_])) {
            range_ = 0;
            while (!holds(p_.list.ranges[range_])) ++range_;
        }
        return p_.list.ranges[range_].sceneObject;
    }

private:
    const Prepared& p_;
    uint32_t x_ = 0, y_ = 0, triangle_ = 0;
    float z_ = 0;
    glm::vec3 normal_{0};
    mutable size_t range_ = 0;  // range of the last pixel's object; neighbours often show the same one
};

}  // namespace plumb
