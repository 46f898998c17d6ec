// SPDX-License-Identifier: MIT
#include "pipeline/passes/scanline.h"

#include "tests/twin/scanline_support.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <vector>

namespace plumb::test {
namespace {

class ScanlineTwin : public DeviceTest {};

// Corners on an ellipse, rounded: convex, apart from what rounding makes collinear; in either sense.
std::vector<gpu::ScanCorner> polygonAround(Random& r, double x, double y, double reach, uint32_t corners) {
    std::vector<gpu::ScanCorner> polygon;
    const double phase = r(0, 6), flat = r(0.2, 1), sense = r.below(2) == 0 ? 1 : -1;
    for (uint32_t i = 0; i < corners; ++i) {
        const double angle = phase + sense * 2 * std::numbers::pi * i / corners;
        polygon.push_back({std::nearbyint(float(x + reach * std::cos(angle))),
                           std::nearbyint(float(y + reach * flat * std::sin(angle))),
                           float(r(-50, 500)),
                           {float(r(-1, 1)), float(r(0, 1)), float(r(0, 2))}});
    }
    return polygon;
}

ScanList listOf(int width, int height, uint32_t count, double reach, uint32_t seed, bool zBuffer = true) {
    Random r(seed);
    ScanList list;
    list.zBuffer = zBuffer;
    list.width = width;
    list.height = height;
    const auto add = [&](const std::vector<gpu::ScanCorner>& polygon) { list.add(polygon); };
    const float w = float(width), h = float(height);
    // Exactly one pixel, one row (no table: not painted), one column, the frame itself, beyond each side, equal Z twice.
    add({{3, 3, 1, {1, 2, 3}}, {3, 3, 1, {1, 2, 3}}, {3, 3, 1, {1, 2, 3}}});
    add({{0, 2, 1, {}}, {5, 2, 1, {}}, {2, 2, 1, {}}});
    add({{1, 0, 7, {0.5f, 0, 0}}, {1, 6, 9, {0, 1, 0}}, {1, 3, 8, {0, 0, 1}}});
    add({{0, 0, 400, {1, 0, 0}},
         {w - 1, 0, 400, {0, 1, 0}},
         {w - 1, h - 1, 400, {0, 0, 1}},
         {0, h - 1, 400, {1, 1, 1}}});
    add({{0, 0, 400, {9, 9, 9}}, {w, 0, 400, {9, 9, 9}}, {w, h, 400, {9, 9, 9}}, {0, h, 400, {9, 9, 9}}});
    add({{-20, -20, 399, {2, 0, 0}}, {5, -3, 399, {}}, {-4, 9, 399, {}}});
    add({{w + 20, 1, 399, {3, 0, 0}}, {w - 3, 4, 399, {}}, {w + 9, h + 7, 399, {}}});
    // The triangle of section 13.1, whose edge is switched in the middle.
    add({{10, 20, 100, {1, 0, 0}}, {30, 0, 200, {0, 1, 0}}, {30, 30, 300, {0, 0, 1}}});
    for (uint32_t i = 0; i < count; ++i)
        add(polygonAround(r, r(-0.2, 1.2) * width, r(-0.2, 1.2) * height, r(0.5, reach), 3 + r.below(6)));
    return list;
}

void expectSameCanvas(const ScanList& list) {
    const ScanCanvas canvas = sameOnBothSides(list, nullptr);
    EXPECT_LT(size_t(std::count(canvas.owner.begin(), canvas.owner.end(), gpu::kNoPolygon)), canvas.owner.size())
        << "nothing is painted";
}

TEST_F(ScanlineTwin, LeavesTheSameBytes) {
    expectSameCanvas(listOf(131, 67, 60, 40, 3));
    expectSameCanvas(listOf(64, 64, 200, 12, 5));
    expectSameCanvas(listOf(35, 129, 40, 90, 7));
    expectSameCanvas(listOf(1, 1, 40, 9, 11));
    expectSameCanvas(listOf(67, 45, 60, 20, 17, false));
}

TEST_F(ScanlineTwin, ManyWidePolygonsTakeSeveralDispatches) {
    const ScanList list = listOf(3001, 9, 90, 1400, 13);
    uint32_t slices = 0;
    for (uint32_t first = 0; first < list.polygons.size(); ++slices) first = scanSliceEnd(list, first);
    EXPECT_GT(slices, 1u);
    expectSameCanvas(list);
}

TEST_F(ScanlineTwin, AnEmptyListLeavesAnEmptyCanvas) {
    ScanList list;
    list.width = 5;
    list.height = 3;
    Recorder recorder(device());
    const ScanCanvas got = scanlineGpu(device(), recorder, list, exactForms(device())[0], kWatchdogMs, nullptr);
    EXPECT_EQ(got.owner, std::vector<uint32_t>(15, gpu::kNoPolygon));
    EXPECT_EQ(got.z, std::vector<float>(15, gpu::kScanFarthest));
}

TEST(ScanlineRules, EqualZKeepsTheFirstAndOrderOfDifferentZDoesNotMatter) {
    const std::vector<gpu::ScanCorner> far = {
        {0, 0, 5, {1, 0, 0}}, {9, 0, 5, {1, 0, 0}}, {9, 9, 5, {1, 0, 0}}, {0, 9, 5, {1, 0, 0}}};
    std::vector<gpu::ScanCorner> same = far, near = far;
    for (gpu::ScanCorner& c : same) c.carried = {2, 0, 0};
    for (gpu::ScanCorner& c : near) c.z = 4, c.carried = {3, 0, 0};
    const auto drawn = [](std::initializer_list<const std::vector<gpu::ScanCorner>*> order) {
        ScanList list;
        list.width = list.height = 10;
        for (const auto* polygon : order) EXPECT_TRUE(list.add(*polygon));
        return scanlineCpu(list, nullptr).carried;
    };
    EXPECT_EQ(drawn({&far, &same})[55].x, 1);
    EXPECT_EQ(drawn({&same, &far})[55].x, 2);
    EXPECT_EQ(drawn({&near, &far}), drawn({&far, &near}));
}

TEST(ScanlineRules, WithoutAZBufferTheLastPolygonIsSeen) {
    const std::vector<gpu::ScanCorner> near = {{0, 0, 4, {1, 0, 0}}, {9, 0, 4, {1, 0, 0}}, {9, 9, 4, {1, 0, 0}}, {0, 9, 4, {1, 0, 0}}};
    std::vector<gpu::ScanCorner> far = near;
    for (gpu::ScanCorner& c : far) c.z = 5, c.carried = {2, 0, 0};
    ScanList list;
    list.width = list.height = 10;
    list.zBuffer = false;
    EXPECT_TRUE(list.add(near));
    EXPECT_TRUE(list.add(far));
    const ScanCanvas canvas = scanlineCpu(list, nullptr);
    EXPECT_EQ(canvas.carried[55].x, 2);
    EXPECT_EQ(canvas.z[55], 5);
}

TEST(ScanlineRules, WhatIsLessThanALineHighIsNotPaintedAndTooTallIsRefused) {
    ScanList list;
    list.width = list.height = 10;
    const std::vector<gpu::ScanCorner> flat = {{0, 4, 1, {}}, {9, 4, 1, {}}, {5, 4, 1, {}}},
                                       narrow = {{4, 0, 1, {}}, {4, 9, 1, {}}, {4, 5, 1, {}}};
    EXPECT_FALSE(list.add(flat));
    EXPECT_TRUE(list.add(narrow)) << "a sliver less than a pixel wide is a column (errata B12)";
    const ScanCanvas canvas = scanlineCpu(list, nullptr);
    EXPECT_EQ(std::count(canvas.owner.begin(), canvas.owner.end(), 0u), 10);
    const std::vector<gpu::ScanCorner> tall = {{0, -70000, 1, {}}, {9, 5, 1, {}}, {0, 5, 1, {}}},
                                       wide = {{-70000, 0, 1, {}}, {9, 5, 1, {}}, {0, 5, 1, {}}};
    EXPECT_THROW(list.add(tall), Error);
    EXPECT_THROW(list.add(wide), Error);
}

TEST(ScanlineRules,
     BothEndsArePainted) {  // erratum A9, kept: a 10 x 10 square split along its diagonal paints 66 + 66 pixels
    ScanList list;
    list.width = list.height = 12;
    EXPECT_TRUE(list.add(std::vector<gpu::ScanCorner>{{0, 0, 2, {}}, {10, 0, 2, {}}, {10, 10, 2, {}}}));
    EXPECT_TRUE(list.add(std::vector<gpu::ScanCorner>{{0, 0, 1, {}}, {10, 10, 1, {}}, {0, 10, 1, {}}}));
    const ScanCanvas canvas = scanlineCpu(list, nullptr);
    EXPECT_EQ(std::count(canvas.owner.begin(), canvas.owner.end(), 1u), 66);
    EXPECT_EQ(std::count(canvas.owner.begin(), canvas.owner.end(), 0u), 55) << "the diagonal went to the nearer one";
}

}  // namespace
}  // namespace plumb::test
