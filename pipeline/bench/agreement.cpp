// SPDX-License-Identifier: MIT
// Agreement of two pictures. Edges are projected in binary64 from the unrounded object space, so that neither side's own rounding is the
// judge.
#include "pipeline/bench/agreement.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

namespace plumb {
namespace {

struct Pixel {
    glm::dvec2 centre;
    double nearest = std::numeric_limits<double>::infinity();  // distance of the nearest edge, pixels
};

double distanceToSegment(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b) {
    const glm::dvec2 along = b - a;
    const double length = glm::dot(along, along);
    const double t = length > 0 ? std::clamp(glm::dot(p - a, along) / length, 0.0, 1.0) : 0.0;
    return glm::length(p - (a + t * along));
}

// Polygon of the corners (x, y in pixels times w, w), cut at the near plane, as pixels of the frame.
void project(const glm::dvec3 (&corners)[3], const gpu::Viewport& v, std::vector<glm::dvec2>& polygon) {
    polygon.clear();
    const auto put = [&](const glm::dvec3& c) { polygon.emplace_back(c.x / c.z + double(v.centreX), c.y / c.z + double(v.centreY)); };
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 &a = corners[i], &b = corners[(i + 1) % 3];
        const double da = a.z - double(v.near), db = b.z - double(v.near);
        if (da >= 0) put(a);
        if ((da < 0) != (db < 0)) put(a + (b - a) * (da / (da - db)));
    }
}

void findNearestEdges(const DrawList& list, std::vector<Pixel>& pixels) {
    const auto times = [](const glm::vec4& row, const glm::vec4& p) {
        return double(row.x) * double(p.x) + double(row.y) * double(p.y) + double(row.z) * double(p.z) + double(row.w);
    };
    std::vector<glm::dvec2> polygon;
    for (const DrawList::Range& range : list.ranges) {
        const gpu::ObjectRecord& o = list.objects[range.record];
        for (uint32_t t = range.firstTriangle; t < range.firstTriangle + range.triangleCount; ++t) {
            glm::dvec3 corners[3];
            for (int i = 0; i < 3; ++i) {
                const glm::vec4& p = list.positions[list.triangles[t][i]];
                corners[i] = {times(o.rowX, p), times(o.rowY, p), times(o.rowW, p)};
            }
            project(corners, list.viewport, polygon);
            if (polygon.empty()) continue;
            glm::dvec2 low = polygon[0], high = polygon[0];
            for (const glm::dvec2& p : polygon) low = glm::min(low, p), high = glm::max(high, p);
            for (Pixel& pixel : pixels) {
                const glm::dvec2& c = pixel.centre;
                if (c.x < low.x - 1 || c.x > high.x + 1 || c.y < low.y - 1 || c.y > high.y + 1) continue;
                for (size_t i = 0; i < polygon.size(); ++i)
                    pixel.nearest = std::min(pixel.nearest, distanceToSegment(c, polygon[i], polygon[(i + 1) % polygon.size()]));
            }
        }
    }
}

}  // namespace

Agreement agreementOf(const DrawList& list, uint32_t width, uint32_t height, std::span<const uint32_t> passes, uint32_t pitch,
                      std::span<const uint32_t> baseline) {
    // Most differing pixels. With more than a few rows the pictures show different things, and the search for edges would take very long.
    constexpr uint64_t kMostPixels = 4096;
    Agreement a;
    a.pixels = uint64_t(width) * height;
    std::vector<Pixel> different;
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const uint32_t ours = passes[size_t(y) * pitch + x], theirs = baseline[size_t(y) * width + x];
            const bool drawn = ours >> 24 != 0, also = theirs >> 24 != 0;
            a.covered += drawn;
            if (drawn != also) {
                ++a.coverageDiffers;
                if (different.size() < kMostPixels) different.push_back({{x + 0.5, y + 0.5}});
                continue;
            }
            if (!drawn) continue;
            int most = 0;
            for (int shift = 0; shift < 24; shift += 8)
                most = std::max(most, std::abs(int(ours >> shift & 0xffu) - int(theirs >> shift & 0xffu)));
            a.colourMost = std::max(a.colourMost, most);
            a.colourOver4 += most > 4;
        }
    if (a.coverageDiffers <= kMostPixels) findNearestEdges(list, different);
    const Pixel* worst = nullptr;
    for (const Pixel& p : different) {
        a.unexplained += !(p.nearest <= kSnapPixels);
        if (!worst || !(p.nearest <= worst->nearest)) worst = &p;
    }
    if (worst) a.furthestPixels = worst->nearest;
    if (a.coverageDiffers > kMostPixels)
        a.failure = fmt::format("{} pixels are drawn by one side only", a.coverageDiffers);
    else if (a.unexplained != 0)
        a.failure = fmt::format("pixel ({}, {}) is drawn by one side only, {} pixels from the nearest edge ({} allowed); {} such pixels",
                                worst->centre.x - 0.5, worst->centre.y - 0.5, worst->nearest, kSnapPixels, a.unexplained);
    else if (a.covered == 0)
        a.failure = "both pictures are empty";
    else if (!(double(a.colourOver4) <= kColourShare * double(a.covered)))
        a.failure = fmt::format("{} of {} covered pixels differ by more than 4 levels", a.colourOver4, a.covered);
    return a;
}

}  // namespace plumb
