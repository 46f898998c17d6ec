// SPDX-License-Identifier: MIT
// Truth of the implicit sphere rendering (--fill notes, 16.5 of the notes), in binary64 and from the scene. The projection is along +Z, a
// unit a pixel. (x, y) from a sphere's centre is on the sphere where x^2 + y^2 <= r^2. There z = sqrt(r^2 - x^2 - y^2) toward the viewer,
// and (x, y, z) is the normal. The nearest sphere is seen, of equal depths the first. Neither centre nor radius nor z is rounded to whole
// numbers.
// Two decisions are taken without rounding where the bound of binary64 leaves them open: whether a point is on a sphere, and which of two
// is nearer. So there is no undecided case.
#pragma once

#include "pipeline/scene/scene.h"
#include "pipeline/truth/exact.h"
#include "pipeline/truth/illumination.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::truth {

// Truth for one thread. Reads the scene's spheres, and a camera that looks along +Z with +X to the right.
class SphereTruth {
public:
    SphereTruth(const Scene& scene, const Illumination& illumination) : scene_(scene), illumination_(illumination) {}

    struct Seen {
        uint32_t sphere = kNone;
        Bounded depth;         // depth along +Z from the eye, scene units
        BoundedColour colour;  // linear RGB, not clamped
    };
    // Sample at (x, y) of the screen from its middle, in pixels, y downward: multiples of 2^-10 of magnitude below 2^20.
    Seen look(double x, double y);
    uint64_t redone() const { return redone_; }

private:
    // Front of a sphere at a point. rest: r^2 - x^2 - y^2 there. depth: least z of the front there, from the eye. Each has a bound of its
    // error.
    struct Front {
        uint32_t sphere = kNone;
        double rest = 0, restError = 0, depth = 0, depthError = 0;
    };
    bool covers(Front& front, double x, double y);
    bool nearer(const Front& a, const Front& b, double x, double y);
    Exact exactRest(uint32_t sphere, double x, double y) const;

    const Scene& scene_;
    const Illumination& illumination_;
    uint64_t redone_ = 0;
};

}  // namespace plumb::truth
