// SPDX-License-Identifier: MIT
#include "pipeline/render/rays/trace_samples.h"

#include "pipeline/passes/tree.h"
#include "pipeline/scene/flattened.h"
#include "pipeline/scene/ray_shares.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

namespace {

constexpr double kFarthest = 0x1p60;      // gpu::kFarthestHit
constexpr double kLeastRadius = 0x1p-30;  // of the near plane: squares and their errors stay normal
constexpr double kFarRadii = 256;         // beyond, the plain form loses more than 2^-14 of the radius (docs/accuracy.md, rays)
constexpr double kCloseRadii = 1.0 / 16;  // nearer to a surface, the plain form loses more than 2^-18 of the eye's distance from it
constexpr float kUnbounded = 0x1p100f;
constexpr size_t kMostParts = size_t(1) << 25;  // texels of a device: 2^27, at most three a part

class Records {
public:
    Records(const Scene& scene, const Prepared& p)
        : scene_(scene), eye_(scene.camera->eye), unit_(p.unit), slots_(scene.materials.size(), kNone) {
        out_.lights = p.list.lights;
    }

    TraceScene build() {
        for (const SphereShape& s : scene_.spheres) addSphere(s);
        for (const PlaneShape& p : scene_.planes) addPlane(p);
        for (const Object& object : scene_.objects) addObject(object);
        std::vector<glm::vec3> triangles;
        for (size_t i = 0; i < out_.triangles.size(); i += 2)
            for (int k = 0; k < 3; ++k) triangles.emplace_back(out_.corners[2 * size_t(out_.triangles[i][k])]);
        TriangleTree tree = treeOfTriangles(triangles);
        out_.nodes = std::move(tree.nodes);
        out_.depth = tree.depth;
        out_.leaves.reserve(tree.leaves.size() * 3);
        for (const uint32_t t : tree.leaves)
            for (size_t k = 0; k < 3; ++k) {
                const glm::vec3& c = triangles[3 * size_t(t) + k];
                out_.leaves.emplace_back(gpu::ubitsOf(c.x), gpu::ubitsOf(c.y), gpu::ubitsOf(c.z), k == 0 ? t : 0u);
            }
        for (const glm::vec3& c : triangles) out_.reach = std::max({out_.reach, std::abs(c.x), std::abs(c.y), std::abs(c.z)});
        reach_ = std::max(reach_, 2 * out_.reach);
        for (const glm::vec4& s : out_.spheres) out_.far |= double(reach_) * 2 > kFarRadii * double(s.w);
        return std::move(out_);
    }

    // Adds the spheres, and states what they ask for. The other parts of the scene say how far a ray may come from.
    void stateForms(Plan& plan) {
        for (const SphereShape& s : scene_.spheres) addSphere(s);
        float reach = 0;
        for (const Object& object : scene_.objects) {
            const glm::dmat4 toWorld = worldFromMesh(scene_, object);
            for (const glm::vec3& position : scene_.meshes[object.mesh].positions) {
                const glm::vec3 p = rounded((glm::dvec3(toWorld * glm::dvec4(position, 1)) - eye_) * unit_);
                reach = std::max({reach, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
            }
        }
        reach_ = std::max(reach_, 2 * reach);
        constexpr double kUnit = 0x1p-24;
        for (size_t i = 0; i < out_.spheres.size(); ++i) {
            const double radius = out_.spheres[i].w, radii = double(reach_) * 2 / radius;
            const double gap = std::abs(double(out_.powers[i])) / (2 * radius * radius);  // of the radius
            const std::string name =
                scene_.spheres[i].name.empty() ? fmt::format("sphere {}", i) : fmt::format("'{}'", printable(scene_.spheres[i].name, 64));
            if (radii > kFarRadii)
                plan.raised.push_back(
                    {"spheres", name, "the point nearest to the centre in twice the precision",
                     fmt::format("the usual form would be off by up to {:.2g} radii, seen from {:.3g}", (16 + radii) * kUnit, radii),
                     (16 + radii) * kUnit, 16 * kUnit, "radii"});
            if (gap < kCloseRadii)
                plan.raised.push_back(
                    {"spheres", name, "the eye's power from binary64",
                     fmt::format("the usual form would be off by up to {:.2g} of the eye's distance from it", gap > 0 ? kUnit / gap : 1.0),
                     gap > 0 ? kUnit / gap : 1.0, 5 * kUnit, "of the eye's distance"});
        }
    }

private:
    // Value in float32; subnormal numbers are flushed, so that none reaches the device.
    static float rounded(double x) { return std::abs(x) < std::numeric_limits<float>::min() ? 0.0f : float(x); }
    static glm::vec3 rounded(const glm::dvec3& v) { return {rounded(v.x), rounded(v.y), rounded(v.z)}; }
    template <class Part>
    std::string nameOf(const Part& part, const char* kind) const {
        return locationOfPart(part.location, scene_.path, kind, part.name);
    }

    // Power |c - eye|^2 - r^2 of the eye, to 2^-99 of r^2: every difference and product with its rounding error.
    double powerOf(const SphereShape& s) const {
        double high = 0, low = 0;
        const auto add = [&](double x) {
            const double sum = high + x, part = sum - high;
            low += (high - (sum - part)) + (x - part);
            high = sum;
        };
        const auto addProduct = [&](double a, double b) {
            const double product = a * b;
            low += std::fma(a, b, -product);
            add(product);
        };
        for (int i = 0; i < 3; ++i) {
            const double f = s.centre[i] - eye_[i], part = f - s.centre[i];
            const double lost = (s.centre[i] - (f - part)) - (eye_[i] + part);
            addProduct(f, f);
            low += 2 * f * lost;
        }
        addProduct(-s.radius, s.radius);
        return high + low;
    }

    void addSphere(const SphereShape& s) {
        const glm::dvec3 centre = (s.centre - eye_) * unit_;
        const double radius = s.radius * unit_, reach = glm::length(centre) + radius;
        if (!(reach <= kFarthest)) throw inputError(nameOf(s, "sphere"), "it reaches further from the eye than 2^60 times the near plane");
        if (radius < kLeastRadius) throw inputError(nameOf(s, "sphere"), "its radius is below 2^-30 of the near plane");
        out_.spheres.emplace_back(rounded(centre), float(radius));
        const double power = powerOf(s);
        out_.powers.push_back(rounded(power * (unit_ * unit_)));
        out_.close |= std::abs(power) < kCloseRadii * 2 * s.radius * s.radius;
        reach_ = std::max(reach_, float(reach));
        out_.surfaces.push_back(slotOf(s.material));
    }

    void addPlane(const PlaneShape& p) {
        gpu::PlaneRecord r{};
        r.normal = rounded(p.normal);
        r.u = rounded(p.u);
        r.v = rounded(p.v);
        const glm::dvec3 anchor = (p.point - eye_) * unit_;
        if (!(glm::length(anchor) <= kFarthest))
            throw inputError(nameOf(p, "plane"), "its point is further from the eye than 2^60 times the near plane");
        // Offsets use the rounded axes, so that the stated point lies on the plane and is the origin of its coordinates.
        r.distance = rounded(glm::dot(glm::dvec3(r.normal), anchor));
        r.u0 = rounded(-glm::dot(glm::dvec3(r.u), anchor));
        r.v0 = rounded(-glm::dot(glm::dvec3(r.v), anchor));
        const auto bound = [&](double x) { return float(std::clamp(x * unit_, -double(kUnbounded), double(kUnbounded))); };
        r.uMin = bound(p.uMin);
        r.uMax = bound(p.uMax);
        r.vMin = bound(p.vMin);
        r.vMax = bound(p.vMax);
        r.square = p.square > 0 ? float(std::clamp(p.square * unit_, 0x1p-60, double(kUnbounded))) : 0.0f;
        r.mirrored = p.mirrored ? 1.0f : 0.0f;
        r.twoSided = p.twoSided ? 1.0f : 0.0f;
        out_.surfaces.push_back(slotOf(p.material));
        r.other = p.square > 0 ? float(slotOf(p.otherMaterial)) : 0.0f;
        out_.planes.push_back(r);
    }

    // Adds an object's triangles in world space, relative to the eye: composed in binary64, rounded once.
    void addObject(const Object& object) {
        const TriangleMesh& mesh = scene_.meshes[object.mesh];
        const glm::dmat4 toWorld = worldFromMesh(scene_, object);
        const glm::dmat3 linear(toWorld);
        const bool mirrored = mirrors(toWorld);
        glm::dmat3 normals;  // cofactors: the inverse transpose times the determinant
        normals[0] = glm::cross(linear[1], linear[2]);
        normals[1] = glm::cross(linear[2], linear[0]);
        normals[2] = glm::cross(linear[0], linear[1]);
        if (mirrored) normals = -normals;
        const auto first = uint32_t(out_.corners.size() / 2);
        if ((out_.triangles.size() / 2 + mesh.triangles.size() + out_.corners.size() / 2 + mesh.positions.size()) > kMostParts)
            throw inputError(scene_.path, fmt::format("--shading ray takes at most {} triangles and corners", kMostParts));
        for (size_t i = 0; i < mesh.positions.size(); ++i) {
            const glm::dvec3 p = (glm::dvec3(toWorld * glm::dvec4(mesh.positions[i], 1)) - eye_) * unit_;
            if (!(glm::length(p) <= kFarthest))
                throw inputError(nameOf(object, "object"), "it reaches further from the eye than 2^60 times the near plane");
            out_.corners.emplace_back(rounded(p), 1.0f);
            out_.corners.emplace_back(rounded(unitOr(normals * glm::dvec3(mesh.normals[i]), {0, 0, 1})), 0.0f);
        }
        for (const TriangleMesh::Triangle& t : mesh.triangles) {
            glm::dvec3 corner[3];
            for (int k = 0; k < 3; ++k) corner[k] = glm::dvec3(out_.corners[2 * size_t(first + t.vertex[k])]);
            glm::dvec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
            if (mirrored) normal = -normal;
            const glm::vec3 n = rounded(unitOr(normal, {0, 0, 1}));
            out_.triangles.emplace_back(first + t.vertex[0], first + t.vertex[1], first + t.vertex[2], slotOf(mesh.faceMaterial[t.face]));
            out_.triangles.emplace_back(gpu::ubitsOf(n.x), gpu::ubitsOf(n.y), gpu::ubitsOf(n.z), 0u);
        }
    }
    static glm::dvec3 unitOr(const glm::dvec3& v, const glm::dvec3& otherwise) {
        const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
        return largest > 0 ? glm::normalize(v / largest) : otherwise;
    }

    uint32_t slotOf(uint32_t material) {
        uint32_t& slot = slots_[material];
        if (slot != kNone) return slot;
        slot = uint32_t(out_.materials.size());
        const Material& m = scene_.materials[material];
        gpu::TraceMaterial t{};
        t.base = m.ambient * scene_.ambient + m.emission;
        t.shininess = m.shininess;
        t.diffuse = m.diffuse;
        t.zeroPower = m.shininess == 0 ? 1.0f : 0.0f;
        t.specular = m.specular;
        const RayShares shares = raySharesOf(m);
        t.local = shares.local;
        t.reflect = shares.reflect;
        t.transmit = shares.transmit;
        t.index = m.refractiveIndex;
        t.inverseIndex = 1 / m.refractiveIndex;
        out_.branching |= t.reflect > 0 && t.transmit > 0;
        out_.materials.push_back(t);
        return slot;
    }

    const Scene& scene_;
    const glm::dvec3 eye_;
    const double unit_;
    std::vector<uint32_t> slots_;
    float reach_ = 0;
    TraceScene out_;
};

}  // namespace

void stateSphereForms(const Scene& scene, Prepared& prepared) {
    if (!scene.spheres.empty()) Records(scene, prepared).stateForms(prepared.plan);
}

TraceScene traceSceneOf(const Scene& scene, const Prepared& prepared) { return Records(scene, prepared).build(); }

TraceChoices traceChoicesOf(const Scene& scene, const RenderRequest& request, const Prepared& prepared, const TraceScene& traced) {
    TraceChoices c;
    c.encoding = prepared.choices.encoding;
    c.mirrors = prepared.rays.mirrors;
    c.passes = prepared.rays.passes;
    c.list = (traced.branching && c.mirrors && c.passes) || request.knobs.rayLimit != 0;
    c.sampling = sampleGridOf(prepared, request).sampling;
    c.side = prepared.side;
    c.jitterMirror = request.rays.jitterReflect;
    c.jitterPass = request.rays.jitterRefract;
    c.jitterShadow = request.rays.jitterShadow;
    c.cutLevels = request.rays.cutLevels;
    if (c.cutLevels && traced.branching)
        throw inputError(scene.path, "a material both reflects and refracts; --levels cut is of paths with one ray after another");
    c.shadows = scene.shadows && prepared.rays.shadows;
    c.parts = prepared.choices.parts;
    return c;
}

// Steps of a ray; lavapipe runs the body of a `for` once more than it has items.
uint64_t stepsOfRay(const TraceScene& traced) {
    const uint64_t objects = traced.spheres.size() + 1 + traced.planes.size() + 1;
    return objects * (1 + traced.lights.size()) + traced.lights.size() + 2;
}

}  // namespace plumb
