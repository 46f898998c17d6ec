// SPDX-License-Identifier: MIT
// The twin: recursion, objects from the last to the first, the tree from its far child to its near one, shadow rays that gather their blockers
// before they multiply.
#include "host/error.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/passes/trace.h"

#include <algorithm>
#include <mutex>
#include <utility>

namespace plumb {

namespace {

struct TwinRay {
    glm::vec3 origin{0}, direction{0};
    float weight = 1;
    uint32_t from = gpu::kNoObject;
    bool inside = false;
    uint32_t depth = 1, kind = gpu::kCountPrimary, key = 0;
    uint32_t parent = gpu::kNoObject;  // in the list of rays that are kept
};

struct Nearest {
    float t = gpu::kFarthestHit;
    uint32_t object = gpu::kNoObject;
};

class Tracer {
public:
    // `kept`: the rays of a tree are added to it; null: none is kept.
    Tracer(const gpu::TracePush& push, const TraceScene& scene, const TraceChoices& choices, std::vector<TracedRay>* kept = nullptr)
        : push_(push), scene_(scene), choices_(choices), counters_(gpu::kCounters), kept_(kept) {}

    // The colour of the tree below `ray` is added to `colour`, each ray before its children; in whole levels it becomes `colour`.
    struct Seen {
        Nearest hit;
        glm::vec3 normal{0};
    };
    Seen follow(const TwinRay& ray, glm::vec3& colour) {
        ++counters_[(ray.depth - 1) * gpu::kCountKinds + ray.kind];
        Seen seen;
        seen.hit = nearest(ray);
        const auto number = kept_ ? uint32_t(kept_->size()) : gpu::kNoObject;
        if (kept_) keep(ray, seen.hit);
        if (seen.hit.object == gpu::kNoObject) {
            colour = choices_.cutLevels ? gpu::wholeLevels(push_.sky) : colour + push_.sky * ray.weight;
            if (kept_) kept_->back().sum = colour;
            return seen;
        }
        uint32_t material = 0;
        const gpu::SurfacePoint s = surface(seen.hit.object, ray, material);
        const bool within = gpu::dot3(ray.direction, s.normal) > 0.0f;
        const glm::vec3 geometric = within ? -s.normal : s.normal;
        const bool mesh = seen.hit.object >= firstTriangle();
        seen.normal = !mesh ? geometric : within ? -smooth_ : smooth_;
        const glm::vec3 bends = mesh ? gpu::normalForRays(ray.direction, geometric, seen.normal) : geometric;
        const glm::vec3 q = gpu::leaveSurface(s.point, geometric, s.error);
        const gpu::TraceMaterial& m = scene_.materials[material];
        glm::vec3 own(0);
        if (m.local > 0) {
            const glm::vec3 local = localColour(m, s, seen, ray, q, geometric, within);
            if (choices_.cutLevels)
                own = gpu::wholeLevels(local) * m.local;
            else
                colour = colour + local * (ray.weight * m.local);
        }
        gpu::Children next = gpu::childrenOf(ray.direction, bends, within, m.reflect, m.transmit, m.index, m.inverseIndex, ray.weight,
                                             ray.depth, push_.maxDepth, push_.minWeight);
        next.mirror = next.mirror && (choices_.mirrors || choices_.passes);
        next.pass = next.pass && choices_.passes;
        const glm::vec3 bent = next.passDirection;
        if (mesh) next.passDirection = gpu::onSideOf(next.passDirection, -geometric, gpu::leastSlope(ray.direction, geometric));
        if (kept_) {
            TracedRay& kept = (*kept_)[number];
            kept.material = material;
            kept.within = within;
            kept.point = s.point;
            kept.geometric = geometric;
            kept.normal = seen.normal;
            kept.bends = bends;
            kept.children = next;
            kept.slid = bent != next.passDirection;
            if (mesh) kept.shares = shares_;
            kept.sum = colour;
        }
        const uint32_t mirrorKey = gpu::keyOfChild(ray.key, gpu::kCountReflected), passKey = gpu::keyOfChild(ray.key, gpu::kCountRefracted);
        if (choices_.jitterMirror > 0)
            next.mirrorDirection = gpu::jittered(next.mirrorDirection, geometric, choices_.jitterMirror, mirrorKey);
        if (choices_.jitterPass > 0) next.passDirection = gpu::jittered(next.passDirection, geometric, choices_.jitterPass, passKey);
        glm::vec3 mirrored(0);
        if (next.mirror)
            follow({q, next.mirrorDirection, next.mirrorWeight, seen.hit.object, within, ray.depth + 1, gpu::kCountReflected, mirrorKey,
                    number},
                   choices_.cutLevels ? mirrored : colour);
        if (next.pass)
            follow({gpu::leaveSurface(s.point, -geometric, s.error), next.passDirection, next.passWeight, seen.hit.object, !within,
                    ray.depth + 1, gpu::kCountRefracted, passKey, number},
                   choices_.cutLevels ? mirrored : colour);
        if (choices_.cutLevels) colour = gpu::cutLevels(mirrored * m.reflect, own);
        return seen;
    }

    const std::vector<uint64_t>& counters() const { return counters_; }

private:
    void keep(const TwinRay& ray, const Nearest& hit) {
        TracedRay kept;
        kept.parent = ray.parent;
        kept.kind = ray.kind;
        kept.depth = ray.depth;
        kept.origin = ray.origin;
        kept.direction = ray.direction;
        kept.weight = ray.weight;
        kept.from = ray.from;
        kept.inside = ray.inside;
        kept.object = hit.object;
        kept.t = hit.object == gpu::kNoObject ? 0 : hit.t;
        kept_->push_back(std::move(kept));
    }
    gpu::SphereHit sphere(size_t i, const glm::vec3& o, const glm::vec3& d, uint32_t from, bool inside) const {
        const glm::vec4& s = scene_.spheres[i];
        return gpu::hitSphere(o, d, glm::vec3(s), s.w, scene_.powers[i], gpu::startOn(uint32_t(i), from, inside), scene_.far, scene_.close);
    }
    gpu::PlaneHit plane(size_t i, const glm::vec3& o, const glm::vec3& d, uint32_t from, bool inside) const {
        const gpu::PlaneRecord& p = scene_.planes[i];
        return gpu::hitPlane(o, d, glm::vec4(p.normal, p.distance), glm::vec4(p.u, p.u0), glm::vec4(p.v, p.v0),
                             glm::vec4(p.uMin, p.uMax, p.vMin, p.vMax), p.twoSided != 0.0f,
                             gpu::startOn(uint32_t(scene_.spheres.size() + i), from, inside));
    }
    uint32_t materialOfPlane(size_t i, const gpu::PlaneHit& hit) const {
        const gpu::PlaneRecord& p = scene_.planes[i];
        if (p.square > 0 && gpu::otherSquare(hit.u, hit.v, p.square, p.mirrored)) return uint32_t(p.other);
        return scene_.surfaces[scene_.spheres.size() + i];
    }

    uint32_t firstTriangle() const { return uint32_t(scene_.surfaces.size()); }
    gpu::TriangleHit triangle(uint32_t i, const gpu::RayFrame& frame, bool own) const {
        const glm::uvec4& t = scene_.triangles[2 * size_t(i)];
        return gpu::hitTriangle(frame, position(t.x), position(t.y), position(t.z), own);
    }
    glm::vec3 position(uint32_t corner) const { return glm::vec3(scene_.corners[2 * size_t(corner)]); }
    glm::vec3 normal(uint32_t corner) const { return glm::vec3(scene_.corners[2 * size_t(corner) + 1]); }
    static glm::vec3 floatsOf(const glm::uvec4& words) {
        return {gpu::realOf(int(words.x)), gpu::realOf(int(words.y)), gpu::realOf(int(words.z))};
    }

    // Calls visit(leaf, triangle) for each leaf below `node` that the ray may meet before `longest()`, the last first.
    template <class Longest, class Visit>
    void walk(uint32_t node, const gpu::RayFrame& frame, const Longest& longest, const Visit& visit) const {
        for (uint32_t child = gpu::kNodeChildren; child-- > 0;) {
            const size_t at = 2 * (size_t(node) * gpu::kNodeChildren + child);
            const glm::uvec4 &a = scene_.nodes[at], &b = scene_.nodes[at + 1];
            const glm::vec3 low = floatsOf(a), high = floatsOf(b);
            if (a.w == gpu::kNoChild) continue;
            if (!gpu::opens(gpu::entryOfBox(frame, low, high), gpu::exitOfBox(frame, low, high), longest())) continue;
            if (a.w & gpu::kLeaf)
                visit(a.w & ~gpu::kLeaf, scene_.leaves[3 * size_t(a.w & ~gpu::kLeaf)].w);
            else
                walk(a.w, frame, longest, visit);
        }
    }

    Nearest nearest(const TwinRay& ray) {
        Nearest best;
        if (!scene_.nodes.empty()) {
            const gpu::RayFrame frame = gpu::frameOfRay(ray.origin, ray.direction, scene_.reach);
            walk(
                0, frame, [&] { return best.t; },
                [&](uint32_t, uint32_t i) { take(best, triangle(i, frame, firstTriangle() + i == ray.from).t, firstTriangle() + i); });
        }
        for (size_t i = scene_.planes.size(); i-- > 0;) {
            const gpu::PlaneHit hit = plane(i, ray.origin, ray.direction, ray.from, ray.inside);
            counters_[gpu::kCountUndecided] += hit.undecided;
            take(best, hit.t, uint32_t(scene_.spheres.size() + i));
        }
        for (size_t i = scene_.spheres.size(); i-- > 0;)
            take(best, sphere(i, ray.origin, ray.direction, ray.from, ray.inside).t, uint32_t(i));
        return best;
    }
    static void take(Nearest& best, float t, uint32_t object) {
        if (gpu::isNearer(t, object, best.t, best.object)) best = {t, object};
    }

    gpu::SurfacePoint surface(uint32_t object, const TwinRay& ray, uint32_t& material) {
        if (object >= firstTriangle()) {
            const uint32_t i = object - firstTriangle();
            const glm::uvec4& t = scene_.triangles[2 * size_t(i)];
            const gpu::TriangleHit hit = triangle(i, gpu::frameOfRay(ray.origin, ray.direction, scene_.reach), false);
            shares_ = {hit.w0, hit.w1, hit.w2};
            smooth_ = gpu::unitLength((normal(t.x) * hit.w0 + normal(t.y) * hit.w1) + normal(t.z) * hit.w2);
            material = t.w;
            return gpu::pointOnTriangle(position(t.x), position(t.y), position(t.z), floatsOf(scene_.triangles[2 * size_t(i) + 1]), hit);
        }
        if (object < scene_.spheres.size()) {
            const glm::vec4& s = scene_.spheres[object];
            material = scene_.surfaces[object];
            const gpu::SphereHit hit = sphere(object, ray.origin, ray.direction, ray.from, ray.inside);
            if (scene_.close)
                return gpu::pointOnCloseSphere(ray.origin, ray.direction, hit.t, glm::vec3(s), s.w, scene_.powers[object], hit.offset);
            return gpu::pointOnSphere(glm::vec3(s), s.w, hit.offset);
        }
        const size_t i = object - scene_.spheres.size();
        const gpu::PlaneHit hit = plane(i, ray.origin, ray.direction, ray.from, ray.inside);
        material = materialOfPlane(i, hit);
        return gpu::pointOnPlane(scene_.planes[i].normal, hit.point);
    }

    // What a shadow ray lets through.
    float passed(const glm::vec3& q, const gpu::ShadowRay& shadowRay, uint32_t from, bool inside) const {
        std::vector<std::pair<uint32_t, float>> blockers;  // triangles by their leaf
        if (!scene_.nodes.empty()) {
            const gpu::RayFrame frame = gpu::frameOfRay(q, shadowRay.direction, scene_.reach);
            walk(
                0, frame, [&] { return shadowRay.reach; },
                [&](uint32_t leaf, uint32_t i) {
                    if (!gpu::blocks(triangle(i, frame, firstTriangle() + i == from).t, shadowRay.reach)) return;
                    const float slope = gpu::dot3(shadowRay.direction, floatsOf(scene_.triangles[2 * size_t(i) + 1]));
                    const float share = scene_.materials[scene_.triangles[2 * size_t(i)].w].transmit;
                    blockers.emplace_back(firstTriangle() + leaf, gpu::passesTriangle(share, slope));
                });
        }
        for (size_t i = scene_.planes.size(); i-- > 0;) {
            const gpu::PlaneHit hit = plane(i, q, shadowRay.direction, from, inside);
            if (gpu::blocks(hit.t, shadowRay.reach))
                blockers.emplace_back(uint32_t(scene_.spheres.size() + i), scene_.materials[materialOfPlane(i, hit)].transmit);
        }
        for (size_t i = scene_.spheres.size(); i-- > 0;)
            if (gpu::blocks(sphere(i, q, shadowRay.direction, from, inside).t, shadowRay.reach))
                blockers.emplace_back(uint32_t(i), scene_.materials[scene_.surfaces[i]].transmit);
        std::sort(blockers.begin(), blockers.end());
        float product = 1;
        for (const auto& [object, share] : blockers) product *= share;
        return product;
    }

    glm::vec3 localColour(const gpu::TraceMaterial& m, const gpu::SurfacePoint& s, const Seen& seen, const TwinRay& ray, const glm::vec3& q,
                          const glm::vec3& geometric, bool within) {
        const glm::vec3& n = seen.normal;
        const glm::vec3& d = ray.direction;
        gpu::Colour c{m.base.x, m.base.y, m.base.z};
        const gpu::Surface surface{n.x, n.y, n.z, -d.x, -d.y, -d.z, s.point.x, s.point.y, s.point.z};
        const gpu::Reflectance k{m.diffuse.x, m.diffuse.y, m.diffuse.z, m.specular.x, m.specular.y, m.specular.z, m.shininess, m.zeroPower};
        for (size_t i = 0; i < scene_.lights.size(); ++i) {
            const gpu::LightRecord& light = scene_.lights[i];
            const glm::vec4 position(light.position, light.kind);
            gpu::ShadowRay shadowRay = gpu::shadowRayTo(position, q);
            float share = 0;
            if (gpu::dot3(n, shadowRay.direction) > 0.0f && gpu::dot3(geometric, shadowRay.direction) > 0.0f) {
                if (choices_.shadows) ++counters_[(ray.depth - 1) * gpu::kCountKinds + gpu::kCountShadowRays];
                if (choices_.jitterShadow > 0)
                    shadowRay.direction = gpu::jittered(shadowRay.direction, geometric, choices_.jitterShadow,
                                                        gpu::keyOfChild(ray.key, gpu::kFirstShadowKey + uint32_t(i)));
                share = choices_.shadows ? passed(q, shadowRay, seen.hit.object, within) : 1.0f;
            }
            if (kept_) kept_->back().lightReaches.push_back(share);
            gpu::addLight(position, glm::vec4(light.intensity * share, light.attenuation), surface, k, choices_.parts, c);
        }
        return {c.r, c.g, c.b};
    }

    glm::vec3 smooth_{0};  // interpolated normal of the triangle that surface() saw last
    glm::vec3 shares_{0};  // and of its corners
    const gpu::TracePush& push_;
    const TraceScene& scene_;
    const TraceChoices& choices_;
    std::vector<uint64_t> counters_;
    std::vector<TracedRay>* const kept_;
};

// The ray from the eye through a sample of the grid.
TwinRay primaryRay(const gpu::TracePush& push, const TraceChoices& choices, uint32_t column, uint32_t row) {
    TwinRay ray;
    ray.key = gpu::keyOfSample(column, row, push.seed);
    ray.direction =
        gpu::primaryDirection(push.rayOrigin, push.rayX, push.rayY, gpu::columnOf(choices.sampling, column, choices.side, ray.key),
                              gpu::rowOf(choices.sampling, row, choices.side, ray.key));
    return ray;
}

}  // namespace

void traceCpu(const gpu::TracePush& push, const TraceScene& scene, const TraceChoices& choices, const TraceOutput& output,
              std::span<uint64_t> counters, uint32_t threads) {
    std::mutex adding;
    parallelBands(push.itemCount, 256, threads, [&](uint64_t begin, uint64_t end) {
        Tracer tracer(push, scene, choices);
        for (uint64_t item = begin; item < end; ++item) {
            const uint64_t at = push.firstItem + item;
            uint32_t column = uint32_t(at % push.width), row = uint32_t(at / push.width);
            if (!choices.pixels.empty()) {
                const uint32_t pixel = choices.pixels[column / choices.side];
                column = (pixel & 0xffffu) * choices.side + column % choices.side;
                row = (pixel >> 16) * choices.side + row;
            }
            glm::vec3 colour(0);
            const auto seen = tracer.follow(primaryRay(push, choices, column, row), colour);
            if (choices.cutLevels) colour = colour * gpu::kOneLevel;
            const bool hits = seen.hit.object != gpu::kNoObject;
            output.distance[item] = hits ? gpu::ubitsOf(seen.hit.t) : 0u;
            output.object[item] = seen.hit.object;
            for (int i = 0; i < 3; ++i) {
                output.linear[3 * item + size_t(i)] = colour[i];
                if (!output.normal.empty()) output.normal[3 * item + size_t(i)] = hits ? seen.normal[i] : 0.0f;
            }
        }
        const std::scoped_lock lock(adding);
        for (size_t i = 0; i < counters.size(); ++i) counters[i] += tracer.counters()[i];
    });
}

std::vector<TracedRay> traceTree(const gpu::TracePush& push, const TraceScene& scene, const TraceChoices& choices, uint32_t column,
                                 uint32_t row) {
    PLUMB_ASSERT(!choices.cutLevels);
    std::vector<TracedRay> tree;
    glm::vec3 colour(0);
    Tracer(push, scene, choices, &tree).follow(primaryRay(push, choices, column, row), colour);
    return tree;
}

}  // namespace plumb
