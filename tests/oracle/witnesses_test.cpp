// SPDX-License-Identifier: MIT
// The two witnesses of coverage against each other: the rational spans and lavapipe's fixed-function rasteriser. Neither knows the passes.
// Coordinates are multiples of 1/256 px on frames whose sides are powers of two, inside the guard band, so lavapipe gets them unrounded and
// every pixel must agree.
#include "tests/oracle/coverage_oracle.h"
#include "tests/oracle/fixed_function.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cstdint>

#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace plumb::oracle {
namespace {

FixedFunction& fixedFunction() {
    static FixedFunction witness;
    return witness;
}

// Exact in float32: x = X / (128 width) - 1 has at most 24 significant bits, and so have the steps of the viewport transform.
ClipPosition clipOf(const SubpixelPoint& p, int width, int height, float depth = 0.5f) {
    return {float(p.x) / (128.0f * float(width)) - 1.0f, float(p.y) / (128.0f * float(height)) - 1.0f, depth, 1.0f};
}

struct Drawing {
    std::vector<ClipPosition> vertices;
    std::vector<uint32_t> ids;
    void add(const SubpixelTriangle& t, int width, int height, uint32_t id, float depth = 0.5f) {
        for (const SubpixelPoint& p : t) vertices.push_back(clipOf(p, width, height, depth));
        ids.push_back(id);
    }
    DrawnFrame draw(int width, int height) const { return fixedFunction().draw(uint32_t(width), uint32_t(height), vertices, ids); }
};

std::vector<uint32_t> idsOf(const std::vector<SubpixelTriangle>& triangles, int width, int height) {
    std::vector<uint32_t> ids(size_t(width) * size_t(height), kNothingDrawn);
    for (size_t t = triangles.size(); t-- > 0;)  // equal depths: the earlier one stays
        for (const CoveredSpan& s : coveredSpans(triangles[t], width, height))
            for (int x = s.first; x < s.end; ++x) ids[size_t(s.row) * size_t(width) + size_t(x)] = uint32_t(t);
    return ids;
}

std::string textOf(const SubpixelTriangle& t) {
    std::string text;
    for (const SubpixelPoint& p : t) text += " (" + std::to_string(p.x) + ", " + std::to_string(p.y) + ")";
    return text;
}

// Draws the triangles over each other at one depth and compares every pixel.
uint64_t expectAgreement(const std::vector<SubpixelTriangle>& triangles, int width, int height) {
    Drawing drawing;
    for (size_t t = 0; t < triangles.size(); ++t) drawing.add(triangles[t], width, height, uint32_t(t));
    const DrawnFrame drawn = drawing.draw(width, height);
    const std::vector<uint32_t> want = idsOf(triangles, width, height);
    uint64_t covered = 0;
    for (size_t i = 0; i < want.size(); ++i) {
        covered += want[i] != kNothingDrawn;
        if (want[i] == drawn.ids[i]) continue;
        const uint32_t t = want[i] != kNothingDrawn ? want[i] : drawn.ids[i];
        ADD_FAILURE() << "pixel (" << i % size_t(width) << ", " << i / size_t(width) << "): spans say " << want[i] << ", lavapipe "
                      << drawn.ids[i] << "; triangle" << textOf(triangles[t]);
        break;
    }
    return covered;
}

SubpixelPoint randomPoint(std::mt19937& random, int64_t low, int64_t high) {
    std::uniform_int_distribution<int64_t> at(low, high);
    const int64_t x = at(random);
    return {x, at(random)};
}

TEST(Witnesses, AgreeOnRandomTrianglesOfEverySize) {
    constexpr int kSide = 64;
    std::mt19937 random(20260101);
    uint64_t covered = 0;
    for (const int64_t extent : {40, 300, 1000, 4000, 16000, 32000})
        for (int i = 0; i < 120; ++i) {
            std::vector<SubpixelTriangle> triangles;
            for (int t = 0; t < 6; ++t) {
                const SubpixelPoint centre = randomPoint(random, 0, kSide * 256);
                SubpixelTriangle triangle;
                for (SubpixelPoint& p : triangle) {
                    const SubpixelPoint d = randomPoint(random, -extent / 2, extent / 2);
                    // Within kGuard, with room to spare.
                    p = {std::clamp<int64_t>(centre.x + d.x, -kSide * 128, kSide * 384),
                         std::clamp<int64_t>(centre.y + d.y, -kSide * 128, kSide * 384)};
                }
                triangles.push_back(triangle);
            }
            covered += expectAgreement(triangles, kSide, kSide);
            if (HasFailure()) return;
        }
    EXPECT_GT(covered, 100000u);
}

// Corners on pixel centres, on pixel corners and half-way: every edge runs through sample points.
TEST(Witnesses, AgreeWhereEdgesRunThroughPixelCentres) {
    constexpr int kSide = 16;
    std::mt19937 random(7);
    uint64_t covered = 0;
    for (const int64_t lattice : {64, 128, 256})
        for (int i = 0; i < 1500; ++i) {
            SubpixelTriangle triangle;
            for (SubpixelPoint& p : triangle) {
                p = randomPoint(random, -2, kSide * 256 / lattice + 2);
                p = {p.x * lattice, p.y * lattice};
            }
            covered += expectAgreement({triangle}, kSide, kSide);
            if (HasFailure()) return;
        }
    EXPECT_GT(covered, 10000u);
}

TEST(Witnesses, AgreeOnNeedlesAndFlatTriangles) {
    constexpr int kSide = 256;
    std::mt19937 random(11);
    uint64_t covered = 0;
    for (int i = 0; i < 400; ++i) {
        const SubpixelPoint a = randomPoint(random, -kSide * 128, kSide * 384), b = randomPoint(random, -kSide * 128, kSide * 384);
        const int64_t thickness = i % 2 ? 2 : 60;
        const SubpixelPoint d = randomPoint(random, -thickness, thickness);
        covered += expectAgreement({{a, b, {b.x + d.x, b.y + d.y}},
                                    {a, b, {std::midpoint(a.x, b.x) + d.x, std::midpoint(a.y, b.y) + d.y}},
                                    {a, {b.x, a.y}, {b.x, a.y + d.y}},
                                    {a, {a.x, b.y}, {a.x + d.x, b.y}}},
                                   kSide, kSide);
        if (HasFailure()) return;
    }
    EXPECT_GT(covered, 1000u);
}

// A fan around a hub: each sample inside belongs to one triangle, also when the hub and the spokes lie on pixel centres.
TEST(Witnesses, LeaveNoCrackAndNoOverlapInAFan) {
    constexpr int kSide = 32;
    std::mt19937 random(3);
    for (const int64_t hubOffset : {128, 0, 77}) {
        const SubpixelPoint hub{16 * 256 + hubOffset, 16 * 256 + hubOffset};
        std::vector<SubpixelPoint> rim;
        for (int64_t i = 0; i < 24; ++i) rim.push_back({hub.x - 3072 + i * 256, hub.y - 3072});
        for (int64_t i = 0; i < 24; ++i) rim.push_back({hub.x + 3072, hub.y - 3072 + i * 256});
        for (int64_t i = 0; i < 24; ++i) rim.push_back({hub.x + 3072 - i * 256, hub.y + 3072});
        for (int64_t i = 0; i < 24; ++i) rim.push_back({hub.x - 3072, hub.y + 3072 - i * 256});
        std::vector<SubpixelTriangle> fan;
        for (size_t i = 0; i < rim.size(); ++i) fan.push_back({hub, rim[i], rim[(i + 1) % rim.size()]});
        std::vector<int> owners(kSide * kSide, 0);
        for (const SubpixelTriangle& t : fan)
            for (const CoveredSpan& s : coveredSpans(t, kSide, kSide))
                for (int x = s.first; x < s.end; ++x) ++owners[size_t(s.row) * kSide + size_t(x)];
        EXPECT_EQ(std::accumulate(owners.begin(), owners.end(), 0), 24 * 24);
        EXPECT_EQ(*std::max_element(owners.begin(), owners.end()), 1);
        expectAgreement(fan, kSide, kSide);
    }
}

TEST(Witnesses, WindingDoesNotMatter) {
    std::mt19937 random(5);
    for (int i = 0; i < 300; ++i) {
        const SubpixelPoint a = randomPoint(random, 0, 4096), b = randomPoint(random, 0, 4096), c = randomPoint(random, 0, 4096);
        const std::vector<CoveredSpan> want = coveredSpans({a, b, c}, 16, 16);
        for (const SubpixelTriangle& t : {SubpixelTriangle{a, c, b}, {b, a, c}, {b, c, a}, {c, a, b}, {c, b, a}})
            EXPECT_EQ(coveredSpans(t, 16, 16), want) << textOf(t);
        expectAgreement({{a, c, b}}, 16, 16);
    }
}

TEST(Witnesses, KeepTheNearestAndTheEarlierOfEqualDepths) {
    const SubpixelTriangle whole{{{-2048, -2048}, {6144, -2048}, {-2048, 6144}}};
    Drawing drawing;
    drawing.add(whole, 16, 16, 5, 0.25f);
    drawing.add(whole, 16, 16, 6, 0.75f);
    drawing.add(whole, 16, 16, 7, 0.75f);
    drawing.add(whole, 16, 16, 8, 0.5f);
    const DrawnFrame frame = drawing.draw(16, 16);
    EXPECT_EQ(frame.ids[0], 6u);
    EXPECT_EQ(frame.depth[0], 0.75f);
    EXPECT_EQ(frame.ids[15 * 16 + 15], kNothingDrawn);
    EXPECT_EQ(frame.depth[15 * 16 + 15], 0.0f);
}

// The comparison can go red: a corner moved by 1/256 px on the lattice of pixel centres is seen.
TEST(Witnesses, NoticeACornerMovedByOneSubpixel) {
    const SubpixelTriangle right{{{128, 128}, {128 + 2560, 128}, {128, 128 + 2560}}};
    SubpixelTriangle moved = right;
    moved[0].x += 1;
    moved[2].x += 1;
    Drawing drawing;
    drawing.add(right, 16, 16, 0);
    EXPECT_EQ(drawing.draw(16, 16).ids, idsOf({right}, 16, 16));
    EXPECT_NE(drawing.draw(16, 16).ids, idsOf({moved}, 16, 16));
}

TEST(Witnesses, MeasureTheDistanceToTheBoundaryExactly) {
    const SubpixelTriangle t{{{128, 129}, {2688, 129}, {128, 2689}}};
    EXPECT_TRUE(isNearBoundary(t, 5, 0));    // 1/256 px above the top edge
    EXPECT_TRUE(isNearBoundary(t, 0, 5));    // on the left edge
    EXPECT_FALSE(isNearBoundary(t, 1, 1));   // inside
    EXPECT_TRUE(isNearBoundary(t, 0, 0));    // near a corner
    EXPECT_FALSE(isNearBoundary(t, 12, 0));  // on the line of the top edge, beyond its end
    EXPECT_TRUE(isNearBoundary(t, 1, 1, 255));
}

}  // namespace
}  // namespace plumb::oracle
