// SPDX-License-Identifier: MIT
#include "pipeline/render/rays/ray_parts.h"

#include "pipeline/scene/flattened.h"
#include "pipeline/scene/ray_shares.h"
#include "shaders/shared/trace.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb {

namespace {

using glm::dvec3;

// What a ray from the eye may meet. Rays begin at the eye, not at the near plane, and pass through pixels or their corners.
class Seen {
public:
    explicit Seen(const Pinhole& view) : view_(view), halfX_(view.width / 2 + 2), halfY_(view.height / 2 + 2) {}

    bool box(const TriangleMesh& mesh, const glm::dmat4& toWorld) const {
        int beyond[5] = {};
        for (int i = 0; i < 8; ++i) {
            const dvec3 corner(i & 1 ? mesh.boundsMax.x : mesh.boundsMin.x, i & 2 ? mesh.boundsMax.y : mesh.boundsMin.y,
                               i & 4 ? mesh.boundsMax.z : mesh.boundsMin.z);
            const dvec3 p = view_.viewOf(dvec3(toWorld * glm::dvec4(corner, 1)));
            // Rounding of a corner to float32, from the eye, with a margin of 2^7.
            const double margin = 0x1p-16 * glm::length(p);
            for (int side = 0; side < 5; ++side) beyond[side] += distance(p, side) < -margin;
        }
        return std::none_of(std::begin(beyond), std::end(beyond), [](int corners) { return corners == 8; });
    }
    bool sphere(const SphereShape& s) const {
        const dvec3 c = view_.viewOf(s.centre);
        for (int side = 0; side < 5; ++side)
            if (distance(c, side) < -s.radius - 0x1p-16 * (glm::length(c) + s.radius)) return false;
        return true;
    }

private:
    // Distance to a side of the view, positive inside.
    double distance(const dvec3& p, int side) const {
        switch (side) {
            case 0:
                return p.z;
            case 1:
                return (p.x * view_.focal + halfX_ * p.z) / std::hypot(view_.focal, halfX_);
            case 2:
                return (halfX_ * p.z - p.x * view_.focal) / std::hypot(view_.focal, halfX_);
            case 3:
                return (p.y * view_.focal + halfY_ * p.z) / std::hypot(view_.focal, halfY_);
            default:
                return (halfY_ * p.z - p.y * view_.focal) / std::hypot(view_.focal, halfY_);
        }
    }
    const Pinhole& view_;
    const double halfX_, halfY_;
};

// Marks the materials of what `shows(object)`, `shows(sphere)` let through, and those of all planes.
template <class ShowsObject, class ShowsSphere>
std::vector<bool> materialsOf(const Scene& scene, const ShowsObject& object, const ShowsSphere& sphere) {
    std::vector<bool> met(scene.materials.size());
    for (const Object& o : scene.objects)
        if (object(o))
            for (const uint32_t m : scene.meshes[o.mesh].faceMaterial) met[m] = true;
    for (const SphereShape& s : scene.spheres)
        if (sphere(s)) met[s.material] = true;
    for (const PlaneShape& p : scene.planes) {
        met[p.material] = true;
        if (p.square > 0) met[p.otherMaterial] = true;
    }
    return met;
}

// As childrenOf() of the contract decides for a ray of weight 1, which is the largest. What is not refracted is mirrored.
bool mirrorsAt(const RayShares& s, float minWeight) {
    const float most = s.transmit > 0 ? s.reflect + s.transmit : s.reflect;
    return most > 0 && most >= minWeight;
}
bool passesAt(const RayShares& s, float minWeight) { return s.transmit > 0 && s.transmit >= minWeight; }

}  // namespace

std::vector<uint32_t> materialsOfRays(const Scene& scene) {
    const auto all = [](const auto&) { return true; };
    const std::vector<bool> met = materialsOf(scene, all, all);
    std::vector<uint32_t> indices;
    for (uint32_t m = 0; m < met.size(); ++m)
        if (met[m]) indices.push_back(m);
    return indices;
}

RayReach rayReachOf(const Scene& scene, const RenderRequest& request, const Pinhole& view) {
    RayReach reach;
    if (request.maxDepth <= 1) return reach;
    for (const uint32_t m : materialsOfRays(scene)) {
        const RayShares shares = raySharesOf(scene.materials[m]);
        reach.mirrors |= mirrorsAt(shares, request.minWeight);
        reach.passes |= passesAt(shares, request.minWeight);
    }
    if (!reach.mirrors && !reach.passes) return reach;
    const Seen seen(view);
    const std::vector<bool> met = materialsOf(
        scene, [&](const Object& o) { return seen.box(scene.meshes[o.mesh], worldFromMesh(scene, o)); },
        [&](const SphereShape& s) { return seen.sphere(s); });
    for (size_t m = 0; m < met.size(); ++m) {
        const RayShares shares = raySharesOf(scene.materials[m]);
        reach.eyeSends |= met[m] && (mirrorsAt(shares, request.minWeight) || passesAt(shares, request.minWeight));
    }
    return reach;
}

std::string standsAlone(const Scene& scene) {
    if (!scene.objects.empty() || scene.spheres.size() + scene.planes.size() != 1) return {};
    if (scene.spheres.empty()) return "a plane alone casts no shadow on itself";
    const SphereShape& s = scene.spheres[0];
    // From inside, a shadow ray meets the far side.
    const bool outside = glm::length(scene.camera->eye - s.centre) > s.radius * (1 + 0x1p-10);
    return outside && raySharesOf(scene.materials[s.material]).transmit == 0 ? "a sphere alone casts no shadow on its lit side" : "";
}

}  // namespace plumb
