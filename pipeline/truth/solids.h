// SPDX-License-Identifier: MIT
// Generated spheres and cylinders as the surfaces themselves: what more and smaller polygons come closer to. A sample's ray is taken into the space of
// the object, where a sphere or a cylinder with its two caps is a convex body: the ray is inside from the last surface that it enters to the first
// that it leaves. Every number has a running bound of its error. A sign that binary64 leaves open is found again in binary128; one that is open even
// there, such as an exact tie, is counted.
#pragma once

#include "pipeline/scene/scene.h"
#include "pipeline/truth/geometry.h"
#include "pipeline/truth/shading_error.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::truth {

// The part of a body that a ray meets.
struct SolidHit {
    uint32_t object = kNone;  // kNone: nothing is met
    Bounded w;                // planar depth, scene units
    glm::dvec3 position{0};   // world axes, relative to the eye
    double positionError = 0;
    Direction normal;  // world axes, outward
    uint32_t material = 0;
};

// Bodies of a scene (standsForSolid()).
class Solids {
public:
    Solids(const Scene& scene, const Pinhole& pinhole);
    bool empty() const { return bodies_.empty(); }

    // Counts of one thread.
    struct Counts {
        uint64_t redone = 0;     // rays that were taken again in binary128
        uint64_t undecided = 0;  // decisions that binary128 leaves open
    };
    // The nearest hit at or beyond the near plane by the ray of sample (X, Y); of equal depths the object with the smaller number.
    SolidHit look(double x, double y, Counts& counts) const;

    struct Body {
        uint32_t object = 0, material = 0;
        bool cylinder = false;
        double radius = 1, half = 1;  // of a cylinder: half of its length
        glm::dmat4 worldFromObject{1};
        double low[2] = {0, 0}, high[2] = {0, 0};  // box on the screen, in samples from the middle; outside it nothing is met
    };

private:
    const Scene& scene_;
    Pinhole pinhole_;
    std::vector<Body> bodies_;
};

}  // namespace plumb::truth
