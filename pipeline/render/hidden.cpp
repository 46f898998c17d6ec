// SPDX-License-Identifier: MIT
#include "pipeline/render/hidden.h"

#include "pipeline/scene/flattened.h"
#include "shaders/shared/fixed_point.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <utility>
#include <vector>

namespace plumb {

namespace {

using glm::dvec2;
using glm::dvec3;

// A vertex is off by less than a pixel (inGuard), and lines reach a pixel further.
constexpr double kMarginPixels = 4;
// Share of a depth that rounding of rows, quotients and depth planes stays below: 13 u and 5 u of a row, with a margin of 2^5.
constexpr double kMarginDepth = 0x1p-15;
// Faces of meshes with more are not tried as hiders: walls, floors and boxes have few.
constexpr size_t kMostFaces = 64;
constexpr size_t kMostHiders = 16;

struct Screen {
    double x = 0, y = 0, w = 0;
    double error = 0;  // twice what float32 may lose of w, or of x and y over the focal length: 5 u of a row's terms
};

class Eye {
public:
    Eye(const glm::dmat4& worldFromMesh, const Pinhole& view) : m_(worldFromMesh), v_(view) {}
    // x and y in samples times w.
    Screen clip(const dvec3& p) const {
        const dvec3 q = v_.viewOf(dvec3(m_ * glm::dvec4(p, 1)));
        const double terms = glm::length(dvec3(m_[3]) - v_.eye) + glm::length(glm::dmat3(m_) * p);
        return {q.x * v_.focal, q.y * v_.focal, q.z, 10 * 0x1p-24 * terms};
    }

private:
    const glm::dmat4& m_;
    const Pinhole& v_;
};

// Face that may hide something: a convex polygon on the screen, all of it drawn.
struct Hider {
    uint32_t object = 0;
    std::vector<dvec2> outline;  // in order
    double area = 0;             // twice
    double farthest = 0;         // depth w
};

double cross(const dvec2& a, const dvec2& b, const dvec2& c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

// Corners of a face in order: its triangles are a fan from the first one's first corner, or it is left aside.
std::vector<uint32_t> fanOf(const TriangleMesh& mesh, size_t first, size_t end) {
    std::vector<uint32_t> corners(mesh.triangles[first].vertex, mesh.triangles[first].vertex + 3);
    for (size_t t = first + 1; t < end; ++t) {
        const uint32_t* v = mesh.triangles[t].vertex;
        if (v[0] != corners.front() || v[1] != corners.back()) return {};
        corners.push_back(v[2]);
    }
    return corners;
}

// True when a point is projected, and neither cut nor moved by a pixel.
bool inGuard(const Screen& s, const Pinhole& view) {
    const double guard = gpu::kGuardPixels - 64;  // of the passes, less what rounding may do
    // A row's rounding brings nothing to the near plane, and moves nothing by a pixel.
    if (!(s.w - s.error > view.near * (1 + 1e-5)) || !(s.error * (view.focal + view.width + view.height) < s.w)) return false;
    return std::abs(s.x) < (view.width / 2 + guard) * s.w && std::abs(s.y) < (view.height / 2 + guard) * s.w;
}

// The outline runs one way round, without a corner that turns back.
bool isConvex(const std::vector<dvec2>& outline, double& area) {
    const size_t n = outline.size();
    area = 0;
    int turns = 0;
    for (size_t i = 0; i < n; ++i) {
        const double turn = cross(outline[i], outline[(i + 1) % n], outline[(i + 2) % n]);
        turns += turn > 0 ? 1 : -1;
        area += outline[i].x * outline[(i + 1) % n].y - outline[i].y * outline[(i + 1) % n].x;
    }
    return size_t(std::abs(turns)) == n && (turns > 0) == (area > 0);
}

void addHiders(const Scene& scene, uint32_t object, const Pinhole& view, std::vector<Hider>& hiders) {
    const TriangleMesh& mesh = scene.meshes[scene.objects[object].mesh];
    if (mesh.faceCentre.size() > kMostFaces || mesh.triangles.size() > 2 * kMostFaces) return;
    const glm::dmat4 toWorld = worldFromMesh(scene, scene.objects[object]);
    const Eye eye(toWorld, view);
    const bool turned = scene.leftHanded != mirrors(toWorld);
    for (size_t t = 0, end = 0; t < mesh.triangles.size(); t = end) {
        while (end < mesh.triangles.size() && mesh.triangles[end].face == mesh.triangles[t].face) ++end;
        Hider h;
        h.object = object;
        bool drawn = true;
        for (const uint32_t v : fanOf(mesh, t, end)) {
            const Screen s = eye.clip(dvec3(mesh.positions[v]));
            drawn &= inGuard(s, view);
            h.outline.emplace_back(s.x / s.w, s.y / s.w);
            h.farthest = std::max(h.farthest, s.w);
        }
        if (!drawn || h.outline.size() < 3 || !isConvex(h.outline, h.area)) continue;
        // Counter-clockwise from the front in a right-handed world is negative area here, y down.
        if (scene.cullBackFaces && (h.area > 0) != turned) continue;
        hiders.push_back(std::move(h));
    }
}

// True when all four corners lie within the outline, by the margin.
bool covers(const Hider& h, const dvec2& low, const dvec2& high) {
    const double side = h.area > 0 ? 1 : -1;
    for (size_t i = 0; i < h.outline.size(); ++i) {
        const dvec2 &a = h.outline[i], &b = h.outline[(i + 1) % h.outline.size()];
        const double margin = kMarginPixels * glm::length(b - a);
        for (const dvec2& corner : {low, dvec2(high.x, low.y), high, dvec2(low.x, high.y)})
            if (!(side * cross(a, b, corner) > margin)) return false;
    }
    return true;
}

}  // namespace

bool outsideView(const TriangleMesh& mesh, const glm::dmat4& worldFromMesh, const Pinhole& v) {
    int beyond[5] = {0, 0, 0, 0, 0};
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 corner(i & 1 ? mesh.boundsMax.x : mesh.boundsMin.x, i & 2 ? mesh.boundsMax.y : mesh.boundsMin.y,
                                i & 4 ? mesh.boundsMax.z : mesh.boundsMin.z);
        const glm::dvec3 p = glm::dvec3(worldFromMesh * glm::dvec4(corner, 1)) - v.eye;
        const double x = glm::dot(v.right, p) * v.focal, y = glm::dot(v.down, p) * v.focal, w = glm::dot(v.forward, p);
        const double halfX = v.width / 2 + 1, halfY = v.height / 2 + 1;
        beyond[0] += w < v.near * (1 - 1e-6);
        beyond[1] += x + halfX * w < -1e-5 * halfX * std::abs(w);
        beyond[2] += halfX * w - x < -1e-5 * halfX * std::abs(w);
        beyond[3] += y + halfY * w < -1e-5 * halfY * std::abs(w);
        beyond[4] += halfY * w - y < -1e-5 * halfY * std::abs(w);
    }
    return std::any_of(std::begin(beyond), std::end(beyond), [](int corners) { return corners == 8; });
}

ScreenBox screenBoxOf(const TriangleMesh& mesh, const glm::dmat4& worldFromMesh, const Pinhole& view) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const Eye eye(worldFromMesh, view);
    ScreenBox box{true, dvec2(kInfinity), dvec2(-kInfinity), kInfinity, 0};
    for (int i = 0; i < 8; ++i) {
        const dvec3 corner(i & 1 ? mesh.boundsMax.x : mesh.boundsMin.x, i & 2 ? mesh.boundsMax.y : mesh.boundsMin.y,
                           i & 4 ? mesh.boundsMax.z : mesh.boundsMin.z);
        const Screen s = eye.clip(corner);
        box.ahead &= inGuard(s, view);
        const dvec2 at(s.x / s.w, s.y / s.w);
        box.low = glm::min(box.low, at);
        box.high = glm::max(box.high, at);
        box.nearest = std::min(box.nearest, s.w);
        box.farthest = std::max(box.farthest, s.w);
    }
    return box;
}

std::vector<uint32_t> hidersOf(const Scene& scene, const Pinhole& view, const std::vector<bool>& outside) {
    std::vector<uint32_t> hiderOf(scene.objects.size(), kNone);
    if (scene.objects.size() < 2) return hiderOf;
    std::vector<Hider> hiders;
    for (uint32_t i = 0; i < scene.objects.size(); ++i)
        if (!outside[i]) addHiders(scene, i, view, hiders);
    std::sort(hiders.begin(), hiders.end(), [](const Hider& a, const Hider& b) { return std::abs(a.area) > std::abs(b.area); });
    hiders.resize(std::min(hiders.size(), kMostHiders));
    if (hiders.empty()) return hiderOf;
    for (uint32_t i = 0; i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        if (outside[i]) continue;
        const ScreenBox box = screenBoxOf(scene.meshes[object.mesh], worldFromMesh(scene, object), view);
        if (!box.ahead) continue;
        // What lies outside the picture is not seen either way.
        const dvec2 half(view.width / 2, view.height / 2), low = glm::max(box.low, -half), high = glm::min(box.high, half);
        for (const Hider& h : hiders)
            // A hider is not hidden itself: those are sorted by depth, and each lies strictly in front of what it hides.
            if (h.object != i && h.farthest < box.nearest * (1 - kMarginDepth) && covers(h, low, high)) {
                hiderOf[i] = h.object;
                break;
            }
    }
    return hiderOf;
}

}  // namespace plumb
