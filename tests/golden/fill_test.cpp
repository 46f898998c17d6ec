// SPDX-License-Identifier: MIT
// `--fill notes` against the worked examples: coverage and counts exactly, X and Z within the file's float32 tolerance, on the device
// and by the twin (equal bytes).
#include "pipeline/render/render.h"
#include "pipeline/scene/load.h"
#include "tests/golden/golden.h"
#include "tests/support/temporary_folder.h"
#include "tests/twin/scanline_support.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <glm/glm.hpp>
#include <iterator>
#include <set>
#include <string>
#include <vector>

namespace plumb::golden {
namespace {

using namespace plumb::test;

bool within(double got, const Json& want) {
    return std::abs(got - want.get<double>()) <= tolerance().float32 * std::max(1.0, std::abs(want.get<double>()));
}

gpu::ScanCorner cornerOf(const Json& v) {
    return {int(v[0].get<double>()), int(v[1].get<double>()), v.size() > 2 ? float(v[2].get<double>()) : 0.0f, {}};
}

double rightX(const gpu::ScanSpan& s) { return double(s.leftX) + double(s.wide); }

// One polygon by both sides: lines and pixels.
struct Filled {
    std::vector<gpu::ScanSpan> lines;
    ScanCanvas canvas;
};
Filled filled(const std::vector<gpu::ScanCorner>& polygon, int width, int height) {
    ScanList list;
    list.width = width;
    list.height = height;
    EXPECT_TRUE(list.add(polygon));
    Filled f;
    f.canvas = sameOnBothSides(list, &f.lines);
    return f;
}
std::vector<uint32_t> columnsOf(const ScanCanvas& canvas, int width, int y) {
    std::vector<uint32_t> columns;
    for (int x = 0; x < width; ++x)
        if (canvas.owner[size_t(y) * size_t(width) + size_t(x)] != gpu::kNoPolygon) columns.push_back(uint32_t(x));
    return columns;
}

TEST(GoldenFill, TheTriangleOf13PaintsTheCorrectedLines) {
    const Entry table("s131_fill_table"), lines("s132_fill_triangle_corrected");
    const Filled f = filled({cornerOf(table.input("A")), cornerOf(table.input("B")), cornerOf(table.input("C"))}, 40, 40);
    size_t pixels = 0;
    for (const Json& span : lines.data("spans_y_x0_x1")) {
        const std::vector<uint32_t> columns = columnsOf(f.canvas, 40, span[0].get<int>());
        ASSERT_FALSE(columns.empty());
        EXPECT_EQ(columns.front(), span[1].get<uint32_t>()) << "line " << span[0];
        EXPECT_EQ(columns.back(), span[2].get<uint32_t>()) << "line " << span[0];
        EXPECT_EQ(columns.size(), columns.back() - columns.front() + 1);
        pixels += columns.size();
    }
    Entry counts("s132_fill_triangle_corrected");
    EXPECT_EQ(pixels, counts.expected("pixel_count").get<size_t>());
    EXPECT_EQ(f.lines.size(), counts.expected("rows").get<size_t>());
    EXPECT_EQ(size_t(std::count(f.canvas.owner.begin(), f.canvas.owner.end(), 0u)), pixels) << "and nothing elsewhere";
}

TEST(GoldenFill, TheFrontOfThePyramidHasTheRowsOf14) {
    const Entry corners("s142_front_fill_table");
    Entry rows("s143_front_fill_rows");
    const Filled f = filled({cornerOf(corners.input("A")), cornerOf(corners.input("B1")), cornerOf(corners.input("B4"))}, 400, 400);
    ASSERT_EQ(f.lines.size(), rows.data("rows").size());
    size_t pixels = 0;
    for (size_t i = 0; i < f.lines.size(); ++i) {
        const Json& row = rows.data("rows")[i];
        EXPECT_TRUE(within(f.lines[i].leftX, row[1])) << row << f.lines[i].leftX;
        EXPECT_TRUE(within(rightX(f.lines[i]), row[2])) << row << rightX(f.lines[i]);
        EXPECT_TRUE(within(f.lines[i].left.z, row[3])) << row << f.lines[i].left.z;
        EXPECT_TRUE(within(f.lines[i].right.z, row[4])) << row << f.lines[i].right.z;
        const size_t painted = columnsOf(f.canvas, 400, row[0].get<int>()).size();
        EXPECT_EQ(painted, row[6].get<size_t>()) << row;
        pixels += painted;
    }
    EXPECT_EQ(pixels, rows.expected("literal_pixel_count").get<size_t>());
    EXPECT_EQ(f.lines.size(), rows.expected("rows").get<size_t>());
}

TEST(GoldenFill, Polygon0CarriesIntensitiesAndNormalsAsIn17) {
    Entry setup("s172_gouraud_setup_polygon0");
    const Entry lines("s173_phong_setup_polygon0");
    const Json &display = setup.expected("display_rounded"), &lights = setup.expected("ambient_diffuse_specular"),
               &normals = setup.expected("vertex_normals");
    for (const bool phong : {false, true}) {
        std::vector<gpu::ScanCorner> polygon;
        for (size_t i = 0; i < display.size(); ++i) {
            polygon.push_back(cornerOf(display[i]));
            polygon.back().attributes =
                phong ? glm::vec3(vectorOf<glm::dvec3>(normals[i]))
                      : glm::vec3(float(lights[i][0].get<double>()), float(lights[i][1].get<double>()), float(lights[i][2].get<double>()));
        }
        const Filled f = filled(polygon, 400, 400);
        const int first = lines.data("corrected_switch")[0]["y"].get<int>();
        for (const Json& row : lines.data("corrected_switch")) {
            const int y = row["y"].get<int>();
            const gpu::ScanSpan& s = f.lines.at(size_t(y - first));
            EXPECT_TRUE(within(s.leftX, row["left"]["X"]) && within(rightX(s), row["right"]["X"])) << row;
            EXPECT_TRUE(within(s.left.z, row["left"]["Z"]) && within(s.right.z, row["right"]["Z"])) << row;
            const std::vector<uint32_t> columns = columnsOf(f.canvas, 400, y);
            EXPECT_EQ(columns.size(), row["pixel_count"].get<size_t>()) << "line " << y;
            for (const Json& pixel : row["pixels"]) {
                const size_t at = size_t(y) * 400 + columns.at(pixel[0].get<size_t>());
                EXPECT_TRUE(within(f.canvas.z[at], pixel[2])) << pixel << f.canvas.z[at];
                const glm::vec3 c = f.canvas.attributes[at];
                if (!phong) {
                    EXPECT_TRUE(within(c.x + c.y + c.z, pixel[3])) << pixel;
                }
                const glm::dvec3 n = glm::normalize(glm::dvec3(c));
                for (int axis = 0; phong && axis < 3; ++axis) EXPECT_TRUE(within(n[axis], pixel[4][size_t(axis)])) << pixel;
            }
        }
    }
}

Scene cylinderScene(bool cull) {
    Scene scene = loadScene({PLUMB_SOURCE_DIR "/scenes/cylinder.toml"}, {});
    scene.cullBackFaces = cull;
    completeScene(scene, {400, 400}, "", false);
    return scene;
}
RenderRequest request(Shading shading) {
    RenderRequest r;
    r.width = r.height = 400;
    r.encoding = Encoding::linear;
    r.shading = shading;
    r.fill = Fill::notes;
    return r;
}
// The ten-polygon cylinder with nothing culled, as the notes count.
GOLDEN(s172_normal_counts) {
    const Scene scene = cylinderScene(false);
    const RenderCounters gouraud = renderCpu(scene, request(Shading::gouraud)).counters,
                         flat = renderCpu(scene, request(Shading::flat)).counters;
    const RenderCounters device = renderGpu(*DeviceEnvironment::device(), scene, request(Shading::gouraud)).counters;
    EXPECT_EQ(gouraud.normals, device.normals);
    EXPECT_EQ(gouraud.illuminations, device.illuminations);
    size_t rectangle = 0, cap = 0;
    const TriangleMesh& mesh = scene.meshes[0];
    for (uint32_t face = 0; face < mesh.faceCentre.size(); ++face) {
        const size_t corners =
            2 + size_t(std::count_if(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& t) { return t.face == face; }));
        (corners == 4 ? rectangle : cap) += corners;
    }
    e.exactly("surface_normals", gouraud.polygons);
    e.exactly("rectangle_vertex_normals", rectangle);
    e.exactly("cap_vertex_normals", cap);
    e.exactly("normals_total", gouraud.normals);
    e.exactly("illumination_evaluations", gouraud.illuminations);
    e.exactly("flat_illumination_evaluations", flat.illuminations);
}

TEST(GoldenFill, WholePicturesAreTheSameOnBothSides) {
    for (const char* file : {"/scenes/cylinder.toml", "/scenes/pyramid.toml", "/scenes/still-life.toml"}) {
        Scene scene = loadScene({std::string(PLUMB_SOURCE_DIR) + file}, {});
        completeScene(scene, {400, 400}, "", false);
        for (const Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong}) {
            RenderRequest r = request(shading);
            r.planes = kEveryPlane;
            const RenderResult twin = renderCpu(scene, r), device = renderGpu(*DeviceEnvironment::device(), scene, r);
            SCOPED_TRACE(std::string(file) + " " + std::to_string(int(shading)));
            expectSameFrame(twin.frame, device.frame);
            EXPECT_GT(twin.frame.coveredPixels, 0u);
            EXPECT_EQ(twin.counters.drawnTriangles, device.counters.drawnTriangles);
        }
    }
    expectNoValidationMessages(*DeviceEnvironment::device());
}

// Front, Left and Right of the pyramid are seen; Back and Base are not (12.4).
TEST(GoldenFill, ThePyramidShowsThreeOfFive) {
    Scene scene = loadScene({PLUMB_SOURCE_DIR "/scenes/pyramid.toml"}, {});
    completeScene(scene, {400, 400}, "", false);
    RenderRequest r = request(Shading::flat);
    r.planes |= kPlanePrimitive;
    RenderResult result = renderCpu(scene, r);
    EXPECT_EQ(result.counters.polygons, 5u);
    EXPECT_EQ(result.counters.culledBackFace, 2u);
    const std::set<uint32_t> seen(result.frame.primitive.begin(), result.frame.primitive.end());
    EXPECT_EQ(seen, (std::set<uint32_t>{0, 2, 3, kNone}));
    // Culling changes nothing that is seen of a closed object: the Z-buffer hides the back.
    const std::vector<uint32_t> culled = result.frame.rgba;
    scene.cullBackFaces = false;
    result = renderCpu(scene, r);
    EXPECT_EQ(result.counters.culledBackFace, 0u);
}

// A scene of the notes' fill by both sides: equal planes.
RenderResult drawnByBoth(const std::string& text) {
    const test::TemporaryFolder folder;
    std::ofstream(folder.path() / "notes.toml") << "handedness = \"left\"\nshading = \"unlit\"\nfill = \"notes\"\ncull = false\n" << text;
    Scene scene = loadScene({folder.path() / "notes.toml"}, {});
    completeScene(scene, scene.size, "", false);
    EXPECT_EQ(scene.fill, Fill::notes);
    RenderRequest r = request(Shading::unlit);
    r.width = scene.size.x;
    r.height = scene.size.y;
    r.planes = kEveryPlane;
    RenderResult twin = renderCpu(scene, r);
    expectSameFrame(twin.frame, renderGpu(*DeviceEnvironment::device(), scene, r).frame);
    return twin;
}
// Points (x, y) at Z = 0, where the notes' viewer changes nothing.
RenderResult plane(const std::string& faces) {
    return drawnByBoth(
        "size = [40, 40]\n[camera]\ndistance = 100\n[[mesh]]\nname = \"m\"\nvertices = [[-10, -10], [10, -10], [10, 0], [0, 0], [0, 10], "
        "[-10, 10], [10, 10]]\n"
        "faces = [" +
        faces + "]\n");
}
TEST(GoldenFill, ConvexFacesAreOnePolygonConcaveOnesTheirTrianglesAndCrossingOnesRefused) {
    const RenderResult square = plane("[0, 1, 6, 5]"), ell = plane("[0, 1, 2, 3, 4, 5]");
    EXPECT_EQ(square.counters.drawnTriangles, 1u);
    EXPECT_EQ(square.frame.coveredPixels, 21u * 21u) << "both ends of 20 pixels";
    EXPECT_GT(ell.counters.drawnTriangles, 1u);
    EXPECT_EQ(ell.counters.polygons, 1u);
    EXPECT_EQ(ell.frame.coveredPixels, 21u * 11u + 11u * 10u) << "an L without gap; shared edges are painted twice, seen once";
    EXPECT_THROW(plane("[0, 1, 5, 6]"), Error) << "a bow tie";
    EXPECT_THROW(plane("[0, 1]"), Error);
}

// Pixels of a row without a hole: each row of a convex body is one run.
size_t holes(const Frame& frame, uint32_t width) {
    size_t missing = 0;
    for (size_t row = 0; row < frame.object.size(); row += width) {
        const auto begin = frame.object.begin() + ptrdiff_t(row), end = begin + ptrdiff_t(width);
        const auto drawn = [](uint32_t o) { return o != kNone; };
        const auto first = std::find_if(begin, end, drawn);
        const auto last = std::find_if(std::reverse_iterator(end), std::reverse_iterator(first), drawn).base();
        missing += size_t(std::count(first, last, kNone));
    }
    return missing;
}
TEST(GoldenFill, NoHoleWhereAColumnPassesAPowerOfTwo) {
    const RenderResult triangle = drawnByBoth(
        "size = [640, 480]\n[camera]\ndistance = 500\n[[mesh]]\nname = \"t\"\nvertices = [[-66, 135], [-55, 128], [-64, 147]]\nfaces = "
        "[[0, 1, 2]]\n");
    EXPECT_EQ(holes(triangle.frame, 640), 0u);
    // Row 96 runs from exactly 255 1/2, which is column 256, to 257.42.
    for (const uint32_t column : {255, 256, 257, 258})
        EXPECT_EQ(triangle.frame.object[96 * 640 + column], column == 256 || column == 257 ? 0u : kNone) << column;
    for (const glm::uvec2 size : {glm::uvec2(320, 240), glm::uvec2(640, 480), glm::uvec2(1280, 960)}) {
        Scene scene = loadScene({PLUMB_SOURCE_DIR "/scenes/procedural/icosphere.ply"}, {});
        completeScene(scene, size, "", false);
        RenderRequest r = request(Shading::flat);
        r.width = size.x;
        r.height = size.y;
        r.planes = kEveryPlane;
        const RenderResult ball = renderCpu(scene, r);
        EXPECT_GT(ball.frame.coveredPixels, size.x * size.y / 4);
        EXPECT_EQ(holes(ball.frame, size.x), 0u) << size.x;
    }
}

// A line that starts left of the middle of a column and ends on one stops a step before its end: X runs LeftX, LeftX + 1, ... <= RightX. So a rectangle
// is not its two triangles: each row of the right one starts on the diagonal, X = 90 rows to 110 columns, and misses the right column where the
// fraction of X lies between 0 and 1/2. No row gains a pixel, and along the diagonal none is lost.
TEST(GoldenFill, ARectangleIsItsTwoTrianglesButForItsRightColumn) {
    const auto rectangle = [](int width, int height, const char* faces) {
        return drawnByBoth(fmt::format("size = [160, 120]\n[camera]\ndistance = 100\n[[mesh]]\nname = \"m\"\nvertices = [[-{0}, -{1}], "
                                       "[{0}, -{1}], [{0}, {1}], [-{0}, {1}]]\nfaces = {2}\n",
                                       width / 2, height / 2, faces))
            .frame;
    };
    const char *whole = "[[0, 1, 2, 3]]", *rising = "[[0, 1, 2], [0, 2, 3]]", *falling = "[[0, 1, 3], [1, 2, 3]]";
    const Frame one = rectangle(110, 90, whole);
    EXPECT_EQ(one.coveredPixels, 111u * 91u) << "both ends of 110 columns and 90 rows";
    for (const char* diagonal : {rising, falling}) {
        // Rows whose X on the diagonal, k 110 / 90 from the right or from the left, has a fraction above 0 and below 1/2.
        const bool fromLeft = diagonal == falling;
        uint64_t expected = 0;
        for (int row = 0; row <= 90; ++row) {
            const int rest = (fromLeft ? 110 * row : 110 * (90 - row)) % 90;
            expected += rest > 0 && 2 * rest < 90;
        }
        const Frame two = rectangle(110, 90, diagonal);
        EXPECT_EQ(one.coveredPixels - two.coveredPixels, expected);
        for (size_t i = 0; i < two.object.size(); ++i) {
            if (two.object[i] == one.object[i]) continue;
            ASSERT_EQ(one.object[i], 0u);
            ASSERT_EQ(i % 160, 80u + 55u) << "not in the right column";
        }
        EXPECT_EQ(rectangle(90, 90, diagonal).coveredPixels, 91u * 91u) << "a square's diagonal passes whole columns only";
    }
}

// A floor from before the viewer to far behind him: its corners lie up to 10^7 pixels away. Depth is that of the plane, but for corners rounded to whole
// pixels, which moves Z by half its slope at most (stability, whole pixels), and for rounding: 16 units of 2^-24 of the larger of d and Z.
TEST(GoldenFill, AFloorBehindTheViewerIsDrawnToTheCanvas) {
    constexpr double kDistance = 500, kBelow = 100;
    for (const double near : {1.0, 0.001}) {
        const RenderResult r =
            drawnByBoth(fmt::format("size = [320, 240]\n[camera]\ndistance = 500\nnear = {}\n[[mesh]]\nname = \"floor\"\nvertices = "
                                    "[[-3000, -100, -9000], [3000, -100, -9000], [3000, -100, 4000], [-3000, -100, 4000]]\n"
                                    "faces = [[0, 1, 2, 3]]\n",
                                    near));
        EXPECT_EQ(r.counters.drawnTriangles, 1u);
        size_t rows = 0;
        for (uint32_t y = 121; y < 240; ++y) {
            const double slope = kDistance * kDistance / (kDistance * kBelow);  // of Zps, a row
            const double zps = kDistance - slope * (double(y) - 120);
            if (zps > kDistance * (1 - kDistance / 4500) - slope) continue;  // beyond the far edge
            ++rows;
            for (uint32_t x = 0; x < 320; ++x) {
                ASSERT_EQ(r.frame.object[y * 320 + x], 0u) << x << ' ' << y;
                const double got = kDistance - kDistance * kDistance / double(r.frame.depth[y * 320 + x]);
                ASSERT_LE(std::abs(got - zps), slope / 2 + 16 * 0x1p-24 * std::max(kDistance, std::abs(zps))) << x << ' ' << y;
            }
        }
        EXPECT_GT(rows, 100u);
    }
}

TEST(GoldenFill, APolygonBehindTheViewerIsCutNotDivided) {  // erratum A11
    Scene scene = loadScene({PLUMB_SOURCE_DIR "/scenes/cylinder.toml"}, {});
    completeScene(scene, {400, 400}, "", false);
    scene.objects[0].worldFromObject[3].z -= 700;  // from before the viewer to behind him
    RenderRequest r = request(Shading::gouraud);
    r.planes = kEveryPlane;
    const RenderResult twin = renderCpu(scene, r);
    for (float depth : twin.frame.depth) EXPECT_GE(depth, float(0));
    expectSameFrame(twin.frame, renderGpu(*DeviceEnvironment::device(), scene, r).frame);
}

}  // namespace
}  // namespace plumb::golden
