// SPDX-License-Identifier: MIT
// The notes' chain of a tree of rays (18.1 to 18.4.3), in float or Interval (textbook.h): each ray from its start to what it adds. Which object a ray
// hits, and what it sends on, is taken from the twin's tree; every number is computed anew, from the ray from the eye.
#pragma once

#include "pipeline/passes/trace.h"
#include "pipeline/pixel/notes_chain.h"
#include "pipeline/pixel/textbook.h"
#include "pipeline/scene/flattened.h"
#include "pipeline/scene/ray_shares.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

namespace plumb::textbook {

struct RayTreeInput {
    const Scene& scene;
    const std::vector<TracedRay>& rays;
    std::vector<uint32_t> materials;  // of the scene, one a ray that hits something
    glm::dvec3 through{0};            // vector of the ray from the eye, of any length: its t counts in these
    bool asGiven = false;             // true: formulas of 18.2.3 and 18.2.4 take that vector as T; false: its unit vector
};

// Triangle of the scene that a ray hits, by its number among all triangles.
struct SceneTriangle {
    uint32_t object = 0, triangle = 0;
};
SceneTriangle triangleOfScene(const Scene& scene, uint32_t number);
// Prefix of the names of a ray's lines: "ray1_" is the one from the eye.
inline std::string prefixOf(size_t ray) { return "ray" + std::to_string(ray + 1) + "_"; }

// Spheres, and planes, that are listed for the ray from the eye.
inline constexpr uint32_t kMostShapes = 64;

template <class R>
class RayTreeChain {
public:
    explicit RayTreeChain(const RayTreeInput& in) : in_(in) {}

    Values<R> make() {
        for (size_t i = 0; i < in_.rays.size(); ++i) follow(i);
        if (!in_.rays.empty()) lookAtShapes();
        return std::move(out_);
    }

private:
    using V = Vector<R>;
    struct State {
        V start, vector, taken;  // vector: its t counts in these; taken: T of 18.2.3 and 18.2.4
        R weight;
        V mirrored, passed;  // unit directions of what it sends on
        V point;
    };
    static R real(double x) { return R(x); }
    V fromEye(const glm::dvec3& world) const { return V(world) - V(in_.scene.camera->eye); }
    uint32_t spheres() const { return uint32_t(in_.scene.spheres.size()); }
    uint32_t shapes() const { return spheres() + uint32_t(in_.scene.planes.size()); }

    State beginning(size_t i) const {
        const TracedRay& ray = in_.rays[i];
        State s;
        if (ray.parent == gpu::kNoObject) {
            s.vector = V(in_.through);
            s.taken = in_.asGiven ? s.vector : unit(s.vector);
            s.weight = real(1);
            return s;
        }
        const State& parent = states_[ray.parent];
        const TracedRay& sender = in_.rays[ray.parent];
        const RayShares shares = raySharesOf(materialOf(ray.parent));
        s.start = parent.point;
        s.vector = s.taken = ray.kind == gpu::kCountReflected ? parent.mirrored : parent.passed;
        const R mirror =
            sender.children.passWeight == 0 ? real(double(shares.reflect)) + real(double(shares.transmit)) : real(double(shares.reflect));
        s.weight = parent.weight * (ray.kind == gpu::kCountReflected ? mirror : real(double(shares.transmit)));
        return s;
    }

    const Material& materialOf(size_t ray) const { return in_.scene.materials[in_.materials[ray]]; }

    void follow(size_t i) {
        const TracedRay& ray = in_.rays[i];
        State s = beginning(i);
        const std::string n = prefixOf(i);
        out_[n + "start"] = s.start.list();
        out_[n + "vector"] = s.vector.list();
        out_[n + "length"] = {magnitude(s.vector)};
        out_[n + "T"] = s.taken.list();
        out_[n + "weight"] = {s.weight};
        if (ray.object != gpu::kNoObject) {
            V outward, smooth;
            if (ray.object < spheres())
                sphere(n, ray, s, outward);
            else if (ray.object < shapes())
                plane(n, ray, s, outward);
            else
                triangle(n, ray, s, outward, smooth);
            shade(i, s, ray.within ? -outward : outward, ray.object < shapes() ? outward : smooth);
        }
        states_.push_back(s);
    }

    // 18.2.1: coefficients of the quadratic in t, and its discriminant.
    struct Quadratic {
        R a, b, c, discriminant;
    };
    Quadratic quadratic(const SphereShape& ball, const State& s) const {
        const V f = s.start - fromEye(ball.centre);
        Quadratic q;
        q.a = dot(s.vector, s.vector);
        q.b = real(2) * dot(s.vector, f);
        q.c = dot(f, f) - real(ball.radius) * real(ball.radius);
        q.discriminant = q.b * q.b - real(4) * q.a * q.c;
        return q;
    }
    void sphere(const std::string& n, const TracedRay& ray, State& s, V& outward) {
        const SphereShape& ball = in_.scene.spheres[ray.object];
        const Quadratic q = quadratic(ball, s);
        const R root = rootOf(atLeast0(q.discriminant)), twice = real(2) * q.a;
        out_[n + "abc"] = {q.a, q.b, q.c};
        out_[n + "discriminant"] = {q.discriminant};
        out_[n + "root"] = {root};
        const R lesser = (-q.b - root) / twice, larger = (-q.b + root) / twice;
        out_[n + "roots"] = {lesser, larger};
        met(n, s, ray.within ? larger : lesser);  // a ray from inside meets the far side alone (erratum A16)
        outward = (s.point - fromEye(ball.centre)) / real(ball.radius);
    }
    // 18.2.2: t = -(N.P - D) / (N.T).
    R meets(const std::string& n, const State& s, const V& normal, const V& on) {
        const R above = dot(normal, on - s.start), slope = dot(normal, s.vector);
        out_[n + "plane_N"] = normal.list();
        out_[n + "plane_D"] = {dot(normal, on + V(in_.scene.camera->eye))};
        out_[n + "numerator"] = {above};
        out_[n + "denominator"] = {slope};
        return above / slope;
    }
    void plane(const std::string& n, const TracedRay& ray, State& s, V& outward) {
        const PlaneShape& p = in_.scene.planes[ray.object - spheres()];
        outward = V(p.normal);
        met(n, s, meets(n, s, outward, fromEye(p.point)));
        if (!(p.square > 0)) return;
        const V on = s.point - fromEye(p.point);
        const R u = dot(on, V(p.u)), v = dot(on, V(p.v));
        out_[n + "board"] = {u, v};
        out_[n + "board_rest"] = {restOf(u, 2 * p.square), restOf(v, 2 * p.square)};
    }
    // 18.3: |x| mod m.
    static float restOf(float x, double m) { return std::fmod(std::abs(x), float(m)); }
    static Interval restOf(const Interval& x, double m) {
        const Interval size = x.low >= 0 ? x : x.high <= 0 ? -x : Interval(0, std::max(-x.low, x.high));
        const double whole = std::floor(size.low / m);
        if (whole != std::floor(size.high / m)) return {0, m};
        return size - Interval(whole) * Interval(m);
    }
    void triangle(const std::string& n, const TracedRay& ray, State& s, V& outward, V& smooth) {
        const SceneTriangle at = triangleOfScene(in_.scene, ray.object - shapes());
        const Object& object = in_.scene.objects[at.object];
        const TriangleMesh& mesh = in_.scene.meshes[object.mesh];
        const TriangleMesh::Triangle& t = mesh.triangles[at.triangle];
        const glm::dmat4& m = object.worldFromObject;
        const bool mirrored = mirrors(m);
        const auto columns = normalColumns<R>(m, mirrored);
        V corner[3], normal[3];
        for (size_t k = 0; k < 3; ++k) {
            const V p(mesh.statedAt(t.vertex[k])), o(glm::dvec3(mesh.normals[t.vertex[k]]));
            corner[k] = V(glm::dvec3(m[0])) * p.x + V(glm::dvec3(m[1])) * p.y + V(glm::dvec3(m[2])) * p.z +
                        (V(glm::dvec3(m[3])) - V(in_.scene.camera->eye));
            normal[k] = unit(columns[0] * o.x + columns[1] * o.y + columns[2] * o.z);
            out_[n + "corner" + std::to_string(k)] = corner[k].list();
        }
        const V area = cross(corner[1] - corner[0], corner[2] - corner[0]);
        outward = unit(mirrored ? -area : area);
        met(n, s, meets(n, s, outward, corner[0]));
        // Shares of the corners: areas of the triangles that the point makes with two of them.
        const R whole = dot(area, area);
        R share[3];
        for (size_t k = 0; k < 3; ++k) share[k] = dot(area, cross(corner[(k + 1) % 3] - s.point, corner[(k + 2) % 3] - s.point)) / whole;
        out_[n + "shares"] = {share[0], share[1], share[2]};
        smooth = unit(normal[0] * share[0] + normal[1] * share[1] + normal[2] * share[2]);
    }
    void met(const std::string& n, State& s, const R& t) {
        out_[n + "t"] = {t};
        out_[n + "distance"] = {t * magnitude(s.vector)};
        s.point = s.start + s.vector * t;
        out_[n + "P"] = s.point.list();
        out_[n + "point"] = (s.point + V(in_.scene.camera->eye)).list();
    }

    // 16 and 18.2.3 to 18.4.3 at the hit. `geometric` faces the ray; `outward`: the normal that light sees, before it is turned.
    void shade(size_t number, State& s, const V& geometric, const V& outward) {
        const TracedRay& ray = in_.rays[number];
        const std::string n = prefixOf(number);
        const Material& m = materialOf(number);
        const V normal = ray.within ? -outward : outward;
        out_[n + "geometric"] = geometric.list();
        const RayShares shares = raySharesOf(m);
        out_[n + "local"] = {real(double(shares.local))};
        out_[n + "reflect"] = {real(double(shares.reflect))};
        out_[n + "transmit"] = {real(double(shares.transmit))};
        if (shares.local > 0) {
            Point<R> point;
            point.position = s.point;
            point.normal = normal;
            point.view = -unit(s.vector);
            std::vector<R> reaches;
            for (const float share : ray.lightReaches) reaches.push_back(real(double(share)));
            const V colour = illuminate(in_.scene, m, point, n, out_, reaches);
            out_[n + "own"] = (colour * (s.weight * real(double(shares.local)))).list();
        }
        if (!ray.children.mirror && !ray.children.pass && shares.reflect == 0 && shares.transmit == 0) return;
        sendOn(n, ray, s, m, bendOf(n, ray, s, geometric, normal));
    }

    // Normal of mirrored and refracted rays: that of the surface, or where the twin took another, the one of docs/illumination.md, Rays.
    V bendOf(const std::string& n, const TracedRay& ray, const State& s, const V& geometric, const V& normal) {
        V bend = normal;
        if (ray.bends != ray.normal) {
            bend = geometric;
            if (ray.bends != ray.geometric) {
                const V d = unit(s.vector), image = d + normal * (real(2) * atLeast0(-dot(d, normal)));
                bend = unit(unit(image + geometric * (leastSlope(d, geometric) - dot(image, geometric))) - d);
            }
        }
        out_[n + "B"] = bend.list();
        return bend;
    }
    static R leastSlope(const V& d, const V& geometric) {
        const R half = dot(d, geometric) / real(2);
        return lesserOf(-half, real(0x1p-10));  // d runs against the normal
    }
    static float lesserOf(float a, float b) { return std::min(a, b); }
    static Interval lesserOf(const Interval& a, const Interval& b) { return {std::min(a.low, b.low), std::min(a.high, b.high)}; }

    // R = N + T / (2 N.(-T)), and Trans = T / d - (cos2 - cos1 / d) N with d the ratio of the densities.
    void sendOn(const std::string& n, const TracedRay& ray, State& s, const Material& m, const V& bend) {
        const V d = unit(s.vector);
        const R cosine = -dot(s.taken, bend);
        out_[n + "cos_phi"] = {cosine};
        const V notes = bend + s.taken / (real(2) * cosine);
        out_[n + "R"] = notes.list();
        out_[n + "R_length"] = {magnitude(notes)};
        out_[n + "R_unit"] = unit(notes).list();
        s.mirrored = unit(notes);
        if (raySharesOf(m).transmit == 0) return;
        const R index = real(double(m.refractiveIndex)), density = ray.within ? real(1) / index : index;
        out_[n + "d"] = {density};
        const auto pass = [&](const V& t, const std::string& name) {
            const R first = -dot(t, bend), radicand = real(1) - (real(1) - first * first) / (density * density);
            const R second = rootOf(atLeast0(radicand));
            const V trans = t / density - bend * (second - first / density);
            out_[name + "radicand"] = {radicand};
            if (ray.children.passWeight == 0) return trans;
            out_[name + "cos_phi2"] = {second};
            out_[name + "Trans"] = trans.list();
            out_[name + "Trans_length"] = {magnitude(trans)};
            return trans;
        };
        pass(s.taken, n);
        Values<R> own;  // of the unit vector, which is what goes on
        std::swap(own, out_);
        V trans = pass(d, n);
        std::swap(own, out_);
        if (ray.slid) {
            const V geometric = listed(n + "geometric");
            trans = trans - geometric * (leastSlope(d, geometric) + dot(trans, geometric));
        }
        s.passed = unit(trans);
    }
    V listed(const std::string& name) const {
        const std::vector<R>& v = out_.at(name);
        return {v[0], v[1], v[2]};
    }

    // Spheres and planes before the ray from the eye, met or not.
    void lookAtShapes() {
        const State& s = states_[0];
        for (uint32_t i = 0; i < spheres() && i < kMostShapes; ++i) {
            const std::string n = "sphere" + std::to_string(i) + "_";
            const Quadratic q = quadratic(in_.scene.spheres[i], s);
            out_[n + "abc"] = {q.a, q.b, q.c};
            out_[n + "discriminant"] = {q.discriminant};
            out_[n + "met"] = {isPositive(q.discriminant)};
            if (boundOf(q.discriminant) == 0 ? valueOf(q.discriminant) < 0 : valueOf(q.discriminant) + boundOf(q.discriminant) < 0)
                continue;
            const R root = rootOf(atLeast0(q.discriminant)), twice = real(2) * q.a;
            out_[n + "roots"] = {(-q.b - root) / twice, (-q.b + root) / twice};
        }
        for (uint32_t i = 0; i < in_.scene.planes.size() && i < kMostShapes; ++i) {
            const std::string n = "plane" + std::to_string(i) + "_";
            const V normal(in_.scene.planes[i].normal);
            const R above = dot(normal, fromEye(in_.scene.planes[i].point) - s.start), slope = dot(normal, s.vector);
            out_[n + "numerator"] = {above};
            out_[n + "denominator"] = {slope};
            if (valueOf(slope) != 0) out_[n + "t"] = {above / slope};
        }
    }

    const RayTreeInput in_;
    Values<R> out_;
    std::vector<State> states_;
};

}  // namespace plumb::textbook
