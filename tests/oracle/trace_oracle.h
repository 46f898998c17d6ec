// SPDX-License-Identifier: MIT
// A ray tracer by the textbook, in binary64 with the quadratics in long double: recursion, a constant epsilon that is far above its own
// rounding and far below everything in the scenes it is asked for. It shares nothing with the passes.
#pragma once

#include "pipeline/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb::test {

struct OracleSeen {
    glm::dvec3 colour{0};
    uint64_t path = 1469598103934665603ull;  // hash of every decision on the way: objects, sides, squares, shadow rays
    int object = -1;                         // of the primary ray
    double distance = 0;
    uint64_t rays = 0, shadowRays = 0;
};

class TraceOracle {
public:
    TraceOracle(const Scene& scene, const glm::dvec3& sky, uint32_t maxDepth) : scene_(scene), sky_(sky), maxDepth_(maxDepth) {}

    OracleSeen look(const glm::dvec3& o, const glm::dvec3& d) const {
        OracleSeen seen;
        follow(o, glm::normalize(d), 1, 1, seen);
        return seen;
    }

private:
    static constexpr double kEpsilon = 1e-10;
    struct Hit {
        double t = 1e18;
        int object = -1;
        glm::dvec3 normal{0};
        uint32_t material = 0;
        bool other = false;
    };

    Hit nearest(const glm::dvec3& o, const glm::dvec3& d, double longest, const auto& visit) const {
        Hit best;
        best.t = longest;
        const auto offer = [&](const Hit& h) {
            visit(h);
            if (h.t < best.t) best = h;
        };
        for (size_t i = 0; i < scene_.spheres.size(); ++i) {
            const SphereShape& s = scene_.spheres[i];
            long double a = 0, b = 0, c = -static_cast<long double>(s.radius) * s.radius;
            for (int k = 0; k < 3; ++k) {
                const long double f = static_cast<long double>(o[k]) - s.centre[k];
                a += static_cast<long double>(d[k]) * d[k];
                b += f * d[k];
                c += f * f;
            }
            const long double discriminant = b * b - a * c;
            if (discriminant < 0) continue;
            const long double root = std::sqrt(discriminant);
            double t = double((-b - root) / a);
            if (t <= kEpsilon) t = double((-b + root) / a);
            if (t > kEpsilon && t < longest) offer({t, int(i), (o + t * d - s.centre) / s.radius, s.material, false});
        }
        for (size_t i = 0; i < scene_.planes.size(); ++i) {
            const PlaneShape& p = scene_.planes[i];
            const double slope = glm::dot(p.normal, d);
            if (slope == 0 || (!p.twoSided && slope > 0)) continue;
            const double t = glm::dot(p.normal, p.point - o) / slope;
            if (!(t > kEpsilon && t < longest)) continue;
            const double u = glm::dot(o + t * d - p.point, p.u), v = glm::dot(o + t * d - p.point, p.v);
            if (u < p.uMin || u > p.uMax || v < p.vMin || v > p.vMax) continue;
            bool other = false;
            if (p.square > 0) {
                // The notes' rule as they write it: |X| mod 2s > s flips.
                other = u < 0;
                if (std::fmod(std::abs(u), 2 * p.square) > p.square) other = !other;
                if (std::fmod(std::abs(v), 2 * p.square) > p.square) other = !other;
                if (v < 0 && !p.mirrored) other = !other;
            }
            offer({t, int(scene_.spheres.size() + i), p.normal, other ? p.otherMaterial : p.material, other});
        }
        return best;
    }

    static void note(OracleSeen& seen, uint64_t what) { seen.path = (seen.path ^ what) * 1099511628211ull; }

    void follow(const glm::dvec3& o, const glm::dvec3& d, double weight, uint32_t depth, OracleSeen& seen) const {
        ++seen.rays;
        const Hit hit = nearest(o, d, 1e18, [](const Hit&) {});
        if (depth == 1) seen.object = hit.object, seen.distance = hit.t;
        note(seen, uint64_t(hit.object + 2) * 4 + hit.other);
        if (hit.object < 0) {
            seen.colour += weight * sky_;
            return;
        }
        const Material& m = scene_.materials[hit.material];
        const glm::dvec3 p = o + hit.t * d;
        const bool inside = glm::dot(hit.normal, d) > 0;
        const glm::dvec3 n = inside ? -hit.normal : hit.normal;
        note(seen, inside);
        if (m.local > 0) {
            glm::dvec3 local = glm::dvec3(m.ambient) * glm::dvec3(scene_.ambient) + glm::dvec3(m.emission);
            for (const Light& light : scene_.lights) {
                const glm::dvec3 toward = light.directional ? light.direction : light.position - p;
                const glm::dvec3 l = glm::normalize(toward);
                const double nl = glm::dot(n, l);
                note(seen, nl > 0);
                if (nl <= 0) continue;
                ++seen.shadowRays;
                double passed = 1;
                if (scene_.shadows)
                    nearest(p, l, light.directional ? 1e18 : glm::length(toward), [&](const Hit& h) {
                        passed *= double(scene_.materials[h.material].transmit);
                        note(seen, uint64_t(h.object) * 2 + h.other);
                    });
                const double rv = std::max(0.0, glm::dot(2 * nl * n - l, -d));
                const double specular = m.shininess == 0 ? 1.0 : std::pow(rv, double(m.shininess));
                local += passed * glm::dvec3(light.intensity) * (glm::dvec3(m.diffuse) * nl + glm::dvec3(m.specular) * specular);
            }
            seen.colour += weight * double(m.local) * local;
        }
        if (depth == maxDepth_) return;
        const double cosine = -glm::dot(d, n), ratio = inside ? double(m.refractiveIndex) : 1 / double(m.refractiveIndex);
        const double square = 1 - ratio * ratio * (1 - cosine * cosine);
        const bool total = square <= 0;
        note(seen, m.transmit > 0 && total);
        const double mirror = double(m.reflect) + (total ? double(m.transmit) : 0);
        if (mirror > 0) follow(p, glm::normalize(d + 2 * cosine * n), weight * mirror, depth + 1, seen);
        if (m.transmit > 0 && !total)
            follow(p, glm::normalize(ratio * d + (ratio * cosine - std::sqrt(square)) * n), weight * double(m.transmit), depth + 1, seen);
    }

    const Scene& scene_;
    glm::dvec3 sky_;
    uint32_t maxDepth_;
};

}  // namespace plumb::test
