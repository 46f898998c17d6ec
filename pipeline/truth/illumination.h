// SPDX-License-Identifier: MIT
// Phong's illumination at a sample, in binary64 and from the definition (docs/accuracy.md):
//   Ka Ia + Ke + sum over lights of I f (Kd (N.L) + Ks max(R.V, 0)^n) where N.L > 0,   R = 2 (N.L) N - L,   f = 1, 1/d or 1/d^2.
#pragma once

#include "pipeline/truth/geometry.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::truth {

class Illumination {
public:
    Illumination(const Scene& scene, const Geometry& geometry);

    struct Seen {
        glm::dvec3 colour{0};  // linear RGB, not clamped
        double w = 0;          // planar depth, scene units
    };
    // Surface of visible triangle `index` at sample (X, Y): position and normal are interpolated in perspective.
    Seen at(uint32_t index, double x, double y) const;
    // Linear RGB, not clamped, of a surface of the scene's material `material`. World axes: `position` relative to the eye, unit normal
    // `n`, unit vector `v` toward the viewer.
    glm::dvec3 colourOf(uint32_t material, const glm::dvec3& position, const glm::dvec3& n, const glm::dvec3& v) const;

private:
    struct Lamp {
        bool directional = true;
        glm::dvec3 position{0};  // unit vector toward the light, or its position relative to the eye
        glm::dvec3 intensity{0};
        int power = 0;  // exponent of 1 / d
    };

    const Scene& scene_;
    const Geometry& geometry_;
    std::vector<Lamp> lamps_;
    std::vector<glm::dmat3> normalFromObject_;  // inverse transpose of each object's matrix, scaled
};

}  // namespace plumb::truth
