// SPDX-License-Identifier: MIT
// Phong's illumination at a sample, in binary64 and from the definition (docs/accuracy.md):
//   Ka Ia + Ke + sum over lights of I f (Kd (N.L) + Ks max(R.V, 0)^n) where N.L > 0,   R = 2 (N.L) N - L,   f = 1, 1/d or 1/d^2.
// Each value carries a bound of its distance to what exact arithmetic makes of the scene's numbers (docs/derivations.md, The truth's own error).
#pragma once

#include "pipeline/truth/geometry.h"
#include "pipeline/truth/shading_error.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::truth {

class Illumination {
public:
    Illumination(const Scene& scene, const Geometry& geometry);

    struct Seen {
        BoundedColour colour;  // linear RGB, not clamped
        Bounded w;             // planar depth, scene units
    };
    // A visible triangle with all that its samples share.
    struct Patch {
        const Triangle* triangle = nullptr;
        glm::dvec3 normal[3], fromEye[3];  // of the corners, in the object; on world axes, relative to the eye
        double w[3] = {};
        double edgeError = 0;  // sum of the errors of the edge functions
        // Largest difference between two corners, largest value, largest error of one.
        double normalSpread = 0, normalMost = 0;
        double placeSpread = 0, placeMost = 0, placeError = 0;
        double wSpread = 0, wMost = 0, wError = 0;
        uint32_t material = 0, object = 0;
    };
    Patch patchOf(uint32_t index) const;
    // Surface of a patch at sample (X, Y), which the triangle covers: position and normal are interpolated in perspective.
    Seen at(const Patch& patch, double x, double y) const;
    // Linear RGB, not clamped, of a surface of the scene's material `material`. World axes: `position` relative to the eye and within
    // `positionError`, normal, and direction toward the viewer.
    BoundedColour colourOf(uint32_t material, const glm::dvec3& position, double positionError, const Direction& normal,
                           const Direction& toViewer) const;

private:
    struct Lamp {
        bool directional = true;
        glm::dvec3 position{0};  // unit vector toward the light, or its position relative to the eye
        glm::dvec3 intensity{0};
        double away = 0;  // length of `position`
        int power = 0;    // exponent of 1 / d
    };
    // Inverse transpose of an object's matrix, scaled. size: of the matrix, by the root of the sum of squares; error: of its error.
    struct NormalMatrix {
        glm::dmat3 m{0};
        double size = 0, error = 0;
    };

    const Scene& scene_;
    const Geometry& geometry_;
    std::vector<Lamp> lamps_;
    std::vector<NormalMatrix> normalFromObject_;
};

}  // namespace plumb::truth
