// SPDX-License-Identifier: MIT
#include "pipeline/render/bounds/bound_light.h"

#include "pipeline/render/technique.h"
#include "pipeline/scene/camera.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb {

namespace {

using glm::dvec3;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class Visit>
void eachTriangle(const Scene& scene, const Visit& visit) {
    for (const Object& object : scene.objects) {
        const TriangleMesh& mesh = scene.meshes[object.mesh];
        const glm::dmat4 toWorld = worldFromMesh(scene, object);
        for (const TriangleMesh::Triangle& t : mesh.triangles) visit(toWorld, mesh, t);
    }
}

}  // namespace

// Distance by C. Ericson, Real-Time Collision Detection, 2005, 5.1.5.
double distanceToTriangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
    const dvec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap), d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp), d5 = glm::dot(ab, cp),
                 d6 = glm::dot(ac, cp);
    if (d1 <= 0 && d2 <= 0) return glm::length(ap);
    if (d3 >= 0 && d4 <= d3) return glm::length(bp);
    if (d6 >= 0 && d5 <= d6) return glm::length(cp);
    const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return glm::length(ap - ab * (d1 / (d1 - d3)));
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return glm::length(ap - ac * (d2 / (d2 - d6)));
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return glm::length(bp - (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))));
    const double sum = va + vb + vc;
    return sum > 0 ? glm::length(ap - (ab * vb + ac * vc) / sum) : 0;
}

LitPoints::LitPoints(const Scene& scene, const RenderRequest& request) : camera_(*scene.camera) {
    const double side = request.samples == 16 ? 4 : request.samples == 4 ? 2 : 1;
    focal_ = focalOf(camera_, side * request.height, side);
    near_ = nearOf(camera_);
    traced_ = isTraced(request);
}

double LitPoints::aside(const Corners& p) const {
    const Extent e = extentOf(p);
    return shift(e) + alongRay(e, e.reach);
}

double LitPoints::fromLamp(const dvec3& lamp, const Corners& p) const {
    const Extent e = extentOf(p);
    const double distance = distanceToTriangle(lamp, p[0], p[1], p[2]), lampReach = glm::length(lamp - camera_.eye);
    // Points at a distance `x` from the light are at most lampReach + x from the eye. x less the error of float32 there is least at one of
    // the two ends.
    const double last = std::max(distance, e.reach - lampReach);
    const auto left = [&](double x) { return x - alongRay(e, std::min(e.reach, lampReach + x)); };
    return std::max(0.0, std::min(left(distance), left(last)) - shift(e));
}

LitPoints::Extent LitPoints::extentOf(const Corners& p) const {
    Extent e;
    for (const dvec3& corner : p) {
        const double depth = glm::dot(corner - camera_.eye, camera_.forward);
        e.reach = std::max(e.reach, glm::length(corner - camera_.eye));
        e.least = std::min(e.least, depth);
        e.most = std::max(e.most, depth);
    }
    e.least = std::max(e.least, near_);
    e.most = std::max(e.most, e.least);
    return e;
}

double LitPoints::shift(const Extent& e) const { return std::ldexp(e.reach, -20) + (traced_ ? 0 : e.most / focal_ * std::sqrt(2.0) / 512); }

double LitPoints::alongRay(const Extent& e, double reach) const { return traced_ ? 0 : reach * std::ldexp(12 * reach / e.least + 40, -24); }

double fadeAt(const Light& light, double distance) {
    if (light.directional || light.attenuation == Attenuation::none) return 1;
    return distance == kInfinity ? 0 : 1 / std::pow(distance, int(light.attenuation));
}

std::vector<dvec3> mostLightOfMaterials(const Scene& scene, const RenderRequest& request) {
    const LitPoints points(scene, request);
    std::vector<dvec3> sum(scene.materials.size(), dvec3(0));
    for (const Light& light : scene.lights) {
        std::vector<double> nearest(scene.materials.size(), kInfinity);
        const auto meet = [&](uint32_t material, double distance) {
            nearest[material] = std::min(nearest[material], std::max(0.0, distance));
        };
        if (!light.directional && light.attenuation != Attenuation::none) {
            eachTriangle(scene, [&](const glm::dmat4& toWorld, const TriangleMesh& mesh, const TriangleMesh::Triangle& t) {
                dvec3 p[3];
                for (int i = 0; i < 3; ++i) p[i] = dvec3(toWorld * glm::dvec4(dvec3(mesh.positions[t.vertex[size_t(i)]]), 1));
                meet(mesh.faceMaterial[t.face], points.fromLamp(light.position, p));
            });
            // Spheres and planes are met by rays, too; a bounded plane is part of the whole one.
            for (const SphereShape& s : scene.spheres)
                meet(s.material, std::abs(glm::length(s.centre - light.position) - s.radius) -
                                     std::ldexp(glm::length(s.centre - scene.camera->eye) + s.radius, -20));
            for (const PlaneShape& p : scene.planes)
                for (const uint32_t material : {p.material, p.square > 0 ? p.otherMaterial : p.material})
                    meet(material, std::abs(glm::dot(p.normal, light.position - p.point)) -
                                       std::ldexp(glm::length(light.position - scene.camera->eye), -20));
        }
        for (size_t m = 0; m < sum.size(); ++m) sum[m] += dvec3(light.intensity) * fadeAt(light, nearest[m]);
    }
    return sum;
}

}  // namespace plumb
