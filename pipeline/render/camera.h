// SPDX-License-Identifier: MIT
// The pinhole through which every way to draw sees a scene, in binary64: focal length and canvas in samples.
#pragma once

#include "pipeline/scene/scene.h"

#include <glm/glm.hpp>

namespace plumb {

// Farthest distance from the eye, in units of the near plane: squares of it and of x = focal * it stay finite.
inline constexpr double kFarthest = 0x1p60;

struct Pinhole {
    double focal = 0;  // samples
    double near = 0;
    // The passes count lengths in powers of two of the scene's unit in which 1 <= near < 2. Squares of distances then neither overflow nor underflow
    // whatever unit a scene is in, and scaling the scene by 2^k changes no bit.
    double unit = 1;
    glm::dvec3 right, down, forward, eye;
    double width = 0, height = 0;  // samples

    // Right, down and forward of the eye.
    glm::dvec3 viewOf(const glm::dvec3& world) const;
    // Direction through the point (x, y) of the canvas, relative to its middle; its forward component is 1.
    glm::dvec3 rayThrough(double x, double y) const { return forward + right * (x / focal) + down * (y / focal); }
    // Relative to the eye, in the passes' unit: the error scales with the distance to the camera, not to the origin.
    glm::dmat4 viewedFromMesh(const glm::dmat4& worldFromMesh) const;
};

// A canvas of width x height samples with `side` samples a pixel along an axis.
Pinhole pinholeOf(const Camera& camera, double width, double height, double side);

}  // namespace plumb
