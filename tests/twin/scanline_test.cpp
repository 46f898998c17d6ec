// SPDX-License-Identifier: MIT
#include "pipeline/passes/scanline.h"

#include "tests/twin/scanline_oracle.h"
#include "tests/twin/scanline_support.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <iostream>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
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
        polygon.push_back({int(std::nearbyint(x + reach * std::cos(angle))),
                           int(std::nearbyint(y + reach * flat * std::sin(angle))),
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
    const int w = width, h = height;
    // Exactly one pixel, one row (no table: not painted), one column, the frame itself, beyond each side, equal Z twice.
    add({{3, 3, 1, {1, 2, 3}}, {3, 3, 1, {1, 2, 3}}, {3, 3, 1, {1, 2, 3}}});
    add({{0, 2, 1, {}}, {5, 2, 1, {}}, {2, 2, 1, {}}});
    add({{1, 0, 7, {0.5f, 0, 0}}, {1, 6, 9, {0, 1, 0}}, {1, 3, 8, {0, 0, 1}}});
    add({{0, 0, 400, {1, 0, 0}}, {w - 1, 0, 400, {0, 1, 0}}, {w - 1, h - 1, 400, {0, 0, 1}}, {0, h - 1, 400, {1, 1, 1}}});
    add({{0, 0, 400, {9, 9, 9}}, {w, 0, 400, {9, 9, 9}}, {w, h, 400, {9, 9, 9}}, {0, h, 400, {9, 9, 9}}});
    add({{-20, -20, 399, {2, 0, 0}}, {5, -3, 399, {}}, {-4, 9, 399, {}}});
    add({{w + 20, 1, 399, {3, 0, 0}}, {w - 3, 4, 399, {}}, {w + 9, h + 7, 399, {}}});
    // The triangle of section 13.1, whose edge is switched in the middle.
    add({{10, 20, 100, {1, 0, 0}}, {30, 0, 200, {0, 1, 0}}, {30, 30, 300, {0, 0, 1}}});
    for (uint32_t i = 0; i < count; ++i) add(polygonAround(r, r(-0.2, 1.2) * width, r(-0.2, 1.2) * height, r(0.5, reach), 3 + r.below(6)));
    return list;
}

void expectSameCanvas(const ScanList& list) {
    const ScanCanvas canvas = sameOnBothSides(list, nullptr);
    EXPECT_LT(size_t(std::count(canvas.owner.begin(), canvas.owner.end(), gpu::kNoPolygon)), canvas.owner.size()) << "nothing is painted";
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
    const std::vector<gpu::ScanCorner> far = {{0, 0, 5, {1, 0, 0}}, {9, 0, 5, {1, 0, 0}}, {9, 9, 5, {1, 0, 0}}, {0, 9, 5, {1, 0, 0}}};
    std::vector<gpu::ScanCorner> same = far, near = far;
    for (gpu::ScanCorner& c : same) c.attributes = {2, 0, 0};
    for (gpu::ScanCorner& c : near) c.z = 4, c.attributes = {3, 0, 0};
    const auto drawn = [](std::initializer_list<const std::vector<gpu::ScanCorner>*> order) {
        ScanList list;
        list.width = list.height = 10;
        for (const auto* polygon : order) EXPECT_TRUE(list.add(*polygon));
        return scanlineCpu(list).attributes;
    };
    EXPECT_EQ(drawn({&far, &same})[55].x, 1);
    EXPECT_EQ(drawn({&same, &far})[55].x, 2);
    EXPECT_EQ(drawn({&near, &far}), drawn({&far, &near}));
}

TEST(ScanlineRules, WithoutAZBufferTheLastPolygonIsSeen) {
    const std::vector<gpu::ScanCorner> near = {{0, 0, 4, {1, 0, 0}}, {9, 0, 4, {1, 0, 0}}, {9, 9, 4, {1, 0, 0}}, {0, 9, 4, {1, 0, 0}}};
    std::vector<gpu::ScanCorner> far = near;
    for (gpu::ScanCorner& c : far) c.z = 5, c.attributes = {2, 0, 0};
    ScanList list;
    list.width = list.height = 10;
    list.zBuffer = false;
    EXPECT_TRUE(list.add(near));
    EXPECT_TRUE(list.add(far));
    const ScanCanvas canvas = scanlineCpu(list);
    EXPECT_EQ(canvas.attributes[55].x, 2);
    EXPECT_EQ(canvas.z[55], 5);
}

TEST(ScanlineRules, WhatIsLessThanALineHighIsNotPainted) {
    ScanList list;
    list.width = list.height = 10;
    const std::vector<gpu::ScanCorner> flat = {{0, 4, 1, {}}, {9, 4, 1, {}}, {5, 4, 1, {}}},
                                       narrow = {{4, 0, 1, {}}, {4, 9, 1, {}}, {4, 5, 1, {}}};
    EXPECT_FALSE(list.add(flat));
    EXPECT_TRUE(list.add(narrow)) << "a sliver less than a pixel wide is a column (errata B12)";
    const ScanCanvas canvas = scanlineCpu(list);
    EXPECT_EQ(std::count(canvas.owner.begin(), canvas.owner.end(), 0u), 10);
}

using Corners = std::vector<gpu::ScanCorner>;

// Columns that the lines of an entry of the list paint, against the oracle's for `polygon`; how many lines were judged.
size_t expectItsLines(const ScanList& list, const gpu::ScanPolygon& p, std::span<const gpu::ScanSpan> spans, const Corners& polygon) {
    for (int line = 0; line < p.lineCount; ++line) {
        const std::optional<PaintedLine> want = paintedLine(polygon, p.firstLine + line);
        if (!want) {
            ADD_FAILURE() << "a line that the polygon has not: " << p.firstLine + line;
            continue;
        }
        const gpu::ScanSpan& s = spans[p.firstSpan + size_t(line)];
        int64_t next = std::max<int64_t>(want->first, p.firstColumn);
        const int64_t end = std::min<int64_t>(want->last + 1, p.firstColumn + p.columnCount);
        for (int steps = gpu::scanFirstStep(s, p), last = gpu::scanLastStep(s, p); steps <= last; ++steps, ++next)
            if (gpu::scanColumn(s, steps) != next || next >= list.width) break;
        if (next == std::max<int64_t>(end, std::max<int64_t>(want->first, p.firstColumn))) continue;
        std::string corners;
        for (const gpu::ScanCorner& c : polygon) corners += fmt::format(" ({}, {})", c.x, c.y);
        ADD_FAILURE() << "line " << p.firstLine + line << " of" << corners << ": columns " << want->first << " to " << want->last
                      << ", the first that is missing or too many is " << next;
    }
    return size_t(p.lineCount);
}

// Three corners at most `reach` from (x, y), on both sides of it.
Corners smallTriangle(Random& r, int x, int y, uint32_t reach) {
    Corners corners;
    for (int i = 0; i < 3; ++i)
        corners.push_back(
            {x + int(r.below(2 * reach + 1)) - int(reach), y + int(r.below(2 * reach + 1)) - int(reach), float(r(-1, 1)), {}});
    return corners;
}

// True when the notes' loop in float32, dX added from line to line and 1 from column to column, leaves a column of the triangle out.
bool sumsLeaveAGap(Corners c) {
    std::sort(c.begin(), c.end(), [](const gpu::ScanCorner& a, const gpu::ScanCorner& b) { return a.y < b.y; });
    if (c[0].y == c[1].y || c[1].y == c[2].y) return false;
    const auto slope = [](const gpu::ScanCorner& a, const gpu::ScanCorner& b) { return float(b.x - a.x) / float(b.y - a.y); };
    float longX = float(c[0].x), shortX = longX, step = slope(c[0], c[1]);
    for (int y = c[0].y; y <= c[2].y; ++y) {
        const float right = std::max(longX, shortX);
        for (float x = std::min(longX, shortX); x + 1 <= right; x = x + 1)
            if (std::floor(x + 1 + 0.5f) - std::floor(x + 0.5f) != 1) return true;
        longX = longX + slope(c[0], c[2]);
        shortX = shortX + step;
        if (y == c[1].y) step = slope(c[1], c[2]), shortX = float(c[1].x) + step;
    }
    return false;
}

// Where a column or a row passes a power of two a float's last place doubles: no line may lose a column there. 10^6 triangles in all;
// with PLUMB_LONG 10^6 at each power, in either direction.
TEST(ScanlineRules, NoLineHasAGapAtAPowerOfTwo) {
    constexpr int kHighestPower = 16;  // a canvas has at most 65,536 columns and rows
    constexpr size_t kTriangles = 1000000, kAtOnce = 1000;
    const size_t each = std::getenv("PLUMB_LONG") ? kTriangles : kTriangles / (2 * kHighestPower);
    size_t lines = 0, triangles = 0, gapsOfSums = 0;
    for (int power = 1; power <= kHighestPower && !::testing::Test::HasFailure(); ++power)
        for (const bool rows : {false, true}) {
            Random r(uint32_t(100 * power + rows));
            const int place = 1 << power;
            for (size_t done = 0; done < each; done += kAtOnce) {
                ScanList list;
                (rows ? list.height : list.width) = place + 64;
                (rows ? list.width : list.height) = 64;
                std::vector<Corners> polygons;
                while (polygons.size() < kAtOnce) {
                    const Corners corners = smallTriangle(r, rows ? 32 : place, rows ? place : 32, 2 + r.below(23));
                    if (list.add(corners)) polygons.push_back(corners);
                }
                ASSERT_EQ(list.polygons.size(), polygons.size());
                const std::vector<gpu::ScanSpan> spans = scanSpansCpu(list);
                for (size_t i = 0; i < polygons.size(); ++i) lines += expectItsLines(list, list.polygons[i], spans, polygons[i]);
                triangles += polygons.size();
                if (!rows)
                    for (const Corners& corners : polygons) gapsOfSums += sumsLeaveAGap(corners);
            }
        }
    EXPECT_GE(triangles, kTriangles - kAtOnce);
    EXPECT_GT(lines, triangles);
    EXPECT_GT(gapsOfSums, 0u) << "sums of rounded steps lose columns of these triangles";
    std::cout << lines << " lines of " << triangles << " triangles; sums of float32 leave a gap in " << gapsOfSums << " triangles\n";
}

// Painted pixels are the oracle's: each pixel belongs to the last polygon whose line covers it.
void expectTheOraclesPixels(const ScanList& list, const ScanCanvas& canvas, const std::vector<Corners>& polygons) {
    std::vector<uint32_t> want(canvas.owner.size(), gpu::kNoPolygon);
    for (uint32_t i = 0; i < polygons.size(); ++i)
        for (int y = 0; y < list.height; ++y)
            if (const std::optional<PaintedLine> line = paintedLine(polygons[i], y))
                for (int64_t x = std::max<int64_t>(0, line->first); x <= std::min<int64_t>(list.width - 1, line->last); ++x)
                    want[size_t(y) * size_t(list.width) + size_t(x)] = i;
    expectSamePlane("polygon", uint32_t(list.width), 1, want, canvas.owner);
}

TEST_F(ScanlineTwin, NoLineHasAGapAtAPowerOfTwo) {
    for (const int place : {128, 256, 1024, 4096, 16384})
        for (const bool rows : {false, true}) {
            SCOPED_TRACE(fmt::format("{} {}", rows ? "row" : "column", place));
            Random r(uint32_t(place + rows));
            ScanList list;
            list.zBuffer = false;
            (rows ? list.height : list.width) = place + 32;
            (rows ? list.width : list.height) = 64;
            std::vector<Corners> polygons;
            while (polygons.size() < 60) {
                const Corners corners = smallTriangle(r, rows ? int(r.below(64)) : place, rows ? place : int(r.below(64)), 2 + r.below(23));
                if (list.add(corners)) polygons.push_back(corners);
            }
            expectTheOraclesPixels(list, sameOnBothSides(list, nullptr), polygons);
        }
}

// Corners up to the farthest pixel: the canvas shows what the whole polygon would have there.
TEST_F(ScanlineTwin, LargePolygonsPaintTheirPartOfTheCanvas) {
    for (const double reach : {3e2, 3e4, 3e6, double(gpu::kScanFarthestPixel)}) {
        SCOPED_TRACE(reach);
        Random r{uint32_t(reach)};
        ScanList list;
        list.zBuffer = false;
        list.width = 97;
        list.height = 61;
        std::vector<Corners> polygons;
        for (int tries = 0; tries < 400; ++tries) {
            Corners corners;
            for (int i = 0; i < 3; ++i) {
                const double far = reach * std::pow(r(0, 1), 4);  // some near the canvas, so that edges cross it
                corners.push_back({int(far * r(-1, 1)), int(far * r(-1, 1)), float(r(-1e6, 1)), {float(r(0, 1)), 0, 1}});
            }
            if (list.add(corners)) polygons.push_back(corners);
        }
        ASSERT_GT(polygons.size(), 100u);
        expectTheOraclesPixels(list, sameOnBothSides(list, nullptr), polygons);
    }
}

// A window of the canvas has the bytes of the whole picture there: what is walked outside changes nothing.
TEST(ScanlineRules, AWindowHasTheBytesOfTheWholePicture) {
    constexpr int kWidth = 900, kHeight = 700;
    Random r(23);
    for (int tries = 0; tries < 60; ++tries) {
        const Corners polygon = polygonAround(r, r(200, 700), r(200, 500), r(50, 200), 3 + r.below(5));
        ScanList whole, part;
        whole.width = kWidth;
        whole.height = kHeight;
        const int left = int(r.below(500)), top = int(r.below(400));
        part.width = 150;
        part.height = 120;
        Corners moved = polygon;
        for (gpu::ScanCorner& c : moved) c.x -= left, c.y -= top;
        if (!whole.add(polygon) || !part.add(moved)) continue;
        const ScanCanvas all = scanlineCpu(whole), window = scanlineCpu(part);
        for (int y = 0; y < part.height; ++y)
            for (int x = 0; x < part.width; ++x) {
                const size_t at = size_t(y * part.width + x), there = size_t((y + top) * kWidth + x + left);
                ASSERT_EQ(window.owner[at], all.owner[there]) << x << ' ' << y;
                ASSERT_EQ(window.z[at], all.z[there]);
                ASSERT_EQ(window.attributes[at], all.attributes[there]);
            }
    }
}

TEST_F(ScanlineTwin, ACanvasLongerThanABlockIsPaintedInSeveral) {
    for (const bool tall : {false, true}) {
        const int width = tall ? 5 : 65000, height = tall ? 65000 : 5;
        ScanList list;
        list.width = width;
        list.height = height;
        const Corners corners = {{-9, -9, 1, {1, 0, 0}}, {2 * width, -9, 2, {0, 1, 0}}, {-9, 2 * height, 3, {0, 0, 1}}};
        EXPECT_TRUE(list.add(corners));
        EXPECT_EQ(list.polygons.size(), 3u);
        const ScanCanvas canvas = sameOnBothSides(list, nullptr);
        size_t painted = 0;
        for (int y = 0; y < height; ++y)
            if (const std::optional<PaintedLine> line = paintedLine(corners, y))
                painted += size_t(std::min<int64_t>(width - 1, line->last) + 1);
        EXPECT_EQ(canvas.owner.size() - size_t(std::count(canvas.owner.begin(), canvas.owner.end(), gpu::kNoPolygon)), painted);
    }
}

// base + steps step to 2^-33 of the larger summand before the one rounding.
TEST(ScanlineRules, AStepIsRoundedOnce) {
    Random r(29);
    for (int i = 0; i < 1000000; ++i) {
        const float base = float(r(-500, 500)), steps = i % 2 ? float(r.below(60000)) : float(r(0, 3000)),
                    step = float(r(-1, 1) * std::pow(10, r(-6, 1)));
        const long double product = static_cast<long double>(steps) * step, exact = base + product;
        const float got = gpu::scanAlong(base, steps, step);
        const long double halfPlace = (std::nextafter(std::abs(got), 1e30f) - static_cast<long double>(std::abs(got))) / 2;
        ASSERT_LE(std::abs(got - exact), halfPlace + 0x1p-33L * std::max(std::abs(static_cast<long double>(base)), std::abs(product)))
            << base << ' ' << steps << ' ' << step;
    }
}

TEST(ScanlineRules,
     BothEndsArePainted) {  // erratum A9, kept: a 10 x 10 square split along its diagonal paints 66 + 66 pixels
    ScanList list;
    list.width = list.height = 12;
    EXPECT_TRUE(list.add(std::vector<gpu::ScanCorner>{{0, 0, 2, {}}, {10, 0, 2, {}}, {10, 10, 2, {}}}));
    EXPECT_TRUE(list.add(std::vector<gpu::ScanCorner>{{0, 0, 1, {}}, {10, 10, 1, {}}, {0, 10, 1, {}}}));
    const ScanCanvas canvas = scanlineCpu(list);
    EXPECT_EQ(std::count(canvas.owner.begin(), canvas.owner.end(), 1u), 66);
    EXPECT_EQ(std::count(canvas.owner.begin(), canvas.owner.end(), 0u), 55) << "the diagonal went to the nearer one";
}

}  // namespace
}  // namespace plumb::test
