// SPDX-License-Identifier: MIT
#include "pipeline/passes/lines.h"

#include "tests/twin/pass_frame.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <ostream>
#include <utility>
#include <vector>

namespace plumb::test {
namespace {

// A list of edges with vertices of their own.
struct Edges {
    std::vector<glm::uvec2> edges;
    std::vector<glm::vec4> positions;
    void add(glm::vec3 a, glm::vec3 b) {
        edges.push_back({uint32_t(positions.size()), uint32_t(positions.size()) + 1});
        positions.emplace_back(a, 1.0f);
        positions.emplace_back(b, 1.0f);
    }
};

// Level, upright, diagonal and single-point lines through pixel centres and beside them, lines across the near plane and far
// beyond the frame, the same line both ways, and random ones.
Edges edgesFor(View v, uint32_t randomOnes) {
    Edges e;
    Random r(53);
    const auto at = [&](double x, double y, double w = 1) { return v.pointAt(x, y, w); };
    for (int k = -3; k <= 3; ++k) {
        const double d = k * kSubpixel;
        e.add(at(0.5, 5.5 + d), at(v.width - 0.5, 5.5 + d));
        e.add(at(7.5 + d, 0.5), at(7.5 + d, v.height - 0.5));
        e.add(at(3.5 + d, 3.5), at(20.5 + d, 20.5));
        e.add(at(30.5, 3.5 + d), at(13.5, 20.5 + d));
        e.add(at(12.5, 12.5), at(12.5 + d, 12.5 + d));
    }
    e.add(at(10.5, 10.5, kNear), at(30.5, 12.5, kNear));  // in the near plane: neither end is outside
    for (int k = 0; k < 20; ++k) {
        const glm::vec3 a = at(r(0, v.width), r(0, v.height), 2), b = at(r(0, v.width), r(0, v.height), 4);
        e.add(a, b);
        e.add(b, a);
        e.add(a, -b);  // through the near plane
        e.add(at(r(-9000, 9000), r(-9000, 9000)), at(r(-9000, 9000), r(-9000, 9000)));
        e.add(-a, -b);  // behind the eye
        e.add(a, a);
        e.add(at(r(0, v.width), r(0, v.height), kNear), a);
    }
    while (e.edges.size() < randomOnes)
        e.add(at(r(-0.2, 1.2) * v.width, r(-0.2, 1.2) * v.height, r(0.3, 9)),
              at(r(-0.2, 1.2) * v.width, r(-0.2, 1.2) * v.height, r(0.3, 9)));
    return e;
}

struct Row {
    uint32_t width, height, edges;
    int bandRows;
};
std::ostream& operator<<(std::ostream& out, const Row& r) { return out << r.width << 'x' << r.height; }

class LinesTwin : public OnDevice<::testing::TestWithParam<Row>> {};

TEST_P(LinesTwin, LeavesTheSameOwners) {
    const Row& row = GetParam();
    const SceneCase c{"soupOne", soupOne, row.width, row.height};
    const DrawList list = prepare(c.scene(), requestOf(c)).list;
    const Edges e = edgesFor(c.view(), row.edges);
    gpu::LinesPush push{};
    push.edgeNumber = 3;
    push.edgeCount = uint32_t(e.edges.size());
    push.width = int(row.width);
    push.height = int(row.height);
    push.rowPixels = row.width;
    push.viewport = list.viewport;
    push.viewport.guardX = list.viewport.centreX + 1.0f;  // as the contract says: half the frame and one pixel
    push.viewport.guardY = list.viewport.centreY + 1.0f;
    size_t owned = 0;
    for (int firstRow = 0; firstRow < int(row.height); firstRow += row.bandRows) {
        push.firstRow = firstRow;
        push.rows = std::min(row.bandRows, int(row.height) - firstRow);
        const size_t pixels = size_t(row.width) * size_t(push.rows);
        std::vector<uint32_t> want(pixels, gpu::kNoEdge);
        linesCpu(push, e.edges, e.positions, list.objects, want);
        for (uint32_t o : want) owned += o != gpu::kNoEdge;
        for (const Specialization& exact : exactForms(device())) {
            Recorder recorder(device());
            auto edges = bufferOf(device(), e.edges);
            auto positions = bufferOf(device(), e.positions);
            auto objects = bufferOf(device(), list.objects);
            Buffer<uint32_t> owners(device(), pixels + kSentinels, "owners");
            owners.fill(kSentinel);
            std::fill_n(owners.span().begin(), pixels, gpu::kNoEdge);
            recordLines(recorder, push, exact, edges, positions, objects, owners);
            recorder.run(kWatchdogMs);
            expectSame<uint32_t>("lines: owner", want, std::as_const(owners).span().first(pixels),
                                 [&](size_t i) { return fmt::format("pixel ({}, {})", i % row.width, i / row.width + size_t(firstRow)); });
            expectSentinels("lines", owners, pixels);
        }
    }
    EXPECT_GT(owned, 0u) << "no pixel is owned: this row shows nothing";
}

// Surfaces before, behind and at the lines, of their polygons and of others, and places where nothing is seen.
TEST_P(LinesTwin, LeavesTheSameOwnersWhereHiddenLinesAreRemoved) {
    const Row& row = GetParam();
    const SceneCase c{"soupOne", soupOne, row.width, row.height};
    const DrawList list = prepare(c.scene(), requestOf(c)).list;
    const Edges e = edgesFor(c.view(), row.edges);
    Random r(59);
    std::vector<uint32_t> faces;
    for (size_t i = 0; i < e.edges.size(); ++i) faces.push_back(uint32_t(i % 7));
    std::vector<glm::uvec2> surfaces;
    for (size_t i = 0; i < size_t(row.width) * row.height; ++i) {
        const float z = i % 3 == 0 ? float(kNear) : float(kNear / r(0.3, 9));  // that of lines at w = 1, often exactly
        surfaces.push_back(i % 11 == 0 ? glm::uvec2(0, gpu::kNoFace) : glm::uvec2(gpu::ubitsOf(z), r.below(7)));
    }
    gpu::LinesPush push{};
    push.edgeCount = uint32_t(e.edges.size());
    push.rowPixels = row.width;
    push.width = int(row.width);
    push.height = int(row.height);
    push.viewport = list.viewport;
    push.viewport.guardX = list.viewport.centreX + 1.0f;
    push.viewport.guardY = list.viewport.centreY + 1.0f;
    size_t owned = 0, removed = 0;
    for (int firstRow = 0; firstRow < int(row.height); firstRow += row.bandRows) {
        push.firstRow = firstRow;
        push.rows = std::min(row.bandRows, int(row.height) - firstRow);
        push.surfaceRow = std::max(0, firstRow - 1);
        push.surfaceRows = std::min(firstRow + push.rows + 1, int(row.height)) - push.surfaceRow;
        const auto begin = surfaces.begin() + ptrdiff_t(size_t(push.surfaceRow) * row.width);
        const std::vector<glm::uvec2> band(begin, begin + ptrdiff_t(size_t(push.surfaceRows) * row.width));
        const size_t pixels = size_t(row.width) * size_t(push.rows);
        std::vector<uint32_t> want(pixels, gpu::kNoEdge), all(pixels, gpu::kNoEdge);
        linesCpu(push, e.edges, e.positions, list.objects, want, {faces, band});
        linesCpu(push, e.edges, e.positions, list.objects, all);
        for (size_t i = 0; i < pixels; ++i) owned += want[i] != gpu::kNoEdge, removed += want[i] != all[i];
        for (const Specialization& exact : exactForms(device())) {
            Recorder recorder(device());
            auto edges = bufferOf(device(), e.edges);
            auto positions = bufferOf(device(), e.positions);
            auto objects = bufferOf(device(), list.objects);
            auto edgeFaces = bufferOf(device(), faces);
            auto seen = bufferOf(device(), band);
            Buffer<uint32_t> owners(device(), pixels + kSentinels, "owners");
            owners.fill(kSentinel);
            std::fill_n(owners.span().begin(), pixels, gpu::kNoEdge);
            recordHiddenLines(recorder, push, exact, edges, positions, objects, owners, edgeFaces, seen);
            recorder.run(kWatchdogMs);
            expectSame<uint32_t>("lines: owner", want, std::as_const(owners).span().first(pixels),
                                 [&](size_t i) { return fmt::format("pixel ({}, {})", i % row.width, i / row.width + size_t(firstRow)); });
            expectSentinels("lines", owners, pixels);
        }
    }
    EXPECT_GT(owned, 0u);
    EXPECT_GT(removed, 0u) << "no line is hidden: this row shows nothing";
}

INSTANTIATE_TEST_SUITE_P(Rows, LinesTwin,
                         ::testing::Values(Row{19, 19, 1, 19}, Row{131, 67, 1, 67}, Row{131, 67, 3000, 67}, Row{131, 67, 1, 7},
                                           Row{333, 211, 500, 211}, Row{333, 211, 500, 64}),
                         [](const auto& info) {
                             const Row& r = info.param;
                             return fmt::format("{}x{}_{}edges_{}rows", r.width, r.height, r.edges, r.bandRows);
                         });

// One level line at w = 1 over hand-made surfaces: what shows it, and what hides it.
TEST(LinesTwinByHand, ShowsALineByItsOwnPolygonOrByItsDepth) {
    const SceneCase c{"soupOne", soupOne, 19, 19};
    const DrawList list = prepare(c.scene(), requestOf(c)).list;
    Edges e;
    e.add(c.view().pointAt(3.5, 4.5, 1), c.view().pointAt(11.5, 4.5, 1));
    gpu::LinesPush push{};
    push.edgeCount = 1;
    push.width = push.height = push.rows = push.surfaceRows = 19;
    push.rowPixels = 19;
    push.viewport = list.viewport;
    const uint32_t at = gpu::ubitsOf(0.25f), nearer = gpu::ubitsOf(0.5f), farther = gpu::ubitsOf(0.125f);
    std::vector<glm::uvec2> surfaces(19 * 19, glm::uvec2(nearer, 5));
    const auto put = [&](uint32_t x, uint32_t y, uint32_t z, uint32_t face) { surfaces[y * 19 + x] = {z, face}; };
    put(4, 4, at, 5);  // as near as the line
    put(5, 4, farther, 5);
    put(6, 4, 0, gpu::kNoFace);  // nothing
    put(7, 4, nearer, 2);        // its own polygon, nearer by rounding
    put(8, 3, nearer, 2);        // its own polygon above
    put(9, 5, farther, 2);       // and below
    put(10, 5, farther, 5);      // a surface behind it, but beside it
    std::vector<uint32_t> owners(19 * 19, gpu::kNoEdge);
    const std::vector<uint32_t> faces = {2};
    linesCpu(push, e.edges, e.positions, list.objects, owners, {faces, surfaces});
    for (uint32_t x = 0; x < 19; ++x) EXPECT_EQ(owners[4 * 19 + x] == 0u, x >= 4 && x <= 9) << "column " << x;
}

// An upright edge and a level one, by hand.
TEST(LinesTwinByHand, DrawsTheCentresOfAHalfOpenLine) {
    const SceneCase c{"soupOne", soupOne, 19, 19};
    const DrawList list = prepare(c.scene(), requestOf(c)).list;
    Edges e;
    e.add(c.view().pointAt(3.5, 4.5, 1), c.view().pointAt(8.5, 4.5, 1));
    e.add(c.view().pointAt(11.5, 2.5, 1), c.view().pointAt(11.5, 6.5, 1));
    gpu::LinesPush push{};
    push.edgeCount = 2;
    push.width = push.height = push.rows = 19;
    push.rowPixels = 19;
    push.viewport = list.viewport;
    std::vector<uint32_t> owners(19 * 19, gpu::kNoEdge);
    linesCpu(push, e.edges, e.positions, list.objects, owners);
    for (uint32_t y = 0; y < 19; ++y)
        for (uint32_t x = 0; x < 19; ++x) {
            const uint32_t want = y == 4 && x >= 3 && x < 8 ? 0u : x == 11 && y >= 2 && y < 6 ? 1u : gpu::kNoEdge;
            EXPECT_EQ(owners[y * 19 + x], want) << "pixel (" << x << ", " << y << ")";
        }
}

}  // namespace
}  // namespace plumb::test
