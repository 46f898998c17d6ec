// SPDX-License-Identifier: MIT
#include "pipeline/truth/drawn.h"

#include "pipeline/scene/camera.h"
#include "pipeline/scene/flattened.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <utility>
#include <vector>

namespace plumb::truth {

namespace {

double single(double x) { return std::abs(x) < double(std::numeric_limits<float>::min()) ? 0.0 : double(float(x)); }
glm::dvec3 single(const glm::dvec3& v) { return {single(v.x), single(v.y), single(v.z)}; }

// Corners and normals in the world. A mirroring matrix turns the triangles around; here that is their order.
TriangleMesh meshOf(const Scene& scene, const Object& object, double unit) {
    TriangleMesh out = scene.meshes[object.mesh];
    const glm::dmat4 toWorld = worldFromMesh(scene, object);
    const bool turned = mirrors(toWorld);
    const glm::dmat3 m(toWorld);
    const glm::dmat3 cofactors = glm::dmat3(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])) * (turned ? -1.0 : 1.0);
    for (glm::vec3& p : out.positions) p = single((glm::dvec3(toWorld * glm::dvec4(p, 1)) - scene.camera->eye) * unit);
    for (glm::vec3& n : out.normals) {
        const glm::dvec3 world = cofactors * glm::dvec3(n);
        const double largest = std::max({std::abs(world.x), std::abs(world.y), std::abs(world.z)});
        n = largest > 0 ? glm::vec3(single(glm::normalize(world / largest))) : glm::vec3(0, 0, 1);
    }
    if (turned)
        for (TriangleMesh::Triangle& t : out.triangles) std::swap(t.vertex[1], t.vertex[2]);
    out.origin = glm::dvec3(0);
    out.stated.clear();
    return out;
}

// The plane n.x = distance with coordinates (u.x + u0, v.x + v0), each number rounded: its point is where all three are 0.
PlaneShape planeOf(const PlaneShape& stated, const glm::dvec3& eye, double unit) {
    PlaneShape p = stated;
    const glm::dvec3 anchor = (stated.point - eye) * unit;
    p.normal = single(stated.normal);
    p.u = single(stated.u);
    p.v = single(stated.v);
    const glm::dvec3 offsets(single(glm::dot(p.normal, anchor)), single(glm::dot(p.u, anchor)), single(glm::dot(p.v, anchor)));
    p.point = glm::inverse(glm::transpose(glm::dmat3(p.normal, p.u, p.v))) * offsets;
    for (double* bound : {&p.uMin, &p.uMax, &p.vMin, &p.vMax})
        if (std::abs(*bound) < 1e300) *bound = single(*bound * unit);
    p.square = single(stated.square * unit);
    return p;
}

}  // namespace

DrawnScene asDrawn(const Scene& scene) {
    DrawnScene out{scene, std::ldexp(1.0, -std::ilogb(nearOf(*scene.camera)))};
    const glm::dvec3 eye = scene.camera->eye;
    Scene& s = out.scene;
    s.meshes.clear();
    for (Object& object : s.objects) {
        s.meshes.push_back(meshOf(scene, object, out.unit));
        object.mesh = uint32_t(s.meshes.size() - 1);
        object.worldFromObject = glm::dmat4(1.0);
    }
    for (SphereShape& ball : s.spheres) {
        ball.centre = single((ball.centre - eye) * out.unit);
        ball.radius = single(ball.radius * out.unit);
    }
    for (PlaneShape& plane : s.planes) plane = planeOf(plane, eye, out.unit);
    for (Light& light : s.lights) {
        if (light.directional) {
            light.direction = single(glm::normalize(light.direction));
            continue;
        }
        light.position = single((light.position - eye) * out.unit);
        for (int i = 0; i < 3; ++i) light.intensity[i] = float(single(light.intensity[i] * std::pow(out.unit, int(light.attenuation))));
    }
    s.camera->near = nearOf(*scene.camera) * out.unit;
    s.camera->eye = glm::dvec3(0);
    return out;
}

}  // namespace plumb::truth
