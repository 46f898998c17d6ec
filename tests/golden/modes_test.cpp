// SPDX-License-Identifier: MIT
// What the notes describe beside their numbers: properties of projection, filling and lighting that a picture must have, and the choices
// of section 3. Pictures come from both sides (equal bytes).
#include "pipeline/passes/transform.h"
#include "pipeline/render/prepare.h"
#include "pipeline/render/render.h"
#include "pipeline/scene/load.h"
#include "pipeline/transform/steps.h"
#include "pipeline/truth/truth.h"
#include "tests/golden/golden.h"
#include "tests/support/temporary_folder.h"
#include "tests/twin/scanline_support.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace plumb::golden {
namespace {

using namespace plumb::test;
using glm::dmat4;
using glm::dvec2;
using glm::dvec3;
using glm::dvec4;

std::string textOf(const std::string& scene) {
    std::ifstream file(PLUMB_SOURCE_DIR "/scenes/" + scene);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}
Scene sceneOf(const std::string& text, glm::uvec2 size = {400, 400}) {
    const TemporaryFolder folder;
    Scene scene = loadScene({folder.write("scene.toml", text)}, {});
    completeScene(scene, size, "", false);
    return scene;
}
std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}
RenderRequest requestOf(Shading shading, Fill fill, glm::uvec2 size = {400, 400}) {
    RenderRequest r;
    r.width = size.x;
    r.height = size.y;
    r.encoding = Encoding::linear;
    r.shading = shading;
    r.fill = fill;
    r.planes = kEveryPlane;
    return r;
}
// Device and twin, the same bytes.
RenderResult drawn(const Scene& scene, const RenderRequest& request) {
    RenderResult twin = renderCpu(scene, request);
    const RenderResult device = renderGpu(*DeviceEnvironment::device(), scene, request);
    expectSameFrame(twin.frame, device.frame);
    EXPECT_EQ(twin.counters.illuminations, device.counters.illuminations);
    EXPECT_EQ(twin.counters.culledBackFace, device.counters.culledBackFace);
    EXPECT_EQ(twin.counters.edges, device.counters.edges);
    expectNoValidationMessages(*DeviceEnvironment::device());
    return twin;
}
std::set<uint32_t> seenIn(const std::vector<uint32_t>& ids) {
    std::set<uint32_t> seen(ids.begin(), ids.end());
    seen.erase(kNone);
    return seen;
}

// Section 3: only end points are projected. Both ends and the point between are snapped to sub-pixels, sqrt(1/2) of one at most each, so the
// point is off the line by at most twice that; projecting costs less than an eighth of a sub-pixel (8 u of 2^17 sub-pixels, twice).
TEST(Modes, PointsInsideAnEdgeProjectOntoTheLineButNotAtTheSameShare) {
    const double kBound = 2 * std::sqrt(0.5) + 2 * 0x1p-3;  // sub-pixels
    const Scene scene = sceneOf(textOf("pyramid.toml"));
    const Prepared p = prepare(scene, requestOf(Shading::unlit, Fill::exact));
    Random r(11);
    size_t elsewhere = 0;
    for (int line = 0; line < 500; ++line) {
        const dvec3 a(r(-60, 60), r(-60, 60), r(1, 80)), b(r(-90, 90), r(-90, 90), r(100, 900));
        const double share = r(0.1, 0.9);
        const std::vector<glm::vec4> points = {glm::vec4(a, 1), glm::vec4(b, 1), glm::vec4(a + (b - a) * share, 1)};
        std::vector<gpu::ScreenVertex> screen(3);
        std::vector<glm::vec4> none(3);
        transformCpu({0, 0, 3, 0, p.list.viewport}, Normals::none, points, none, p.list.objects, screen, none, 1);
        for (const gpu::ScreenVertex& v : screen) ASSERT_EQ(v.outcode, 0u);
        const dvec2 from(screen[0].x, screen[0].y), along = dvec2(screen[1].x, screen[1].y) - from,
                                                    to = dvec2(screen[2].x, screen[2].y) - from;
        const double length = glm::length(along);
        if (length < gpu::kSubpixels) continue;
        EXPECT_LE(std::abs(along.x * to.y - along.y * to.x) / length, kBound);
        EXPECT_GT(screen[0].z, screen[2].z) << "Z keeps its order";
        EXPECT_GT(screen[2].z, screen[1].z);
        elsewhere += std::abs(glm::dot(along, to) / length - share * length) > kBound;
    }
    EXPECT_GT(elsewhere, 400u) << "C3: shares along a line change";
}

TEST(Modes, TheMidpointOfATransformedEdgeIsTheTransformedMidpoint) {
    const dvec3 a(1, -2, 5), b(7, 4, -3);
    // Whole numbers, eighths and quarter turns are exact.
    for (const Step3& step :
         {translateStep(dvec3(3, -8, 0.5)), scaleStep(dvec3(2, 0.25, -4)), rotateXStep(90), rotateYStep(180), rotateZStep(270)})
        EXPECT_EQ(transformed(step.matrix, (a + b) / 2.0), (transformed(step.matrix, a) + transformed(step.matrix, b)) / 2.0) << step.name;
    for (const Step3& step : {rotateXStep(33), rotateYStep(-71), rotateStep(glm::normalize(dvec3(1, 2, -2)), 50)}) {
        const dvec3 middle = transformed(step.matrix, (a + b) / 2.0),
                    mean = (transformed(step.matrix, a) + transformed(step.matrix, b)) / 2.0;
        for (int i = 0; i < 3; ++i)
            EXPECT_LE(std::abs(middle[i] - mean[i]), tolerance().binary64 * std::max(1.0, std::abs(mean[i]))) << step.name;
    }
}

// 12.1: the order of its corners says which side of a polygon is its front.
TEST(Modes, ReversingAPolygonFlipsItsVisibility) {
    const std::string text = textOf("pyramid.toml");
    for (const Fill fill : {Fill::exact, Fill::notes}) {
        const RenderRequest r = requestOf(Shading::flat, fill);
        EXPECT_EQ(seenIn(drawn(sceneOf(text), r).frame.primitive), (std::set<uint32_t>{0, 2, 3}));
        const RenderResult front = drawn(sceneOf(replaced(text, "[0, 1, 4]", "[4, 1, 0]")), r);
        EXPECT_FALSE(seenIn(front.frame.primitive).contains(0)) << "the reversed Front is seen from behind";
        const Scene back = sceneOf(replaced(text, "[0, 3, 2]", "[2, 3, 0]"));
        EXPECT_EQ(drawn(back, r).counters.culledBackFace + 1, drawn(sceneOf(text), r).counters.culledBackFace);
        // The reversed Back is seen through the hole when the Front is gone.
        const Scene both = sceneOf(replaced(replaced(text, "[0, 3, 2]", "[2, 3, 0]"), "[0, 1, 4]", "[4, 1, 0]"));
        EXPECT_TRUE(seenIn(drawn(both, r).frame.primitive).contains(1));
    }
}

// 13.1: edges with the same Ystart may stand in the table in any order. Each way around and each first corner makes another order of ties.
TEST(Modes, TiedEdgesOfTheFillTableInAnyOrderPaintTheSame) {
    const std::vector<std::vector<gpu::ScanCorner>> polygons = {
        {{20, 3, 5, {1, 0, 0}}, {33, 21, 50, {0, 1, 0}}, {4, 30, 90, {0, 0, 1}}},
        {{10, 5, 7, {1, 0, 0}}, {30, 5, 8, {0, 1, 0}}, {30, 25, 9, {0, 0, 1}}, {10, 25, 10, {1, 1, 0}}},
        {{18, 2, 1, {1, 0, 0}},
         {30, 10, 2, {0, 1, 0}},
         {31, 24, 3, {0, 0, 1}},
         {18, 36, 4, {1, 1, 0}},
         {6, 24, 5, {1, 0, 1}},
         {5, 10, 6, {0, 1, 1}}}};
    for (const auto& polygon : polygons) {
        std::optional<ScanCanvas> first;
        for (size_t turn = 0; turn < 2 * polygon.size(); ++turn) {
            std::vector<gpu::ScanCorner> corners = polygon;
            if (turn >= polygon.size()) std::reverse(corners.begin(), corners.end());
            std::rotate(corners.begin(), corners.begin() + ptrdiff_t(turn % polygon.size()), corners.end());
            ScanList list;
            list.width = list.height = 40;
            ASSERT_TRUE(list.add(corners));
            const ScanCanvas canvas = sameOnBothSides(list, nullptr);
            if (!first) first = canvas;
            expectSamePlane("owner", 40, 1, first->owner, canvas.owner);
            expectSamePlane("Z", 40, 1, first->z, canvas.z);
        }
        EXPECT_LT(std::count(first->owner.begin(), first->owner.end(), gpu::kNoPolygon), 40 * 40);
    }
}

// 14.1: two triangles through each other show the line in which they meet: the planes Z = 100 + X/4 + Y/8 and Z = 100 - X/8 + Y/4 meet where
// Y = 3 X, which the screen shows as Yps = 3 Xps. Pixels on it are a tie, all others differ by 1/8 in Z or more, far above rounding.
std::string crossing(bool swapped) {
    const auto mesh = [](const char* name, double perX, double perY) {
        std::string corners;
        for (const dvec2& p : {dvec2(-300, -300), dvec2(900, -300), dvec2(-300, 900)})
            corners += fmt::format("[{}, {}, {}],", p.x, p.y, 100 + perX * p.x + perY * p.y);
        return fmt::format("[[mesh]]\nname = '{}'\nvertices = [{}]\nfaces = [[0, 1, 2]]\n", name, corners);
    };
    const auto object = [](const char* name) { return fmt::format("[[object]]\nmesh = '{}'\n", name); };
    return "handedness = 'left'\ncull = false\n[camera]\ndistance = 256\nnear = 1\n" + mesh("a", 0.25, 0.125) + mesh("b", -0.125, 0.25) +
           (swapped ? object("b") + object("a") : object("a") + object("b"));
}
TEST(Modes, IntersectingTrianglesShowTheirLineInAnyDrawingOrder) {
    // The notes round corners to whole pixels: each plane moves by sqrt(1/2) of a pixel at most, and with gradients gA and gB their line by
    // (|gA| + |gB|) sqrt(1/2) / |gA - gB|.
    const dvec2 gA(0.25, 0.125), gB(-0.125, 0.25);
    const double moved = (glm::length(gA) + glm::length(gB)) * std::sqrt(0.5) / glm::length(gA - gB);
    for (const Fill fill : {Fill::exact, Fill::notes})
        for (const bool swapped : {false, true}) {
            const glm::uvec2 size(200, 160);
            const Frame frame = drawn(sceneOf(crossing(swapped), size), requestOf(Shading::unlit, fill, size)).frame;
            size_t judged = 0;
            for (uint32_t y = 0; y < size.y; ++y)
                for (uint32_t x = 0; x < size.x; ++x) {
                    const double centre = fill == Fill::exact ? 0.5 : 0;
                    const double side = 3 * (double(x) + centre - 100) - (80 - double(y) - centre);  // below 0: a is nearer
                    if (fill == Fill::exact ? side == 0 : std::abs(side) / std::sqrt(10) <= moved) continue;
                    ++judged;
                    ASSERT_EQ(frame.object[y * size.x + x], (side < 0) != swapped ? 0u : 1u) << x << ' ' << y << " fill " << int(fill);
                }
            EXPECT_GT(judged, size.x * size.y * 9 / 10);
        }
}

// Section 2 and 12.4: the pyramid's 16 edges drawn polygon by polygon, its 8 edges, the 7 of the polygons that are seen.
TEST(Modes, AWireFrameHasTheEdgesThatItIsAskedFor) {
    const Scene scene = sceneOf(textOf("pyramid.toml"));
    RenderRequest r = requestOf(Shading::wire, Fill::exact);
    r.planes = kPlaneColour | kPlaneObject;
    const auto with = [&](WireView view, bool perPolygon) {
        r.wire = view;
        r.wirePerPolygon = perPolygon;
        return drawn(scene, r);
    };
    const RenderResult once = with(WireView::seeThrough, false), polygons = with(WireView::seeThrough, true),
                       culled = with(WireView::culled, false), culledPolygons = with(WireView::culled, true),
                       solid = with(WireView::solid, false);
    EXPECT_EQ(once.counters.edges, 8u);
    EXPECT_EQ(polygons.counters.edges, 16u);
    EXPECT_EQ(culled.counters.edges, 7u) << "all but B2-B3, which only Back and Base have";
    EXPECT_EQ(culledPolygons.counters.edges, 9u) << "Front, Left and Right";
    expectSamePlane("drawing an edge twice changes no pixel", 400, 1, once.frame.rgba, polygons.frame.rgba);
    expectSamePlane("drawing an edge twice changes no pixel", 400, 1, culled.frame.rgba, culledPolygons.frame.rgba);
    EXPECT_LT(culled.frame.coveredPixels, once.frame.coveredPixels);
    // One convex object: what is not hidden are the edges of its front faces. Nothing else is drawn, and what is missing of them is at a corner,
    // where a pixel of one edge may lie on the other side of another.
    size_t missing = 0;
    for (size_t i = 0; i < solid.frame.rgba.size(); ++i) {
        const bool visible = culled.frame.object[i] != kNone, shown = solid.frame.object[i] != kNone;
        missing += visible && !shown;
        EXPECT_FALSE(shown && !visible) << i % 400 << ' ' << i / 400;
    }
    EXPECT_EQ(missing, 0u);
}

std::string twoCards(bool swapped) {
    const auto card = [](const char* name, double half, double z) {
        return fmt::format(
            "[[mesh]]\nname = '{0}'\nvertices = [[-{1}, -{1}, {2}], [-{1}, {1}, {2}], [{1}, {1}, {2}], [{1}, -{1}, "
            "{2}]]\nfaces = [[0, 1, 2, 3]]\n",
            name, half, z);
    };
    const auto object = [](const char* name) {
        return fmt::format("[[object]]\nname = '{0}'\nmesh = '{0}'\ntransform = [{{ rotate_z = 20 }}]\n", name);
    };
    return "handedness = 'left'\n[camera]\ndistance = 256\nnear = 1\n" + card("near", 50, 10) + card("far", 50.25, 60) +
           card("wide", 90, 200) +
           (swapped ? object("wide") + object("far") + object("near") : object("near") + object("far") + object("wide"));
}
TEST(Modes, HiddenLinesAreNotDrawnWhateverTheOrder) {
    const glm::uvec2 size(200, 160);
    std::vector<std::vector<uint8_t>> shown;
    for (const bool swapped : {false, true})
        for (const uint32_t samples : {1u, 4u}) {
            RenderRequest r = requestOf(Shading::wire, Fill::exact, size);
            r.planes = kPlaneColour | kPlaneObject | kPlaneLinear;
            r.samples = samples;
            const Scene scene = sceneOf(twoCards(swapped), size);
            const uint64_t all = drawn(scene, r).frame.coveredPixels;
            r.wire = WireView::solid;
            const Frame frame = drawn(scene, r).frame;
            EXPECT_LT(frame.coveredPixels, all);
            r.knobs.bandRows = 7;
            r.knobs.chunkTriangles = 1;
            expectSameFrame(frame, drawn(scene, r).frame);
            if (samples != 1) continue;
            std::vector<uint8_t> covered;
            std::map<uint32_t, size_t> pixels;
            for (const uint32_t id : frame.object) {
                covered.push_back(id != kNone);
                if (id != kNone) ++pixels[swapped ? 2 - id : id];
            }
            EXPECT_FALSE(pixels.contains(1)) << "the far card is behind the near one";
            EXPECT_GT(pixels[0], 300u) << "four sides of the near card";
            EXPECT_GT(pixels[2], 300u) << "the wide one is seen around it";
            shown.push_back(covered);
        }
    EXPECT_EQ(shown[0], shown[1]) << "the order of drawing changes no pixel";
}

// Section 3: with the viewer infinitely far away the vector toward it is (0, 0, -1) everywhere.
double largestDifference(const Frame& a, const Frame& b) {
    float most = 0;
    for (size_t i = 0; i < a.linear.size(); ++i) most = std::max(most, std::abs(a.linear[i] - b.linear[i]));
    return double(most);
}
TEST(Modes, ADistantViewerIsTheLimitOfOneFarAway) {
    for (const auto& [fill, shading] : {std::pair(Fill::exact, Shading::flat), std::pair(Fill::exact, Shading::gouraud),
                                        std::pair(Fill::exact, Shading::phong), std::pair(Fill::notes, Shading::phong)}) {
        double before = INFINITY;
        for (const double d : {500.0, 5000.0}) {
            Scene scene = sceneOf(replaced(textOf("cylinder.toml"), "distance = 500", fmt::format("distance = {}", d)));
            scene.cullBackFaces = fill == Fill::exact;  // the notes' culling has a test of its own
            RenderRequest r = requestOf(shading, fill);
            const Frame local = drawn(scene, r).frame;
            r.distantViewer = true;
            const Frame distant = drawn(scene, r).frame;
            expectSamePlane("what is seen", 400, 1, local.primitive, distant.primitive);
            const double difference = largestDifference(local, distant);
            EXPECT_GT(difference, 0) << "the choice changes something";
            EXPECT_LT(difference, before / 5) << "ten times as far away: about a tenth";
            before = difference;
        }
    }
}
TEST(Modes, ADistantViewerSeesThePolygonsOfAFarOne) {
    const auto seen = [](const std::string& text, bool distant) {
        RenderRequest r = requestOf(Shading::flat, Fill::notes);
        r.distantViewer = distant;
        const RenderResult result = drawn(sceneOf(text), r);
        return std::pair(result.counters.culledBackFace, seenIn(result.frame.primitive));
    };
    const std::string cylinder = textOf("cylinder.toml"), far = replaced(cylinder, "distance = 500", "distance = 4194304");
    EXPECT_EQ(seen(far, true), seen(far, false));
    // The pyramid's Left and Right are edge-on to the distant viewer, and edge-on is not visible.
    const std::string pyramid = textOf("pyramid.toml");
    EXPECT_EQ(seen(pyramid, false).second, (std::set<uint32_t>{0, 2, 3}));
    EXPECT_EQ(seen(pyramid, true).second, (std::set<uint32_t>{0}));
}

// 15.1: an area source is k points. Every light adds I k (its share, rounded), a product and a sum, each within u of what is there so far.
TEST(Modes, AnAreaLightIsItsPoints) {
    const std::string scene = textOf("lamp-and-occluder.toml");
    const glm::uvec2 size(160, 120);
    const size_t begin = scene.find("[[light]]"), end = scene.find("[[material]]");
    const auto with = [&](const std::string& lights) { return sceneOf(scene.substr(0, begin) + lights + scene.substr(end), size); };
    const auto line = [](const std::string& rest) {
        return "[[light]]\ntype = 'area'\nposition = [-1, 4, 0.5]\nedge_u = [4, 0, 0]\nintensity = 2\nattenuation = "
               "'1/d^2'\n" +
               rest + "\n";
    };
    const auto point = [](double x, double intensity) {
        return fmt::format("[[light]]\ntype = 'point'\nposition = [{}, 4, 0.5]\nintensity = {}\nattenuation = '1/d^2'\n", x, intensity);
    };
    for (const Shading shading : {Shading::phong, Shading::ray}) {
        RenderRequest r = requestOf(shading, Fill::exact, size);
        if (shading == Shading::ray) r.planes &= ~uint32_t(kPlaneTriangle);
        const Frame area = drawn(with(line("points = 4")), r).frame;
        expectSameFrame(area, drawn(with(point(-0.5, 0.5) + point(0.5, 0.5) + point(1.5, 0.5) + point(2.5, 0.5)), r).frame);
        std::string coincident;
        constexpr int kCoincident = 16;
        for (int i = 0; i < kCoincident; ++i) coincident += point(1, 2.0 / kCoincident);
        const Frame one = drawn(with(point(1, 2)), r).frame, many = drawn(with(coincident), r).frame;
        for (size_t i = 0; i < one.linear.size(); ++i)
            ASSERT_LE(std::abs(one.linear[i] - many.linear[i]), (kCoincident + 4) * 0x1p-24f * one.linear[i]);
        EXPECT_GT(largestDifference(one, area), 0) << "a lamp of four units is no point";
    }
}

// 16.5: no shadows in a raster picture. Without the card no floor pixel changes; rays show the shadow, and the lamp's points a soft rim.
TEST(Modes, ALampBehindAnOccluderLightsTheFloorUnlessRaysAreSent) {
    const std::string text = textOf("lamp-and-occluder.toml");
    const glm::uvec2 size(160, 120);
    const Scene with = sceneOf(text, size);
    Scene without = with;
    without.objects.resize(1);
    const auto floors = [&](Shading shading) {
        RenderRequest r = requestOf(shading, Fill::exact, size);
        if (shading == Shading::ray) r.planes &= ~uint32_t(kPlaneTriangle);
        const Frame a = drawn(with, r).frame, b = drawn(without, r).frame;
        std::set<float> shares;
        size_t differing = 0;
        for (size_t i = 0; i < a.object.size(); ++i)
            if (a.object[i] == 0) {
                differing += a.rgba[i] != b.rgba[i];
                shares.insert(std::round(16 * (a.linear[3 * i] - 0.06f) / (b.linear[3 * i] - 0.06f)));  // Ka Ia of the floor is 0.06
            }
        return std::pair(differing, shares);
    };
    EXPECT_EQ(floors(Shading::phong).first, 0u) << "stated: the raster picture shows no shadow";
    const auto [differing, shares] = floors(Shading::ray);
    EXPECT_GT(differing, 200u);
    EXPECT_TRUE(shares.contains(0) && shares.contains(16)) << "umbra and full light";
    EXPECT_GT(shares.size(), 6u) << "and a penumbra between them";
}

// 17: flat, Gouraud and Phong against the true cylinder, of which the octagon is an approximation. Root mean squares over the pixels in which both
// show the mantle, and illuminations.
struct ShadingError {
    double rms = 0;
    uint64_t cost = 0;
};
std::vector<ShadingError> errorsAgainstTheCylinder(const Scene& scene) {
    const dmat4 world = scene.objects[0].worldFromObject, object = glm::inverse(world);
    const double radius2 = 50 * 50 + 120.71067811865474 * 120.71067811865474;
    const Material& m = scene.materials[scene.meshes[0].faceMaterial[0]];
    const dvec3 toLight = glm::normalize(scene.lights[0].direction);
    // The mantle that the ray meets first, lit by the model of 16.5 in binary64.
    const auto truth = [&](double px, double py) -> std::optional<dvec3> {
        const dvec3 eye(0, 0, -500), ray(px - 200, 200 - py, 500);
        const dvec3 o(object * dvec4(eye, 1)), d(object * dvec4(ray, 0));
        const double a = d.x * d.x + d.y * d.y, b = o.x * d.x + o.y * d.y, c = o.x * o.x + o.y * o.y - radius2;
        const double root = b * b - a * c;
        if (!(root > 0)) return std::nullopt;
        const double t = (-b - std::sqrt(root)) / a;
        const dvec3 hit = o + d * t;
        if (hit.z < 50 || hit.z > 450) return std::nullopt;
        const dvec3 n = glm::normalize(dvec3(world * dvec4(hit.x, hit.y, 0, 0))), v = glm::normalize(-ray);
        const double nl = glm::dot(n, toLight), rv = glm::dot(2 * nl * n - toLight, v);
        const dvec3 lit = nl > 0 ? dvec3(m.diffuse) * nl + dvec3(m.specular) * std::pow(std::max(0.0, rv), double(m.shininess)) : dvec3(0);
        return dvec3(m.ambient) * dvec3(scene.ambient) + dvec3(scene.lights[0].intensity) * lit;
    };
    std::vector<ShadingError> errors;
    for (const Shading shading : {Shading::flat, Shading::gouraud, Shading::phong}) {
        const RenderResult result = drawn(scene, requestOf(shading, Fill::exact));
        double sum = 0;
        size_t count = 0;
        for (uint32_t y = 0; y < 400; ++y)
            for (uint32_t x = 0; x < 400; ++x) {
                const size_t at = y * 400 + x;
                const std::optional<dvec3> want = truth(x + 0.5, y + 0.5);
                if (!want || result.frame.primitive[at] >= 8) continue;  // a cap, or nothing, on one of the two
                for (int i = 0; i < 3; ++i) sum += std::pow(double(result.frame.linear[3 * at + size_t(i)]) - (*want)[i], 2);
                count += 3;
            }
        EXPECT_GT(count, 30000u);
        errors.push_back({std::sqrt(sum / double(count)), result.counters.illuminations});
    }
    std::printf("rms error against the cylinder: flat %.4f, Gouraud %.4f, Phong %.4f; illuminations %lu, %lu, %lu\n", errors[0].rms,
                errors[1].rms, errors[2].rms, static_cast<unsigned long>(errors[0].cost), static_cast<unsigned long>(errors[1].cost),
                static_cast<unsigned long>(errors[2].cost));
    return errors;
}
TEST(Modes, ErrorAndCostOfFlatGouraudAndPhongAreOrderedAgainstTheAnalyticCylinder) {
    Scene scene = sceneOf(textOf("cylinder.toml"));
    const std::vector<ShadingError> shining = errorsAgainstTheCylinder(scene);
    for (Material& m : scene.materials) m.specular = glm::vec3(0);
    const std::vector<ShadingError> matt = errorsAgainstTheCylinder(scene);
    for (const auto& e : {shining, matt}) {
        EXPECT_LT(e[0].cost, e[1].cost);
        EXPECT_LT(e[1].cost, e[2].cost);
        EXPECT_LT(e[2].rms, std::min(e[0].rms, e[1].rms));
        EXPECT_GT(e[2].rms, 0) << "an octagon is no circle";
    }
    // A matt surface has the order of the notes.
    EXPECT_GT(matt[0].rms, matt[1].rms);
    // A highlight does not: eight corners around miss or smear it (17.2), and one colour a face can be nearer than that.
    EXPECT_GT(shining[1].rms, matt[1].rms);
}

// Section 2: vertices are shared, so that moving the top A moves the four faces that meet there, and not the Base.
TEST(Modes, MovingOneVertexMovesEveryFaceThatHasIt) {
    const std::string text = textOf("pyramid.toml");
    const TriangleMesh before = sceneOf(text).meshes[0], after = sceneOf(replaced(text, "[  0, -100, 100]", "[  0, -90, 100]")).meshes[0];
    ASSERT_EQ(before.faceCentre.size(), 5u);
    for (size_t face = 0; face < 5; ++face) {
        EXPECT_EQ(before.faceCentre[face] != after.faceCentre[face], face < 4) << face;
        EXPECT_EQ(before.faceNormal[face] != after.faceNormal[face], face < 4) << face;
    }
    EXPECT_EQ(before.edges.size(), after.edges.size()) << "nothing comes apart";
}

// 9.1: Z reversed in scene, light and viewer, and the polygons listed the other way around, is the same picture in the other system.
TEST(Modes, TheOtherHandednessWithZReversedIsTheSamePicture) {
    const auto pyramid = [](bool left) {
        const int s = left ? 1 : -1;
        std::string text = fmt::format(
            "handedness = '{}'\nsize = [200, 160]\n[camera]\neye = [40, -60, {}]\nat = [0, -130, {}]\nup = [0, 1, 0]\n"
            "[[light]]\ntype = 'directional'\ndirection = [1, 1, {}]\n[[light]]\ntype = 'point'\nposition = [80, 0, "
            "{}]\n"
            "[[mesh]]\nname = 'pyramid'\ncrease = 30\nvertices = [[0, -100, {}], [50, -150, {}], [50, -150, {}], [-50, "
            "-150, {}], [-50, -150, {}]]\n",
            left ? "left" : "right", -200 * s, 100 * s, -s, -150 * s, 100 * s, 50 * s, 150 * s, 150 * s, 50 * s);
        return sceneOf(text + (left ? "faces = [[0, 1, 4], [0, 3, 2], [0, 4, 3], [0, 2, 1], [1, 2, 3, 4]]\n"
                                    : "faces = [[0, 4, 1], [0, 2, 3], [0, 3, 4], [0, 1, 2], [1, 4, 3, 2]]\n"),
                       {200, 160});
    };
    for (const Fill fill : {Fill::exact, Fill::notes}) {
        const RenderRequest r = requestOf(Shading::phong, fill, {200, 160});
        const Frame left = drawn(pyramid(true), r).frame, right = drawn(pyramid(false), r).frame;
        EXPECT_EQ(left.primitive, right.primitive);
        EXPECT_EQ(left.coveredPixels, right.coveredPixels);
        EXPECT_GT(left.coveredPixels, 1000u);
        EXPECT_EQ(largestDifference(left, right), 0);
    }
}

// 16.4: a viewer elsewhere is the scene moved the other way. Half turns change signs and nothing else, so they change no bit.
TEST(Modes, ATurnedCameraIsTheSceneTurnedTheOtherWay) {
    const auto turned = [](int x, int y, int z, const char* step) {  // signs of the half turn
        return sceneOf(fmt::format("handedness = 'left'\nup = [0, {1}, 0]\n[camera]\neye = [{3}, {4}, {5}]\nat = [0, {6}, {7}]\nnear = 1\n"
                                   "[[light]]\ntype = 'directional'\ndirection = [{0}, {1}, {2}]\n[[light]]\ntype = 'point'\nposition = "
                                   "[{8}, {9}, {10}]\n"
                                   "[[material]]\nname = 'm'\nspecular = 0.5\n[[mesh]]\nname = 'p'\ncrease = 30\nmaterial = 'm'\n"
                                   "vertices = [[0, -100, 100], [50, -150, 50], [50, -150, 150], [-50, -150, 150], [-50, -150, 50]]\n"
                                   "faces = [[0, 1, 4], [0, 3, 2], [0, 4, 3], [0, 2, 1], [1, 2, 3, 4]]\n[[object]]\nmesh = 'p'\ntransform "
                                   "= [{11}]\n",
                                   x, y, -z, 40 * x, -60 * y, -200 * z, -130 * y, 100 * z, 80 * x, 10 * y, -150 * z, step),
                       {200, 160});
    };
    for (const Fill fill : {Fill::exact, Fill::notes}) {
        RenderRequest r = requestOf(Shading::phong, fill, {200, 160});
        r.planes &= ~uint32_t(kPlaneNormal);  // in world axes, which turn
        const Frame frame = drawn(turned(1, 1, 1, ""), r).frame;
        EXPECT_GT(frame.coveredPixels, 1000u);
        expectSameFrame(frame, drawn(turned(1, -1, -1, "{ rotate_x = 180 }"), r).frame);
        expectSameFrame(frame, drawn(turned(-1, 1, -1, "{ rotate_y = 180 }"), r).frame);
        expectSameFrame(frame, drawn(turned(-1, -1, 1, "{ rotate_z = 180 }"), r).frame);
        EXPECT_NE(frame.rgba, drawn(turned(1, 1, 1, "{ rotate_y = 180 }"), r).frame.rgba);
    }
}

// 16.3: a point source that recedes becomes a directional one.
TEST(Modes, APointLightFarAwayIsADirectionalOne) {
    const std::string text = textOf("cylinder.toml");
    const std::string lamp = "type = \"directional\"\ndirection = [1, 1, -1]";
    const Frame directional = drawn(sceneOf(text), requestOf(Shading::phong, Fill::exact)).frame;
    double before = INFINITY;
    for (const double away : {1e4, 1e5, 1e6}) {
        const std::string point = fmt::format("type = \"point\"\nposition = [{0}, {0}, -{0}]", away);
        const Frame frame = drawn(sceneOf(replaced(text, lamp, point)), requestOf(Shading::phong, Fill::exact)).frame;
        const double difference = largestDifference(directional, frame);
        EXPECT_GT(difference, 0);
        EXPECT_LT(difference, before / 5) << "ten times as far away: about a tenth";
        before = difference;
    }
}

// 16.4: with index 0 the highlight is everywhere where there is light; it shrinks as the index rises, and never becomes a mirror.
TEST(Modes, TheHighlightShrinksAsTheIndexRises) {
    Scene scene = sceneOf(textOf("notes-20-spheres.toml"), {800, 600});
    RenderRequest r = requestOf(Shading::phong, Fill::notes, {800, 600});
    const auto bright = [&](uint32_t sphere) {  // pixels with half the highlight or more, which red alone carries
        const Frame frame = drawn(scene, r).frame;
        const Material& m = scene.materials[scene.spheres[sphere].material];
        size_t count = 0;
        for (size_t i = 0; i < frame.object.size(); ++i)
            count += frame.object[i] == sphere && frame.linear[3 * i] >= 0.5f * m.specular.r * scene.lights[0].intensity.r;
        return count;
    };
    size_t before = 7845;
    for (const uint32_t row : {0u, 1u, 2u, 3u}) {  // 2, 4, 8, 16
        const size_t count = bright(5 * row);
        EXPECT_LT(count, before) << row;
        before = count;
    }
    EXPECT_GT(before, 0u);
    scene.materials[scene.spheres[0].material].shininess = 1e6f;
    const size_t least = bright(0);
    EXPECT_LT(least, before);
    scene.materials[scene.spheres[0].material].shininess = 0;
    const Frame frame = drawn(scene, r).frame;
    std::set<float> reds;
    for (size_t i = 0; i < frame.object.size(); ++i)
        if (frame.object[i] == 0) reds.insert(frame.linear[3 * i]);
    EXPECT_EQ(reds.size(), 2u) << "all of Ip Ks, or nothing where the surface looks away (A13)";
    EXPECT_EQ(*reds.begin(), 0.0f);
}

// 16.5: grey light on grey surfaces is the same in each channel, and sources may stand in any order: four positive terms added to a fifth
// in one order and the other, four roundings of at most u of the sum each.
TEST(Modes, GreyIsMonoAndSourcesMayStandInAnyOrder) {
    const std::string text = textOf("lamp-and-occluder.toml");
    const glm::uvec2 size(160, 120);
    Scene scene = sceneOf(text, size);
    scene.lights.clear();
    for (int i = 0; i < 4; ++i) {
        Light light;
        light.directional = i % 2 == 0;
        light.direction = dvec3(i - 2, 3, 1);
        light.position = dvec3(i - 2, 4, 1);
        light.intensity = glm::vec3(0.3f + 0.1f * float(i));
        light.attenuation = i < 2 ? Attenuation::none : Attenuation::inverse;
        scene.lights.push_back(light);
    }
    Scene grey = scene, turned = scene;
    for (Material& m : grey.materials)
        for (glm::vec3* colour : {&m.ambient, &m.diffuse, &m.specular, &m.emission}) *colour = glm::vec3(colour->g);
    std::reverse(turned.lights.begin(), turned.lights.end());
    for (const Fill fill : {Fill::exact, Fill::notes}) {
        const RenderRequest r = requestOf(Shading::phong, fill, size);
        const Frame mono = drawn(grey, r).frame, colour = drawn(scene, r).frame, other = drawn(turned, r).frame;
        for (size_t i = 0; i < mono.object.size(); ++i) {
            ASSERT_EQ(mono.linear[3 * i], mono.linear[3 * i + 1]);
            ASSERT_EQ(mono.linear[3 * i], mono.linear[3 * i + 2]);
            ASSERT_EQ(mono.linear[3 * i], colour.linear[3 * i + 1]) << "the channels do not meet";
        }
        for (size_t i = 0; i < colour.linear.size(); ++i)
            ASSERT_LE(std::abs(colour.linear[i] - other.linear[i]), 2 * 4 * 0x1p-24f * colour.linear[i]);
        EXPECT_GT(largestDifference(colour, mono), 0);
    }
}

// Samples of --fill notes are pixels of a larger canvas.
TEST(Modes, SamplesOfTheNotesFillAreALargerCanvas) {
    for (const uint32_t side : {2u, 4u}) {
        Scene scene = sceneOf(textOf("cylinder.toml"));
        RenderRequest r = requestOf(Shading::phong, Fill::notes, {200, 150});
        r.samples = side * side;
        scene.camera->focalPixels = 250;
        const Frame small = drawn(scene, r).frame;
        scene.camera->focalPixels = 250.0 * side;
        const Frame large = drawn(scene, requestOf(Shading::phong, Fill::notes, {200 * side, 150 * side})).frame;
        // side^2 additions of values up to the mean times their number, and a product: within (side^2 + 1) u of the mean.
        for (uint32_t y = 0; y < 150; ++y)
            for (uint32_t x = 0; x < 200; ++x) {
                const size_t at = y * 200 + x, middle = (size_t(y) * side + side / 2) * 200 * side + x * side + side / 2;
                ASSERT_EQ(small.primitive[at], large.primitive[middle]);
                ASSERT_EQ(small.depth[at], large.depth[middle]);
                for (size_t c = 0; c < 3; ++c) {
                    double mean = 0;
                    for (uint32_t k = 0; k < side * side; ++k)
                        mean += double(large.linear[3 * ((size_t(y) * side + k / side) * 200 * side + x * side + k % side) + c]) /
                                (side * side);
                    ASSERT_LE(std::abs(double(small.linear[3 * at + c]) - mean), (side * side + 1) * 0x1p-24 * mean);
                }
            }
    }
}

// What --with-error compares --fill notes with: the notes sample whole coordinates, so their truth is that of a picture whose things lie half a
// pixel to the right and below, sampled in the middle of pixels. In the plane of the screen half a pixel is half a unit.
TEST(Modes, TheTruthOfTheNotesFillIsSampledAtWholeCoordinates) {
    const auto plane = [](double dx, double dy) {
        return sceneOf(fmt::format("handedness = 'left'\ncull = false\n[camera]\ndistance = 100\n[[mesh]]\nname = "
                                   "'m'\nvertices = [[-10, -9], [12, -4], [3, 11]]\nfaces = [[0, 1, 2]]\n"
                                   "[[object]]\nmesh = 'm'\ntransform = [{{ translate = [{}, {}, 0] }}]\n",
                                   dx, dy),
                       {40, 30});
    };
    const Truth notes = truthOf(plane(0, 0), requestOf(Shading::phong, Fill::notes, {40, 30})),
                exact = truthOf(plane(0.5, -0.5), requestOf(Shading::phong, Fill::exact, {40, 30})),
                unmoved = truthOf(plane(0, 0), requestOf(Shading::phong, Fill::exact, {40, 30}));
    EXPECT_EQ(notes.primitive, exact.primitive);
    EXPECT_NE(notes.primitive, unmoved.primitive);
}

}  // namespace
}  // namespace plumb::golden
