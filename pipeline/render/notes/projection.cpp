// SPDX-License-Identifier: MIT
#include "pipeline/render/notes/projection.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <utility>
#include <vector>

namespace plumb {

namespace {

using glm::dvec3;

// A corner on the screen before it is rounded.
struct Projected {
    double x, y, z;
    dvec3 attributes;
};
// Sutherland and Hodgman on the screen, where Z and the attributes are linear: +-x or +-y at most the farthest pixel.
std::vector<Projected> withinReach(std::vector<Projected> polygon) {
    constexpr double kReach = gpu::kScanFarthestPixel;
    for (const auto& [axis, sign] : {std::pair(&Projected::x, 1.0), {&Projected::x, -1.0}, {&Projected::y, 1.0}, {&Projected::y, -1.0}}) {
        std::vector<Projected> kept;
        for (size_t i = 0; i < polygon.size(); ++i) {
            const Projected &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
            const bool aIsIn = sign * a.*axis <= kReach, bIsIn = sign * b.*axis <= kReach;
            if (aIsIn) kept.push_back(a);
            if (aIsIn == bIsIn) continue;
            const Projected &in = aIsIn ? a : b, &out = aIsIn ? b : a;
            const double t = (sign * kReach - in.*axis) / (out.*axis - in.*axis);
            Projected cut{in.x + (out.x - in.x) * t, in.y + (out.y - in.y) * t, in.z + (out.z - in.z) * t,
                          in.attributes + (out.attributes - in.attributes) * t};
            cut.*axis = sign * kReach;
            kept.push_back(cut);
        }
        polygon = std::move(kept);
    }
    return polygon;
}

}  // namespace

bool isConvex(std::span<const gpu::ScanCorner> polygon) {
    const size_t n = polygon.size();
    int turn = 0, changes = 0, direction = 0;
    for (size_t i = 0; i < n; ++i) {
        const gpu::ScanCorner &a = polygon[i], &b = polygon[(i + 1) % n], &c = polygon[(i + 2) % n];
        const int64_t cross = int64_t(b.x - a.x) * (c.y - b.y) - int64_t(b.y - a.y) * (c.x - b.x);
        const int sign = cross > 0 ? 1 : cross < 0 ? -1 : 0;
        if (sign != 0 && turn != 0 && sign != turn) return false;
        if (sign != 0) turn = sign;
    }
    for (size_t i = 0; i < 2 * n; ++i) {  // twice around, so that the first direction is known on the second
        const int rise = polygon[(i + 1) % n].y - polygon[i % n].y;
        const int now = rise > 0 ? 1 : rise < 0 ? -1 : 0;
        if (now == 0) continue;
        if (i >= n && now != direction) ++changes;
        direction = now;
    }
    return changes <= 2;
}

NotesProjection::NotesProjection(const Pinhole& view, double distance)
    : view_(view), distance_(distance), near_(double(float(view.near))), zUnit_(std::exp2(-std::ilogb(distance))) {}

glm::dvec3 NotesProjection::rayOf(size_t sample) const {
    const size_t width = size_t(view_.width), column = sample % width, row = sample / width;
    return view_.rayThrough(double(column) - view_.width / 2, double(row) - view_.height / 2);
}

// Sutherland and Hodgman at the near plane, always from the inside corner, so that neighbours meet in the same point.
std::vector<NotesCorner> NotesProjection::inFront(const std::vector<NotesCorner>& polygon) const {
    std::vector<NotesCorner> kept;
    for (size_t i = 0; i < polygon.size(); ++i) {
        const NotesCorner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        if (a.view.z >= near_) kept.push_back(a);
        if ((a.view.z >= near_) == (b.view.z >= near_)) continue;
        const NotesCorner &in = a.view.z >= near_ ? a : b, &out = a.view.z >= near_ ? b : a;
        const double t = (in.view.z - near_) / (in.view.z - out.view.z);
        NotesCorner cut{in.view + (out.view - in.view) * t,
                        glm::vec3(dvec3(in.attributes) + (dvec3(out.attributes) - dvec3(in.attributes)) * t)};
        cut.view.z = near_;
        kept.push_back(cut);
    }
    return kept;
}

std::vector<gpu::ScanCorner> NotesProjection::display(const std::vector<NotesCorner>& polygon) const {
    constexpr double kBeyond = 0x1p200;   // differences and products of two stay finite
    constexpr double kNearest = 0x1p100;  // Zps grows beyond every bound toward the viewer; steps and products of it stay finite
    std::vector<Projected> projected;
    for (const NotesCorner& c : inFront(polygon)) {
        const double x = view_.width / 2 + view_.focal * c.view.x / c.view.z, y = view_.height / 2 + view_.focal * c.view.y / c.view.z;
        projected.push_back({std::clamp(x, -kBeyond, kBeyond), std::clamp(y, -kBeyond, kBeyond), zpsOf(c.view.z), dvec3(c.attributes)});
    }
    std::vector<gpu::ScanCorner> corners;
    for (const Projected& c : withinReach(std::move(projected)))
        corners.push_back(
            {int(std::nearbyint(c.x)), int(std::nearbyint(c.y)), float(std::max(c.z * zUnit_, -kNearest)), glm::vec3(c.attributes)});
    return corners;
}

}  // namespace plumb
