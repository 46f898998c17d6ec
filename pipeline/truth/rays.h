// SPDX-License-Identifier: MIT
// Truth of a traced ray, in binary64 and from the definitions (docs/rays.md). It is the local colour by Phong with a shadow ray to each
// light, and the mirrored and the refracted ray, to any depth. A ray has bounds of the error of its origin and of its direction; each hit
// adds to them. Decisions are: met or missed, nearer or farther, which square, lit or not, total reflection. Where a colour depends on a
// decision that the bounds leave open, the whole tree of rays is traced again in 64 bits, and then in binary128. The bounds are the same in
// their units. A decision that is open even there, such as an exact tie, is counted.
#pragma once

#include "pipeline/truth/geometry.h"
#include "pipeline/truth/ray_world.h"

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb::truth {

struct RayLimits {
    uint32_t maxDepth = 64;  // longest chain of rays
    double leastWeight =
        0x1p-20;  // a ray that weighs less is not followed: its colour cannot be seen, 0.003 steps at most where sRGB is steepest
    uint32_t mostRays = 4096;  // most rays of a tree; a tree with more is cut at 16 times the weight, and again
};

struct RaySeen {
    glm::dvec3 colour{0};  // linear RGB, not clamped; the sky's where nothing is hit
    uint32_t object = kNone, primitive = kNone;
    double distance = INFINITY;  // distance from the eye, scene units
    double leftOut = 0;          // sum of the weights of the rays that were not followed
    // The truth's own error: no channel of the colour is further from what exact arithmetic, any depth and any weight would make of it.
    // +infinity where nothing bounds what was left out.
    glm::dvec3 bound{0};
    double distanceError = 0;  // scene units
    bool decided = true;       // false: binary128 leaves a decision open, and the bound says nothing
};

// Ray of a scene as it is drawn (drawn.h), with what the passes' arithmetic may make of it (docs/derivations.md, A traced picture).
struct RayDrawn {
    RaySeen seen;
    glm::dvec3 bound{0};       // no channel is drawn further from the colour
    double distanceError = 0;  // scene units
    bool decided = false;      // false: the passes' errors leave open what is met, lit or followed, and the bound says nothing
};

// Tracer for one thread.
class RayTruth {
public:
    RayTruth(const RayWorld& world, const Pinhole& pinhole, const glm::dvec3& sky, const RayLimits& limits = {});

    // Traces the ray through (X, Y) of the screen, from its middle, in the pinhole's samples.
    RaySeen look(double x, double y);
    RayDrawn lookDrawn(double x, double y);
    uint64_t redone() const { return redone_; }        // trees that were traced again
    uint64_t undecided() const { return undecided_; }  // decisions that binary128 leaves open

private:
    const RayWorld& world_;
    const Pinhole& pinhole_;
    const glm::dvec3 sky_;
    const RayLimits limits_;
    const double brightest_, boundedBy_, farthest_;
    uint64_t redone_ = 0, undecided_ = 0;
};

}  // namespace plumb::truth
