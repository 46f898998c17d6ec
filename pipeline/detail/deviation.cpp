// SPDX-License-Identifier: MIT
#include "pipeline/detail/deviation.h"

#include "pipeline/passes/parallel.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <thread>
#include <utility>
#include <vector>

namespace plumb::detail {
namespace {

constexpr uint32_t kLeaf = 4;      // triangles of a leaf: more cost more tests, fewer more boxes
constexpr int kMostHalvings = 24;  // of a triangle: a piece is then 2^-12 of it, and the answer too close to call: false

// Square of the distance from a point to a box.
double toBox(const glm::dvec3& p, const glm::dvec3& low, const glm::dvec3& high) {
    const glm::dvec3 d = glm::max(glm::max(low - p, p - high), glm::dvec3(0));
    return glm::dot(d, d);
}

// Square of the distance from a point to a point of the triangle, the nearest up to rounding (Ericson, Real-Time Collision Detection, 5.1.5). It is
// computed from a point that the triangle has, so rounding of the choice never makes it too small.
double toTriangle(const glm::dvec3& p, const Corners& t) {
    const glm::dvec3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
    const auto at = [&](double v, double w) {
        v = std::clamp(v, 0.0, 1.0);
        w = std::clamp(w, 0.0, 1.0 - v);
        const glm::dvec3 d = ap - v * ab - w * ac;
        return glm::dot(d, d);
    };
    const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return at(0, 0);
    const glm::dvec3 bp = p - t[1];
    const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return at(1, 0);
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return at(d1 == d3 ? 0 : d1 / (d1 - d3), 0);
    const glm::dvec3 cp = p - t[2];
    const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return at(0, 1);
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return at(0, d2 == d6 ? 0 : d2 / (d2 - d6));
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        const double w = (d4 - d3) + (d5 - d6) == 0 ? 0 : (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return at(1 - w, w);
    }
    const double sum = va + vb + vc;
    return sum == 0 ? at(0, 0) : at(vb / sum, vc / sum);
}

}  // namespace

Surface::Surface(std::vector<Corners> triangles) : triangles_(std::move(triangles)) {
    double largest = 0;
    for (const Corners& t : triangles_)
        for (const glm::dvec3& p : t) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    // d of toTriangle(): its three coordinates come from differences of float32 (one rounding), two products and two sums of what is at most 2 or 4
    // times `largest`: below 32 u of it each. Halving a triangle adds one rounding a halving.
    slack_ = (64 + kMostHalvings) * 0x1p-53 * largest * std::sqrt(3.0);
    if (!triangles_.empty()) build(0, uint32_t(triangles_.size()));
}

void Surface::build(uint32_t first, uint32_t last) {
    const auto at = nodes_.size();
    nodes_.push_back({glm::dvec3(std::numeric_limits<double>::infinity()), glm::dvec3(-std::numeric_limits<double>::infinity())});
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    for (uint32_t i = first; i < last; ++i)
        for (const glm::dvec3& p : triangles_[i]) low = glm::min(low, p), high = glm::max(high, p);
    nodes_[at].low = low;
    nodes_[at].high = high;
    if (last - first <= kLeaf) {
        nodes_[at].first = first;
        nodes_[at].count = last - first;
        return;
    }
    const glm::dvec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const uint32_t middle = first + (last - first) / 2;
    std::nth_element(
        triangles_.begin() + first, triangles_.begin() + middle, triangles_.begin() + last,
        [axis](const Corners& a, const Corners& b) { return a[0][axis] + a[1][axis] + a[2][axis] < b[0][axis] + b[1][axis] + b[2][axis]; });
    build(first, middle);
    nodes_[at].right = uint32_t(nodes_.size());
    build(middle, last);
}

// One triangle of the surface is near enough to all corners, or several are to some, or a corner is near to none.
Surface::Answer Surface::ask(const Corners& t, double squared) const {
    bool near[3] = {false, false, false};
    uint32_t stack[64];
    size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const uint32_t at = stack[--depth];
        const Node& node = nodes_[at];
        bool any = false;
        for (const glm::dvec3& p : t) any |= toBox(p, node.low, node.high) <= squared;
        if (!any) continue;
        if (node.count == 0) {
            stack[depth++] = node.right;
            stack[depth++] = at + 1;
            continue;
        }
        for (uint32_t i = node.first; i < node.first + node.count; ++i) {
            bool all = true;
            for (size_t k = 0; k < 3; ++k) {
                const bool reaches = toTriangle(t[k], triangles_[i]) <= squared;
                near[k] |= reaches;
                all &= reaches;
            }
            if (all) return Answer::one;
        }
    }
    return near[0] && near[1] && near[2] ? Answer::several : Answer::none;
}

bool Surface::holds(const Corners& t, double distance) const {
    const double proved = distance - slack_;
    if (nodes_.empty() || !(proved > 0)) return false;
    const double squared = proved * proved * (1 - 0x1p-50);  // the square and its comparison round a few times
    std::vector<std::pair<Corners, int>> left = {{t, 0}};
    while (!left.empty()) {
        const auto [piece, halvings] = left.back();
        left.pop_back();
        const Answer answer = ask(piece, squared);
        if (answer == Answer::one) continue;
        if (answer == Answer::none || halvings == kMostHalvings) return false;
        size_t longest = 0;
        double length = -1;
        for (size_t k = 0; k < 3; ++k) {
            const glm::dvec3 edge = piece[(k + 1) % 3] - piece[k];
            if (const double l = glm::dot(edge, edge); l > length) length = l, longest = k;
        }
        const glm::dvec3 a = piece[longest], b = piece[(longest + 1) % 3], c = piece[(longest + 2) % 3], middle = (a + b) / 2.0;
        left.push_back({{a, middle, c}, halvings + 1});
        left.push_back({{middle, b, c}, halvings + 1});
    }
    return true;
}

bool within(const Surface& a, const Surface& b, double distance, uint32_t threads, const std::function<void()>& alive) {
    constexpr uint64_t kGrain = 256;  // triangles of a band: a band takes about a millisecond
    std::atomic<bool> holds{true};
    const std::thread::id caller = std::this_thread::get_id();
    const auto covers = [&](const Surface& from, const Surface& to) {
        const uint64_t bands = (from.triangles().size() + kGrain - 1) / kGrain;
        parallelBands(bands, 1, threadCount(threads), [&](uint64_t begin, uint64_t end) {
            for (uint64_t band = begin; band < end && holds; ++band) {
                if (std::this_thread::get_id() == caller) alive();
                const uint64_t last = std::min<uint64_t>(from.triangles().size(), (band + 1) * kGrain);
                for (uint64_t i = band * kGrain; i < last && holds; ++i)
                    if (!to.holds(from.triangles()[i], distance)) holds = false;
            }
        });
    };
    covers(b, a);  // the simplified surface has fewer triangles, and is asked first
    if (holds) covers(a, b);
    return holds;
}

}  // namespace plumb::detail
