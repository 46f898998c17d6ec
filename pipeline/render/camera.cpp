// SPDX-License-Identifier: MIT
#include "pipeline/render/camera.h"

#include "pipeline/scene/camera.h"

#include <cmath>
#include <glm/glm.hpp>

namespace plumb {

Pinhole pinholeOf(const Camera& camera, double width, double height, double side) {
    Pinhole v;
    v.width = width;
    v.height = height;
    v.focal = focalOf(camera, height, side);
    v.near = nearOf(camera);
    v.unit = std::ldexp(1.0, -std::ilogb(v.near));
    v.right = camera.right;
    v.down = -camera.up;
    v.forward = camera.forward;
    v.eye = camera.eye;
    return v;
}

glm::dvec3 Pinhole::viewOf(const glm::dvec3& world) const {
    const glm::dvec3 v = world - eye;
    return {glm::dot(right, v), glm::dot(down, v), glm::dot(forward, v)};
}

glm::dmat4 Pinhole::viewedFromMesh(const glm::dmat4& worldFromMesh) const {
    glm::dmat4 m = worldFromMesh;
    m[3] -= glm::dvec4(eye, 0);
    return m * unit;
}

}  // namespace plumb
