// SPDX-License-Identifier: MIT
// `--fill notes` against the worked examples: coverage and counts exactly, X and Z within the file's float32 tolerance, on the device
// and by the twin (equal bytes).
#include "pipeline/render/render.h"
#include "pipeline/scene/load.h"
#include "tests/golden/golden.h"
#include "tests/support/temporary_folder.h"
#include "tests/twin/scanline_support.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <glm/glm.hpp>
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
    return {v[0].get<float>(), v[1].get<float>(), v.size() > 2 ? float(v[2].get<double>()) : 0.0f, {}};
}

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
    const Filled f =
        filled({cornerOf(table.input("A")), cornerOf(table.input("B")), cornerOf(table.input("C"))}, 40, 40);
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
    const Filled f =
        filled({cornerOf(corners.input("A")), cornerOf(corners.input("B1")), cornerOf(corners.input("B4"))}, 400, 400);
    ASSERT_EQ(f.lines.size(), rows.data("rows").size());
    size_t pixels = 0;
    for (size_t i = 0; i < f.lines.size(); ++i) {
        const Json& row = rows.data("rows")[i];
        EXPECT_TRUE(within(f.lines[i].leftX, row[1])) << row << f.lines[i].leftX;
        EXPECT_TRUE(within(f.lines[i].rightX, row[2])) << row << f.lines[i].rightX;
        EXPECT_TRUE(within(f.lines[i].leftZ, row[3])) << row << f.lines[i].leftZ;
        EXPECT_TRUE(within(f.lines[i].rightZ, row[4])) << row << f.lines[i].rightZ;
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
            polygon.back().carried =
                phong ? glm::vec3(vectorOf<glm::dvec3>(normals[i]))
                      : glm::vec3(float(lights[i][0].get<double>()), float(lights[i][1].get<double>()),
                                  float(lights[i][2].get<double>()));
        }
        const Filled f = filled(polygon, 400, 400);
        const int first = lines.data("corrected_switch")[0]["y"].get<int>();
        for (const Json& row : lines.data("corrected_switch")) {
            const int y = row["y"].get<int>();
            const gpu::ScanSpan& s = f.lines.at(size_t(y - first));
            EXPECT_TRUE(within(s.leftX, row["left"]["X"]) && within(s.rightX, row["right"]["X"])) << row;
            EXPECT_TRUE(within(s.leftZ, row["left"]["Z"]) && within(s.rightZ, row["right"]["Z"])) << row;
            const std::vector<uint32_t> columns = columnsOf(f.canvas, 400, y);
            EXPECT_EQ(columns.size(), row["pixel_count"].get<size_t>()) << "line " << y;
            for (const Json& pixel : row["pixels"]) {
                const size_t at = size_t(y) * 400 + columns.at(pixel[0].get<size_t>());
                EXPECT_TRUE(within(f.canvas.z[at], pixel[2])) << pixel << f.canvas.z[at];
                const glm::vec3 c = f.canvas.carried[at];
                if (!phong) {
                    EXPECT_TRUE(within(c.x + c.y + c.z, pixel[3])) << pixel;
                }
                const glm::dvec3 n = glm::normalize(glm::dvec3(c));
                for (int axis = 0; phong && axis < 3; ++axis)
                    EXPECT_TRUE(within(n[axis], pixel[4][size_t(axis)])) << pixel;
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
        const size_t corners = 2 + size_t(std::count_if(mesh.triangles.begin(), mesh.triangles.end(),
                                                        [&](const auto& t) { return t.face == face; }));
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

// A scene of the plane: points (x, y) at Z = 0, where the notes' viewer changes nothing.
RenderResult plane(const std::string& faces) {
    const test::TemporaryFolder folder;
    const std::string head =
        "handedness = \"left\"\nsize = [40, 40]\nshading = \"unlit\"\nfill = \"notes\"\ncull = "
        "false\n[camera]\ndistance = 100\n";
    std::ofstream(folder.path() / "plane.toml") << head
                                                << "[[mesh]]\nname = \"m\"\nvertices = [[-10, -10], [10, -10], [10, "
                                                   "0], [0, 0], [0, 10], [-10, 10], [10, 10]]\nfaces = ["
                                                << faces << "]\n";
    Scene scene = loadScene({folder.path() / "plane.toml"}, {});
    completeScene(scene, scene.size, "", false);
    RenderRequest r = request(Shading::unlit);
    r.width = r.height = 40;
    EXPECT_EQ(scene.fill, Fill::notes);
    RenderResult twin = renderCpu(scene, r);
    expectSameFrame(twin.frame, renderGpu(*DeviceEnvironment::device(), scene, r).frame);
    return twin;
}
TEST(GoldenFill, ConvexFacesAreOnePolygonConcaveOnesTheirTrianglesAndCrossingOnesRefused) {
    const RenderResult square = plane("[0, 1, 6, 5]"), ell = plane("[0, 1, 2, 3, 4, 5]");
    EXPECT_EQ(square.counters.drawnTriangles, 1u);
    EXPECT_EQ(square.frame.coveredPixels, 21u * 21u) << "both ends of 20 pixels";
    EXPECT_GT(ell.counters.drawnTriangles, 1u);
    EXPECT_EQ(ell.counters.polygons, 1u);
    EXPECT_EQ(ell.frame.coveredPixels, 21u * 11u + 11u * 10u)
        << "an L without gap; shared edges are painted twice, seen once";
    EXPECT_THROW(plane("[0, 1, 5, 6]"), Error) << "a bow tie";
    EXPECT_THROW(plane("[0, 1]"), Error);
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
