// SPDX-License-Identifier: MIT
#include "pipeline/truth/ray_world.h"

#include "pipeline/scene/flattened.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numeric>
#include <utility>

namespace plumb::truth {

namespace {

constexpr uint32_t kLeafFacets = 4;

// Inverse transpose of the object's matrix up to a positive factor: cofactors, with the sign of the determinant.
template <class Real>
void normalMatrix(const glm::dmat4& m, Vec3<Real> (&columns)[3], bool& mirrored) {
    const Vec3<Real> a{glm::dvec3(m[0])}, b{glm::dvec3(m[1])}, c{glm::dvec3(m[2])};
    columns[0] = across(b, c);
    columns[1] = across(c, a);
    columns[2] = across(a, b);
    mirrored = mirrors(m);
    if (mirrored)
        for (Vec3<Real>& column : columns) column = -column;
}

}  // namespace

template <class Real>
Facet<Real> RayWorld::facetIn(uint32_t i) const {
    const Owner& owner = owners_[i];
    const Object& object = scene_.objects[owner.object];
    const TriangleMesh& mesh = scene_.meshes[object.mesh];
    const TriangleMesh::Triangle& t = mesh.triangles[owner.triangle];
    const glm::dmat4& m = object.worldFromObject;
    const glm::dvec3& eye = scene_.camera->eye;
    Vec3<Real> normals[3];
    bool mirrored = false;
    normalMatrix(m, normals, mirrored);
    Facet<Real> f;
    double size = 0, edge = 0;
    for (int k = 0; k < 3; ++k) {
        const glm::dvec3 p = mesh.statedAt(t.vertex[k]);
        const glm::vec3& n = mesh.normals[t.vertex[k]];
        Real point[3];
        for (int j = 0; j < 3; ++j) {
            const Real terms[4] = {Real(m[0][j]) * p.x, Real(m[1][j]) * p.y, Real(m[2][j]) * p.z, Real(m[3][j]) - Real(eye[j])};
            point[j] = (terms[0] + terms[1]) + (terms[2] + terms[3]);
            double sum = 0;
            for (const Real& term : terms) sum += std::abs(double(term));
            size = std::max(size, sum);
        }
        f.corner[k] = {point[0], point[1], point[2]};
        const Vec3<Real> smooth = normals[0] * Real(n.x) + normals[1] * Real(n.y) + normals[2] * Real(n.z);
        f.smooth[k] = along(smooth, smooth) > 0 ? unitOf(smooth) : smooth;
    }
    // Error of a corner: four products and three sums an axis, each within u of `size`, are 6 u an axis and in space at most sqrt(3) of
    // that.
    f.cornerError = 12 * kUnitOf<Real> * size;
    const Vec3<Real> ab = f.corner[1] - f.corner[0], ac = f.corner[2] - f.corner[0], area = across(ab, ac);
    const double twice = double(lengthOf(area));
    edge = double(lengthOf(ab)) + double(lengthOf(ac));
    f.normal = twice > 0 ? area * (1 / lengthOf(area)) : Vec3<Real>(0, 0, 1);
    if (mirrored) f.normal = -f.normal;
    // Error of the normal. A corner moved by e turns it by e times an edge over twice the area; the rest is the product's own rounding.
    f.normalError = twice > 0 ? (4 * f.cornerError * edge + 8 * kUnitOf<Real> * edge * edge) / twice + 4 * kUnitOf<Real> : 1;
    return f;
}

template Facet<long double> RayWorld::facetIn(uint32_t i) const;
template Facet<Quad> RayWorld::facetIn(uint32_t i) const;

RayWorld::RayWorld(const Scene& scene) : scene_(scene) {
    for (const Material& m : scene.materials) shares_.push_back(raySharesOf(m));
    for (uint32_t o = 0; o < scene.objects.size(); ++o) {
        const size_t count = scene.meshes[scene.objects[o].mesh].triangles.size();
        for (uint32_t t = 0; t < count; ++t) owners_.push_back({o, t});
    }
    facets_.reserve(owners_.size());
    for (uint32_t i = 0; i < owners_.size(); ++i) {
        facets_.push_back(facetIn<double>(i));
        for (const Vec3<double>& c : facets_.back().corner) reach_ = std::max({reach_, std::abs(c.x), std::abs(c.y), std::abs(c.z)});
        middles_.push_back(rounded(facets_.back().corner[0] + facets_.back().corner[1] + facets_.back().corner[2]) / 3.0);
    }
    order_.resize(owners_.size());
    std::iota(order_.begin(), order_.end(), 0u);
    if (!order_.empty()) split(0, uint32_t(order_.size()));
    middles_ = {};

    const glm::dvec3 eye = scene.camera->eye;
    for (const Light& light : scene.lights) {
        std::vector<bool> planes(scene.planes.size()), meshes(owners_.size());
        // Bound 2^-100: a few hundred roundings of binary128.
        if (light.directional) {
            for (size_t i = 0; i < scene.planes.size(); ++i)
                planes[i] = std::abs(double(along(Vec3<Quad>(scene.planes[i].normal), unitOf(Vec3<Quad>(light.direction))))) <= 0x1p-100;
        } else {
            const Vec3<Quad> at = Vec3<Quad>(light.position) - Vec3<Quad>(eye);
            const double size = 1 + glm::length(light.position) + glm::length(eye);
            const auto on = [&](const Quad& distance, double reach) { return std::abs(double(distance)) <= 0x1p-100 * (size + reach); };
            for (size_t i = 0; i < scene.planes.size(); ++i) {
                const Vec3<Quad> point = Vec3<Quad>(scene.planes[i].point) - Vec3<Quad>(eye);
                planes[i] = on(along(Vec3<Quad>(scene.planes[i].normal), at - point), glm::length(scene.planes[i].point));
            }
            for (uint32_t i = 0; i < owners_.size(); ++i) {
                const Facet<double>& f = facets_[i];
                const double rough = std::abs(along(f.normal, Vec3<double>(rounded(at)) - f.corner[0]));
                if (rough > f.normalError * (size + reach_) * 4 + 0x1p-40 * (size + reach_)) continue;
                const Facet<Quad> exact = facetIn<Quad>(i);
                meshes[i] = on(along(exact.normal, at - exact.corner[0]), reach_);
            }
        }
        lightOnPlane_.push_back(std::move(planes));
        lightOnFacet_.push_back(std::move(meshes));
    }
}

// Builds the BVH by halves, along the longest side of the box of middles; a node stands before its children.
uint32_t RayWorld::split(uint32_t first, uint32_t last) {
    const auto at = uint32_t(nodes_.size());
    nodes_.emplace_back();
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low, middleLow = low, middleHigh = high;
    for (uint32_t i = first; i < last; ++i) {
        const Facet<double>& f = facets_[order_[i]];
        for (const Vec3<double>& c : f.corner)
            low = glm::min(low, rounded(c) - f.cornerError), high = glm::max(high, rounded(c) + f.cornerError);
        middleLow = glm::min(middleLow, middles_[order_[i]]);
        middleHigh = glm::max(middleHigh, middles_[order_[i]]);
    }
    nodes_[at].low = low;
    nodes_[at].high = high;
    nodes_[at].first = first;
    nodes_[at].count = last - first;
    if (last - first <= kLeafFacets) return at;
    const glm::dvec3 extent = middleHigh - middleLow;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const uint32_t middle = first + (last - first) / 2;
    std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                     [&](uint32_t a, uint32_t b) { return middles_[a][axis] < middles_[b][axis]; });
    nodes_[at].count = 0;
    split(first, middle);
    const uint32_t second = split(middle, last);
    nodes_[at].first = second;
    return at;
}

uint32_t RayWorld::materialOfFacet(uint32_t i) const {
    const Owner& owner = owners_[i];
    const TriangleMesh& mesh = scene_.meshes[scene_.objects[owner.object].mesh];
    return mesh.faceMaterial[mesh.triangles[owner.triangle].face];
}

RayWorld::Brightness RayWorld::brightness(const glm::dvec3& sky) const {
    Brightness out;
    const glm::dvec3 eye = scene_.camera->eye;
    double size = reach_;
    for (const SphereShape& s : scene_.spheres) size = std::max(size, glm::length(s.centre - eye) + s.radius);
    for (const PlaneShape& p : scene_.planes) size = std::max(size, glm::length(p.point - eye));
    glm::dvec3 light(0);
    for (const Light& l : scene_.lights) {
        double fade = 1;
        if (!l.directional && l.attenuation != Attenuation::none) {
            double nearest = std::max(size, glm::length(l.position - eye));
            for (const SphereShape& s : scene_.spheres)
                nearest = std::min(nearest, std::abs(glm::length(s.centre - l.position) - s.radius));
            for (const PlaneShape& p : scene_.planes) nearest = std::min(nearest, std::abs(glm::dot(p.normal, l.position - p.point)));
            for (const Facet<double>& f : facets_) {
                const glm::dvec3 at = l.position - eye,
                                 low = glm::min(glm::min(rounded(f.corner[0]), rounded(f.corner[1])), rounded(f.corner[2])),
                                 high = glm::max(glm::max(rounded(f.corner[0]), rounded(f.corner[1])), rounded(f.corner[2]));
                const double box = glm::length(glm::max(glm::dvec3(0), glm::max(low - at, at - high)));
                nearest = std::min(nearest, std::max(box, std::abs(along(f.normal, Vec3<double>(at) - f.corner[0]))));
            }
            // What the distances themselves are off by is far below the rest.
            const double least = std::ldexp(size, -10);
            out.holds = out.holds && nearest > least;
            nearest = std::max(nearest, least);
            fade = l.attenuation == Attenuation::inverse ? 1 / nearest : 1 / (nearest * nearest);
        }
        light += fade * glm::dvec3(l.intensity);
    }
    double most = std::max({sky.x, sky.y, sky.z});
    for (const Material& m : scene_.materials)
        for (int c = 0; c < 3; ++c)
            most = std::max(most, double(m.ambient[c]) * double(scene_.ambient[c]) + double(m.emission[c]) +
                                      light[c] * (double(m.diffuse[c]) + double(m.specular[c])));
    out.most = most;
    return out;
}

}  // namespace plumb::truth
