// SPDX-License-Identifier: MIT
// World of the truth's rays: positions relative to the eye in binary64, or computed again in binary128 from the scene's own numbers.
#pragma once

#include "pipeline/scene/ray_shares.h"
#include "pipeline/scene/scene.h"
#include "pipeline/truth/real.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb::truth {

template <class Real>
struct Facet {
    Vec3<Real> corner[3];
    Vec3<Real> normal;     // geometric, unit, outward
    Vec3<Real> smooth[3];  // unit normals of the corners
    double cornerError = 0, normalError = 0;
};

class RayWorld {
public:
    explicit RayWorld(const Scene& scene);

    struct Owner {
        uint32_t object = 0, triangle = 0;  // object of the scene; triangle of its mesh
    };

    const Scene& scene() const { return scene_; }
    uint32_t facets() const { return uint32_t(owners_.size()); }
    const Owner& ownerOf(uint32_t facet) const { return owners_[facet]; }
    const Facet<double>& facet(uint32_t i) const { return facets_[i]; }
    // Facet computed again from the scene's numbers: long double, Quad.
    template <class Real>
    Facet<Real> facetIn(uint32_t i) const;
    const Material& material(uint32_t i) const { return scene_.materials[i]; }
    uint32_t materialOfFacet(uint32_t i) const;
    const RayShares& shares(uint32_t material) const { return shares_[material]; }
    // True when point light `light` lies on the facet, or light `light` lies in or shines along the plane. Nothing at a light casts a
    // shadow, and no plane does along itself; no rounding may change that.
    bool lightLiesOn(uint32_t light, uint32_t facet) const { return lightOnFacet_[light][facet]; }
    bool lightIsAlong(uint32_t light, uint32_t plane) const { return lightOnPlane_[light][plane]; }
    // Upper bound of a ray's brightness, for the colour that depends on a decision: the sky, or any material in all the light that there
    // is. A light that fades with distance counts as from its distance to the nearest surface, or from 2^-10 of the scene where it touches
    // one; `holds` then is false.
    struct Brightness {
        double most = 0;
        bool holds = true;
    };
    Brightness brightness(const glm::dvec3& sky) const;

    // Calls visit(facet) for every facet whose box, widened by `pad`, the ray may meet before longest().
    template <class Longest, class Visit>
    void eachNear(const glm::dvec3& o, const glm::dvec3& d, double pad, const Longest& longest, const Visit& visit) const;
    double reach() const { return reach_; }  // largest |coordinate| of a corner

private:
    struct Node {
        glm::dvec3 low, high;
        uint32_t first = 0,
                 count = 0;  // facets of a leaf in order_; count 0: an inner node, whose children are the next node and `first`
    };
    uint32_t split(uint32_t first, uint32_t last);

    const Scene& scene_;
    std::vector<Owner> owners_;
    std::vector<Facet<double>> facets_;
    std::vector<RayShares> shares_;
    std::vector<Node> nodes_;
    std::vector<uint32_t> order_;
    std::vector<glm::dvec3> middles_;  // while the BVH is built
    std::vector<std::vector<bool>> lightOnPlane_, lightOnFacet_;
    double reach_ = 0;
};

template <class Longest, class Visit>
void RayWorld::eachNear(const glm::dvec3& o, const glm::dvec3& d, double pad, const Longest& longest, const Visit& visit) const {
    if (nodes_.empty()) return;
    glm::dvec3 inverse;
    for (int i = 0; i < 3; ++i) inverse[i] = 1 / (std::abs(d[i]) > 1e-200 ? d[i] : d[i] < 0 ? -1e-200 : 1e-200);
    uint32_t waiting[64];
    int count = 0;
    waiting[count++] = 0;
    while (count > 0) {
        const Node& node = nodes_[waiting[--count]];
        double enter = 0, leave = longest();
        for (int i = 0; i < 3; ++i) {
            const double a = (node.low[i] - pad - o[i]) * inverse[i], b = (node.high[i] + pad - o[i]) * inverse[i];
            enter = std::max(enter, std::min(a, b));
            leave = std::min(leave, std::max(a, b));
        }
        if (enter > leave * (1 + 0x1p-40) + pad) continue;
        for (uint32_t i = 0; i < node.count; ++i) visit(order_[node.first + i]);
        if (node.count != 0) continue;
        waiting[count++] = node.first;
        waiting[count++] = uint32_t(&node - nodes_.data()) + 1;
    }
}

}  // namespace plumb::truth
