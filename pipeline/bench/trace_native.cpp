// SPDX-License-Identifier: MIT
#include "pipeline/bench/trace_peers.h"
#include "pipeline/passes/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

// Function clones for the machine at hand, where the compiler has them.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define PLUMB_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define PLUMB_CLONES
#endif

namespace plumb::peers {
namespace {

using glm::vec3;

constexpr float kOff = 1e-4f;  // a textbook's epsilon, in shares of the distance

struct Hit {
    float t;
    int object = -1;  // spheres, then planes
};

inline float sphere(const glm::vec4& s, const vec3& o, const vec3& d, float least) {
    const vec3 f = o - vec3(s);
    const float b = glm::dot(f, d), c = glm::dot(f, f) - s.w * s.w, square = b * b - c;
    if (square < 0) return -1;
    const float root = std::sqrt(square), near = -b - root;
    return near > least ? near : -b + root;
}

inline bool onBoard(const gpu::PlaneRecord& p, const vec3& at) {
    const float u = glm::dot(p.u, at) + p.u0, v = glm::dot(p.v, at) + p.v0;
    return u >= p.uMin && u <= p.uMax && v >= p.vMin && v <= p.vMax;
}

inline Hit nearest(const TraceScene& s, const vec3& o, const vec3& d, float least, float most) {
    Hit hit{most, -1};
    for (size_t i = 0; i < s.spheres.size(); ++i) {
        const float t = sphere(s.spheres[i], o, d, least);
        if (t > least && t < hit.t) hit = {t, int(i)};
    }
    for (size_t i = 0; i < s.planes.size(); ++i) {
        const gpu::PlaneRecord& p = s.planes[i];
        const float slope = glm::dot(p.normal, d);
        if (slope == 0) continue;
        const float t = (p.distance - glm::dot(p.normal, o)) / slope;
        if (t > least && t < hit.t && onBoard(p, o + t * d)) hit = {t, int(s.spheres.size() + i)};
    }
    return hit;
}

inline bool blocked(const TraceScene& s, const vec3& o, const vec3& d, float least, float most) {
    for (const glm::vec4& one : s.spheres) {
        const float t = sphere(one, o, d, least);
        if (t > least && t < most) return true;
    }
    for (const gpu::PlaneRecord& p : s.planes) {
        const float slope = glm::dot(p.normal, d);
        const float t = slope == 0 ? -1 : (p.distance - glm::dot(p.normal, o)) / slope;
        if (t > least && t < most && onBoard(p, o + t * d)) return true;
    }
    return false;
}

inline uint32_t other(const gpu::PlaneRecord& p, const vec3& at, uint32_t first) {
    if (p.square <= 0) return first;
    const float u = glm::dot(p.u, at) + p.u0, v = glm::dot(p.v, at) + p.v0;
    const int squares = int(std::floor(u / p.square)) + int(std::floor(v / p.square));
    return squares & 1 ? uint32_t(p.other) : first;
}

inline vec3 path(const gpu::TracePush& push, const TraceScene& s, vec3 o, vec3 d, bool& any) {
    vec3 colour(0);
    float weight = 1, least = 0;
    for (uint32_t depth = 0; depth < push.maxDepth; ++depth) {
        const Hit hit = nearest(s, o, d, least, 1e30f);
        if (hit.object < 0) return colour + weight * push.sky;
        if (depth == 0) any = true;
        const vec3 at = o + hit.t * d;
        vec3 n;
        uint32_t material = s.surfaces[size_t(hit.object)];
        if (size_t(hit.object) < s.spheres.size()) {
            n = (at - vec3(s.spheres[size_t(hit.object)])) / s.spheres[size_t(hit.object)].w;
        } else {
            const gpu::PlaneRecord& p = s.planes[size_t(hit.object) - s.spheres.size()];
            n = p.normal;
            material = other(p, at, material);
        }
        if (glm::dot(n, d) > 0) n = -n;
        const gpu::TraceMaterial& m = s.materials[material];
        least = kOff * (1 + hit.t);
        vec3 local = m.base;
        for (const gpu::LightRecord& light : s.lights) {
            vec3 l = light.position;
            float reach = 1e30f;
            if (light.kind != 0) {
                l -= at;
                reach = glm::length(l);
                l /= reach;
            }
            const float cosine = glm::dot(n, l);
            if (cosine <= 0 || blocked(s, at, l, least, reach)) continue;
            const float fade = light.attenuation == 0 ? 1.0f : 1.0f / std::pow(reach, light.attenuation);
            const vec3 r = 2 * cosine * n - l;
            const float highlight = std::max(0.0f, -glm::dot(r, d));
            local +=
                light.intensity * (m.diffuse * (cosine * fade) + m.specular * (highlight > 0 ? std::pow(highlight, m.shininess) : 0.0f));
        }
        colour += weight * m.local * local;
        weight *= m.reflect;
        if (weight <= push.minWeight || weight <= 0) return colour;
        o = at;
        d = d - 2 * glm::dot(n, d) * n;
    }
    return colour;
}

PLUMB_CLONES void rows(const gpu::TracePush& push, const TraceScene& scene, uint32_t begin, uint32_t end, uint32_t* rgba) {
    for (uint32_t y = begin; y < end; ++y)
        for (uint32_t x = 0; x < push.width; ++x) {
            const vec3 d = glm::normalize(push.rayOrigin + push.rayX * (float(x) + 0.5f) + push.rayY * (float(y) + 0.5f));
            bool any = false;
            const vec3 c = path(push, scene, vec3(0), d, any);
            uint32_t word = any ? 0xff000000u : 0;
            for (int k = 0; k < 3; ++k) word |= uint32_t(std::nearbyint(std::min(std::max(c[k], 0.0f), 1.0f) * 255)) << (8 * k);
            rgba[size_t(y) * push.width + x] = word;
        }
}

}  // namespace

void traceNative(const gpu::TracePush& push, const TraceScene& scene, uint32_t height, std::span<uint32_t> rgba, uint32_t threads) {
    parallelBands(height, 8, threads,
                  [&](uint64_t begin, uint64_t end) { rows(push, scene, uint32_t(begin), uint32_t(end), rgba.data()); });
}

}  // namespace plumb::peers
