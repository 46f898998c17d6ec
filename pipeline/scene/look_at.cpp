// SPDX-License-Identifier: MIT
#include "pipeline/scene/look_at.h"

#include "host/error.h"
#include "pipeline/scene/plain_floats.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <cmath>
#include <glm/glm.hpp>

namespace plumb {

void orient(Camera& camera, const glm::dvec3& forward, const glm::dvec3& up, bool leftHanded) {
    camera.forward = glm::normalize(forward);
    for (const glm::dvec3& candidate : {up, glm::dvec3(0, 0, -1), glm::dvec3(0, 1, 0)}) {
        const glm::dvec3 right = leftHanded ? glm::cross(candidate, camera.forward) : glm::cross(camera.forward, candidate);
        if (glm::length(right) <= 1e-9 * glm::length(candidate)) continue;
        camera.right = glm::normalize(right);
        camera.up = leftHanded ? glm::cross(camera.forward, camera.right) : glm::cross(camera.right, camera.forward);
        return;
    }
}

Camera lookAt(const glm::dvec3& eye, const glm::dvec3& at, const glm::dvec3& up, double fovYDegrees, bool leftHanded) {
    const PlainFloats plain;
    const auto usable = [](const char* name, const glm::dvec3& v) {
        for (int i = 0; i < 3; ++i)
            if (!(std::abs(v[i]) <= kMaxCoordinate))
                throw inputError("camera", fmt::format("{}.{} is {}; numbers are finite, at most 2^100", name, "xyz"[i], v[i]));
    };
    usable("eye", eye);
    usable("at", at);
    usable("up", up);
    if (up == glm::dvec3(0)) throw inputError("camera", "up is 0 0 0: it has no direction");
    if (!(fovYDegrees >= 1e-3 && fovYDegrees <= 179))
        throw inputError("camera", fmt::format("fovYDegrees is {:g}, outside 0.001 to 179", fovYDegrees));
    Camera camera;
    camera.eye = eye;
    camera.fovYDegrees = fovYDegrees;
    camera.focusDistance = glm::length(at - eye);
    if (!(camera.focusDistance > 0)) throw inputError("camera", "eye and at are the same point");
    orient(camera, at - eye, up, leftHanded);
    return camera;
}

}  // namespace plumb
