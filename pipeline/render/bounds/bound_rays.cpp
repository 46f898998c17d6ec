// SPDX-License-Identifier: MIT
#include "pipeline/render/bounds/bound.h"
#include "pipeline/render/bounds/bound_light.h"

#include "pipeline/scene/ray_shares.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <utility>
#include <vector>

namespace plumb {

namespace {

// Beyond, sums of brightest colours may leave float32.
constexpr double kBrightest = 0x1p100;
// A surface's own brightest colour is rounded up once, and the pass takes fewer than 2^7 operations for a surface's colour.
constexpr double kColourError = 0x1p-16;

// Rays of a sample at most: a hit sends on one child, or two where a material branches. Below the cutoff none is left.
double mostRays(const Scene& scene, const RenderRequest& request) {
    double sentOn = 0;
    bool branching = false;
    for (const Material& m : scene.materials) {
        sentOn = std::max(sentOn, double(m.reflect) + double(m.transmit));
        branching |= m.reflect > 0 && m.transmit > 0;
    }
    double count = 0;
    for (uint32_t k = 0; k < request.maxDepth; ++k) {
        const double heavy =
            request.minWeight > 0 ? std::pow(sentOn, k) / double(request.minWeight) : std::numeric_limits<double>::infinity();
        count += branching ? std::min(std::ldexp(1.0, int(k)), heavy) : 1;
    }
    return count;
}

}  // namespace

BoundOfRays::BoundOfRays(const Scene& scene, const RenderRequest& base) : glowing_(scene), base_(base) {
    if (base.rays.cutLevels) why_ = "whole levels are cut after each ray";
    if (base.rays.sampling == RayChoices::Sampling::adaptive) why_ = "adaptive sampling looks at colours, and may take other samples";
    const std::vector<glm::dvec3> light = mostLightOfMaterials(scene, base);
    glowing_.lights.clear();
    for (size_t i = 0; i < glowing_.materials.size(); ++i) {
        Material& m = glowing_.materials[i];
        const glm::dvec3 brightest = brightestOf(scene, scene.materials[i], light[i]) * (1 + kColourError);
        if (!(brightest.x < kBrightest && brightest.y < kBrightest && brightest.z < kBrightest)) why_ = kLampTouches;
        const RayShares shares = raySharesOf(m);
        m.local = shares.local;
        m.reflect = shares.reflect;
        m.transmit = shares.transmit;
        m.emission = glm::vec3(brightest);
        m.ambient = m.diffuse = m.specular = glm::vec3(0);
    }
    base_.planes = kPlaneColour | kPlaneLinear;
    base_.trade = {};
    if (why_.empty()) baseGlow_ = glowOf(base_);
}

BoundOfRays::Glow BoundOfRays::glowOf(const RenderRequest& request) const {
    RenderResult result = renderCpu(glowing_, request);
    double all = 0;
    for (const RenderCounters::RayCounts& depth : result.counters.rays) all += double(depth.primary + depth.reflected + depth.refracted);
    return {std::move(result.frame.linear), std::min(all, mostRays(glowing_, request))};
}

BoundOfRays::Moves BoundOfRays::of(const RenderRequest& request) const {
    Moves moves;
    if (!why_.empty()) {
        moves.proved = false;
        moves.why = why_;
        return moves;
    }
    // What follows every ray of both.
    RenderRequest more = base_, other = base_;
    other.maxDepth = request.maxDepth;
    other.minWeight = request.minWeight;
    more.maxDepth = std::max(base_.maxDepth, other.maxDepth);
    more.minWeight = std::min(base_.minWeight, other.minWeight);
    const auto same = [](const RenderRequest& a, const RenderRequest& b) { return a.maxDepth == b.maxDepth && a.minWeight == b.minWeight; };
    const bool baseIsMore = same(more, base_), otherIsMore = same(more, other);
    const Glow otherGlow = same(other, base_) ? baseGlow_ : glowOf(other), moreGlow = baseIsMore    ? baseGlow_
                                                                                      : otherIsMore ? otherGlow
                                                                                                    : glowOf(more);
    // Both pictures and both glows round each of their sums to u of it.
    const double rounding = 4 * std::ldexp(moreGlow.rays + 128, -24);
    moves.brighter.resize(moreGlow.linear.size());
    moves.darker.resize(moreGlow.linear.size());
    for (size_t i = 0; i < moreGlow.linear.size(); ++i) {
        const double most = double(moreGlow.linear[i]), slack = most * rounding;
        moves.brighter[i] = float(std::max(0.0, most - double(baseGlow_.linear[i])) + slack);
        moves.darker[i] = float(std::max(0.0, most - double(otherGlow.linear[i])) + slack);
    }
    return moves;
}

}  // namespace plumb
