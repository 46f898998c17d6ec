// SPDX-License-Identifier: MIT
// The truth of generated shapes. A sphere against the truth of rays at a [[sphere]], which shares no line with it; a cylinder and the teapot against
// their own polygons, ever more of them. And what the notes say in section 17: more and smaller polygons come closer to the surface, as 1/n^2.
#include "pipeline/detail/detail.h"
#include "pipeline/render/render.h"
#include "pipeline/scene/shape.h"
#include "pipeline/truth/frame_error.h"
#include "pipeline/truth/truth.h"
#include "tests/support/scenes.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace plumb::test {
namespace {

constexpr uint32_t kWidth = 160, kHeight = 120;

void addShape(Scene& s, const GeneratedShape& shape, const glm::dmat4& worldFromObject, uint32_t material) {
    std::vector<Material> none;
    TriangleMesh mesh = finishMesh(polygonsOf(shape), none, material, {});
    mesh.shape = std::make_shared<GeneratedShape>(shape);
    addObject(s, std::move(mesh));
    s.objects.back().worldFromObject = worldFromObject;
}

RenderRequest request() {
    RenderRequest r;
    r.width = kWidth;
    r.height = kHeight;
    r.planes |= kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive;
    return r;
}

// Both sides are binary64 from the definition; the exponent of a highlight multiplies what its base is off by.
double colourSlack(const Scene& s) {
    double exponent = 1;
    for (const Material& m : s.materials) exponent = std::max(exponent, double(m.shininess));
    return exponent * 0x1p-53 * 0x1p12;
}

TEST(SolidsTruth, ASphereIsThatOfTheRays) {
    Random r(5);
    uint64_t compared = 0;
    for (int round = 0; round < 6; ++round) {
        Scene solid = litScene(), traced = litScene();
        for (Scene* s : {&solid, &traced}) {
            s->cullBackFaces = true;
            s->shadows = false;
            s->maxDepth = 1;
        }
        for (uint32_t i = 0; i < 5; ++i) {
            const double radius = r(0.2, 1.2);
            const glm::dvec3 centre(r(-1.5, 1.5), r(-1, 1), r(-6, -2.5));
            addShape(solid, {ShapeKind::sphere, 1, 0, 4},
                     glm::translate(glm::dmat4(1), centre) * glm::scale(glm::dmat4(1), glm::dvec3(radius)), i % 3);
            traced.spheres.push_back({"", centre, radius, i % 3, ""});
        }
        RenderRequest raster = request(), rays = request();
        rays.shading = Shading::ray;
        const Truth a = truthOf(solid, raster), b = truthOf(traced, rays);
        EXPECT_EQ(a.undecided, 0u);
        for (size_t at = 0; at < a.object.size(); ++at) {
            ASSERT_EQ(a.object[at], b.object[at]) << at;
            if (a.object[at] == kNone) continue;
            ++compared;
            ASSERT_EQ(a.primitive[at], kNone) << "a body has no faces";
            ASSERT_LE(std::abs(a.depth[at] - b.depth[at]), b.depth[at] * 0x1p-40);
            for (size_t c = 0; c < 3; ++c) ASSERT_LE(std::abs(a.linear[3 * at + c] - b.linear[3 * at + c]), colourSlack(solid)) << at;
        }
    }
    EXPECT_GT(compared, 20000u);
}

// The scene whose objects are their own polygons.
Scene asPolygons(Scene s, uint32_t segments) {
    s = tessellatedScene(s, segments).scene;
    for (TriangleMesh& mesh : s.meshes) mesh.shape = nullptr;
    return s;
}

double meanDifference(const Truth& a, const Truth& b) {
    double sum = 0;
    for (size_t i = 0; i < a.linear.size(); ++i) sum += std::abs(srgbCode(a.linear[i]) - srgbCode(b.linear[i]));
    return sum / double(a.linear.size());
}

// Turned, stretched and mirrored, among each other, seen from inside and from outside, cut by the near plane.
Scene bodies(bool cull) {
    Scene s = litScene();
    s.cullBackFaces = cull;
    const auto at = [](double x, double y, double z) { return glm::translate(glm::dmat4(1), {x, y, z}); };
    addShape(s, {ShapeKind::cylinder, 0.5, 2, 8}, at(-0.6, 0, -3) * glm::rotate(glm::dmat4(1), 0.7, {1, 0.3, 0.2}), 1);
    addShape(s, {ShapeKind::cylinder, 0.7, 0.6, 8},
             at(0.8, 0.3, -4) * glm::rotate(glm::dmat4(1), -1.1, {0.2, 0.3, 1}) * glm::scale(glm::dmat4(1), {1, -1.5, 0.4}), 0);
    addShape(s, {ShapeKind::sphere, 0.6, 0, 8}, at(0.3, -0.5, -3.2) * glm::scale(glm::dmat4(1), {1.4, 0.6, 0.8}), 1);
    addShape(s, {ShapeKind::sphere, 0.08, 0, 8}, at(-0.05, -0.04, -0.31), 0);  // the near plane cuts it
    return s;
}

TEST(SolidsTruth, BodiesAreTheLimitOfTheirPolygons) {
    for (const bool cull : {true, false}) {
        const Scene s = bodies(cull);
        const Truth truth = truthOf(s, request());
        double before = 0;
        for (const uint32_t n : {16u, 32u, 64u, 128u, 256u}) {
            const double difference = meanDifference(truthOf(asPolygons(s, n), request()), truth);
            std::printf("  cull %d, %u segments: mean difference %.5f steps\n", cull, n, difference);
            if (n > 32) {
                EXPECT_LT(difference, before / 2.5) << n;  // a quarter, and what single pixels of outlines add
            }
            before = difference;
        }
    }
}

struct Order {
    Shading shading;
    double order;  // error falls as n^-order
};
// What is drawn, by the twin, against the shape: mean errors of 8, 16, 32 and 64 segments. Facets of flat shading are as far from the surface's normals
// as a segment is long; all else is second order.
void expectSlopes(const char* name, const GeneratedShape& shape, const glm::dmat4& place, const std::vector<Order>& rows) {
    Scene s = litScene();
    s.cullBackFaces = true;
    addShape(s, shape, place, 1);
    RenderRequest r = request();
    r.samples = 4;
    const Truth truth = truthOf(s, r);
    for (const Order& row : rows) {
        r.shading = row.shading;
        std::vector<double> means;
        for (const uint32_t n : {8u, 16u, 32u, 64u})
            means.push_back(errorOf(renderCpu(tessellatedScene(s, n).scene, r).frame, truth, r.encoding, false).unrounded.mean);
        const double slope = std::log2(means.front() / means.back()) / 3;
        std::printf("  %s, %s: mean error %.4f, %.4f, %.4f, %.4f steps, n^-%.2f\n", name, nameOf(row.shading), means[0], means[1], means[2],
                    means[3], slope);
        EXPECT_GE(slope, row.order - 0.25) << name << ' ' << nameOf(row.shading);
        EXPECT_LE(slope, row.order + 0.25) << name << ' ' << nameOf(row.shading);
    }
}

TEST(SolidsTruth, ErrorFallsAsTheSquareOfTheSegments) {
    const glm::dmat4 away = glm::translate(glm::dmat4(1), {0, 0, -3});
    expectSlopes("sphere", {ShapeKind::sphere, 1, 0, 8}, away, {{Shading::flat, 1}, {Shading::gouraud, 2}, {Shading::phong, 2}});
    // Sides and caps of a cylinder are as long as it is, whatever their number: what is computed at corners or centres alone stays wrong between them.
    expectSlopes("cylinder", {ShapeKind::cylinder, 0.7, 1.2, 8}, away * glm::rotate(glm::dmat4(1), 0.6, {1, 0.2, 0}),
                 {{Shading::phong, 2}});
}

// The teapot's truth is its finest polygons: a coarse one is far from it, the finest one is it.
TEST(SolidsTruth, ATeapotsTruthIsItsFinest) {
    Scene s = litScene();
    s.cullBackFaces = false;
    addShape(s, {ShapeKind::teapot, 1, 2, 8}, glm::translate(glm::dmat4(1), {0, -1.5, -9}), 1);
    RenderRequest r = request();
    const Truth truth = truthOf(s, r);
    const double coarse = meanDifference(truthOf(asPolygons(s, 8), r), truth),
                 finest = meanDifference(truthOf(asPolygons(s, 256), r), truth);
    EXPECT_GT(coarse, 0);
    EXPECT_EQ(finest, 0);
    for (size_t at = 0; at < truth.object.size(); ++at) ASSERT_EQ(truth.primitive[at], kNone);
}

// Faces of objects that are redrawn are not asked for; those of others are.
TEST(SolidsTruth, FacesOfRedrawnObjectsAreForgotten) {
    const Scene s = committed(std::string(PLUMB_SOURCE_DIR) + "/scenes/suzanne.toml", {kWidth, kHeight});
    const RenderRequest r = request();
    const Detail detail = detailed(s, {1, {kWidth, kHeight}});
    const Frame frame = renderCpu(detail.scene, r).frame;
    Truth truth = truthOf(s, r);
    const FrameError byFace = errorOf(frame, truth, r.encoding, false);
    forgetFaces(truth, detail.redrawn);
    const FrameError byObject = errorOf(frame, truth, r.encoding, false);
    EXPECT_GT(byFace.wrongShare(), 0.9) << "numbers of other faces";
    EXPECT_LT(byObject.wrongShare(), 0.05) << "outlines alone";
    EXPECT_GT(byObject.wrongPrimitive, 0u);
    EXPECT_EQ(byFace.picture.rms, byObject.picture.rms);
}

}  // namespace
}  // namespace plumb::test
