// SPDX-License-Identifier: MIT
// The truth of a traced ray, in binary64 and from the definitions (docs/rays.md): local colour by Phong with a feeler to each light, and the mirrored and
// the refracted ray, as deep as it takes. A ray carries bounds of how far its place and its direction may be from the true ones; each hit adds to
// them. A decision that they leave open (met or missed, nearer or farther, which square, lit or not, total reflection) and on which a colour hangs
// has the whole tree of rays followed again in 64 bits and then in binary128, with the same bounds in their units; what is open even there, such as
// an exact tie, is counted.
#pragma once

#include "pipeline/truth/geometry.h"
#include "pipeline/truth/ray_world.h"

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb::truth {

struct RayLimits {
    uint32_t maxDepth = 64;  // rays one after another
    double leastWeight =
        0x1p-20;  // a ray that weighs less is not followed: its colour cannot be seen, 0.003 steps at most where sRGB is steepest
    uint32_t mostRays = 4096;  // of a tree; one with more is cut at 16 times the weight, and again
};

struct RaySeen {
    glm::dvec3 colour{0};  // linear RGB, not clamped; the sky's where nothing is hit
    uint32_t object = kNone, primitive = kNone;
    double distance = INFINITY;  // from the eye, scene units
    double leftOut = 0;          // weights of the rays that were not followed, summed
};

// For one thread.
class RayTruth {
public:
    RayTruth(const RayWorld& world, const Pinhole& pinhole, const glm::dvec3& sky, const RayLimits& limits = {});

    // Along the ray through (X, Y) of the screen, from its middle, in the pinhole's samples.
    RaySeen look(double x, double y);
    uint64_t redone() const { return redone_; }        // trees that were followed again
    uint64_t undecided() const { return undecided_; }  // decisions that binary128 leaves open

private:
    const RayWorld& world_;
    const Pinhole& pinhole_;
    const glm::dvec3 sky_;
    const RayLimits limits_;
    const double brightest_, farthest_;
    uint64_t redone_ = 0, undecided_ = 0;
};

}  // namespace plumb::truth
