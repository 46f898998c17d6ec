// SPDX-License-Identifier: MIT
// Each object is transformed in the cheapest number format whose bound holds in the view. Held against the file's numbers in long double, over
// coordinates, fields of view, near planes and sizes: where float32 would move a vertex by more than a quarter of a pixel, the plan takes more.
#include "pipeline/render/bounds/vertex_arithmetic.h"
#include "pipeline/render/bounds/vertex_error.h"
#include "pipeline/render/raster/twin_frame.h"
#include "pipeline/scene/camera.h"
#include "pipeline/scene/load.h"
#include "tests/support/device_fixture.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using glm::dvec3;

constexpr double kPi = 3.14159265358979323846;
constexpr double kSnap = 0.5 / 256;

// A strip of squares about x = eyeAt in the plane z = 0, with hills, and two squares `farthest` from 0. All numbers are those of float32.
Scene terrain(double farthest, double eyeAt, double fovDegrees, double near) {
    PolygonMesh mesh;
    mesh.name = "terrain";
    mesh.faceFirst.push_back(0);
    const auto quad = [&](double x, double width, double rise) {
        const uint32_t first = uint32_t(mesh.positions.size());
        mesh.positions.push_back({x, 0, 0});
        mesh.positions.push_back({x + width, 0, rise});
        mesh.positions.push_back({x + width, 1, rise});
        mesh.positions.push_back({x, 1, 0});
        for (uint32_t i = 0; i < 4; ++i) mesh.corners.push_back({first + i});
        mesh.faceFirst.push_back(uint32_t(mesh.corners.size()));
        mesh.faceMaterial.push_back(kNone);
    };
    quad(-farthest, 1, 0);
    quad(farthest, 1, 0);
    for (int i = -8; i < 8; ++i) quad(std::round(eyeAt) + i * 0.5, 0.5, i % 2 == 0 ? 0.25 : 0);
    Scene scene;
    scene.materials.emplace_back();
    Object object;
    object.name = "terrain";
    object.worldFromObject[0] *= 1.1;  // no float32
    object.worldFromObject[1] = {0.3, 0.9, 0, 0};
    scene.meshes.push_back(finishMesh(std::move(mesh), scene.materials, 0, {}));
    scene.objects.push_back(object);
    Light sun;
    sun.directional = true;
    sun.direction = {0.2, 0.3, 1};
    sun.intensity = glm::vec3(1);
    scene.lights.push_back(sun);
    Camera camera;
    camera.fovYDegrees = fovDegrees;
    const double distance = 2 / std::tan(fovDegrees * kPi / 360);
    camera.eye = {1.1 * eyeAt, 0.5, distance};
    camera.focusDistance = distance;
    camera.near = near * distance;
    scene.camera = camera;
    return scene;
}

// How far the vertices of the view that are not clipped are from where the file puts them, at most, in pixels. In long double, by the composite
// that the truth takes.
double furthest(const Scene& scene, const RenderRequest& request) {
    const Prepared p = prepare(scene, request);
    const TwinGeometry g = twinGeometry(p.list, p.choices, false, 1);
    const TriangleMesh& mesh = scene.meshes[0];
    const Camera& c = *scene.camera;
    const long double focal = request.height / 2.0L / std::tan(static_cast<long double>(c.fovYDegrees) * kPi / 360);
    double most = 0;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        long double q[3];
        for (int j = 0; j < 3; ++j) {
            q[j] = static_cast<long double>(scene.objects[0].worldFromObject[3][j]) - c.eye[j];
            for (int k = 0; k < 3; ++k) q[j] += static_cast<long double>(scene.objects[0].worldFromObject[k][j]) * mesh.statedAt(v)[k];
        }
        const long double x = focal * q[0] / -q[2] + request.width / 2.0L, y = -focal * q[1] / -q[2] + request.height / 2.0L;
        if (-q[2] < nearOf(c) || x < 0 || y < 0 || x > request.width || y > request.height) continue;
        EXPECT_EQ(g.screen[v].outcode, 0u);
        most = std::max(most, double(std::max(std::abs(x - g.screen[v].x / 256.0L), std::abs(y - g.screen[v].y / 256.0L))));
    }
    return most;
}

RenderRequest requestOf(uint32_t width, uint32_t height) {
    RenderRequest r;
    r.width = width;
    r.height = height;
    return r;
}

class PrecisionOfObjects : public test::DeviceTest {};

TEST_F(PrecisionOfObjects, IsRaisedWhereFloat32WouldMoveAVertex) {
    int cases = 0, needed = 0, wrongBefore = 0, blocks = 0, binary64 = 0;
    double tightest = 0;
    for (const double farthest : {10.0, 1e3, 1e4, 1e5, 1e6, 8e6})
        for (const double at : {0.0, 0.7})
            for (const double fov : {1.0, 20.0, 75.0})
                for (const double near : {1e-3, 0.3})
                    for (const uint32_t size : {120u, 1080u, 4096u}) {
                        SCOPED_TRACE(fmt::format("{} at {}, {} degrees, near {}, {} px", farthest, at, fov, near, size));
                        const Scene scene = terrain(farthest, std::round(at * farthest), fov, near);
                        RenderRequest request = requestOf(size * 4 / 3, size);
                        const VertexArithmetic chosen = vertexArithmetic(scene, request)[0];
                        const double drawn = furthest(scene, request), bound = vertexErrorOf(scene, request, 0).pixels;
                        ++cases;
                        EXPECT_LE(drawn, bound + kSnap) << "the bound holds";
                        tightest = std::max(tightest, (drawn - kSnap) / bound);
                        EXPECT_EQ(chosen.raised, chosen.usualPixels > kRaisePixels);
                        EXPECT_LE(bound, kToldPixels) << "nothing is left to warn of here";
                        request.knobs.float32Only = true;
                        const double before = furthest(scene, request);
                        EXPECT_LE(before, chosen.usualPixels + kSnap);
                        needed += chosen.raised;
                        wrongBefore += before > kRaisePixels + kSnap;
                        if (before > kRaisePixels + kSnap) {
                            EXPECT_TRUE(chosen.raised);
                            EXPECT_LE(drawn, kRaisePixels + kSnap);
                        }
                        blocks += chosen.precision == Precision::blockInteger;
                        binary64 += chosen.precision == Precision::fp64;
                    }
    fmt::print(
        "precision: {} views, {} raised ({} in block-scaled integers, {} in binary64), float32 moves a vertex by over 1/4 px in {}; "
        "error at most {:.2f} of its bound\n",
        cases, needed, blocks, binary64, wrongBefore, tightest);
    EXPECT_GT(wrongBefore, cases / 10) << "float32 would do";
    EXPECT_GT(blocks, 0);
    EXPECT_GT(binary64, 0);
    EXPECT_LT(needed, cases);
    EXPECT_GT(tightest, 0.01) << "a bound that is a hundred times too large raises what needs nothing";
}

TEST_F(PrecisionOfObjects, LeavesTheSameBytesOnBothSides) {
    for (const double farthest : {2e5, 8e6}) {
        Scene scene = terrain(farthest, std::round(0.7 * farthest), 20, 1e-3);
        // A near object in float32 beside it, which the near plane cuts: one list has both.
        Object other = scene.objects[0];
        scene.meshes.push_back(terrain(4, 0, 20, 1e-3).meshes[0]);
        other.mesh = 1;
        other.name = "fence";
        other.worldFromObject = glm::dmat4(1);
        other.worldFromObject[2] = {0, 0, 8, 0};
        other.worldFromObject[0] = {0, 0, 6, 0};
        other.worldFromObject[3] = glm::dvec4(scene.camera->eye - dvec3(0, 0.5, 4), 1);
        scene.objects.push_back(other);
        for (const Shading shading : {Shading::phong, Shading::flat, Shading::wire})
            for (const uint32_t samples : {1u, 4u}) {
                SCOPED_TRACE(fmt::format("{}, shading {}, {} samples", farthest, int(shading), samples));
                RenderRequest request = requestOf(160, 120);
                request.shading = shading;
                request.samples = samples;
                const VerifyReport report = verifyRender(device(), scene, request);
                EXPECT_TRUE(report.equal) << (report.mismatches.empty() ? "" : report.mismatches[0].what);
                EXPECT_GT(report.twin.frame.coveredPixels, 0u);
                ASSERT_EQ(report.device.plan.raised.size(), 1u);
                const Plan::Raise& raise = report.device.plan.raised[0];
                EXPECT_EQ(raise.what, "precision");
                EXPECT_EQ(raise.of, "'terrain'") << "the object, and not the whole picture";
                EXPECT_NE(raise.why.find("float32 would move a vertex by up to"), std::string::npos) << raise.why;
                EXPECT_LE(raise.reached, kToldPixels);
                request.knobs.float32Only = true;
                EXPECT_NE(renderGpu(device(), scene, request).frame.rgba, report.device.frame.rgba) << "more than float32 changes nothing";
            }
    }
}

// Parts of one glTF mesh meet at common edges.
TEST_F(PrecisionOfObjects, IsThatOfAllObjectsUnderOneMatrix) {
    Scene scene = terrain(1e5, 7e4, 20, 1e-3);
    Object part = scene.objects[0];
    part.name = "part";
    part.mesh = 1;
    scene.meshes.push_back(terrain(4, 0, 20, 1e-3).meshes[0]);
    scene.objects.push_back(part);
    const RenderRequest request = requestOf(160, 120);
    std::vector<VertexArithmetic> chosen = vertexArithmetic(scene, request);
    EXPECT_EQ(chosen[1].precision, chosen[0].precision);
    EXPECT_EQ(chosen[1].with, 0u);
    scene.objects[1].worldFromObject[3].y += 1;
    chosen = vertexArithmetic(scene, request);
    EXPECT_FALSE(chosen[1].raised) << "it stands by itself";
}

// What a request states is kept.
TEST_F(PrecisionOfObjects, IsThatOfTheRequest) {
    const Scene scene = terrain(1e5, 7e4, 20, 1e-3);
    for (const Precision precision : {Precision::blockInteger, Precision::fp64}) {
        RenderRequest request = requestOf(160, 120);
        request.trade.precision = precision;
        const Prepared p = prepare(scene, request);
        EXPECT_EQ(p.list.ranges.at(0).precision, precision);
        EXPECT_TRUE(p.plan.raised.empty());
    }
}

// A resident picture follows the view: the same bytes as a fresh one, near and far.
TEST_F(PrecisionOfObjects, FollowsTheCamera) {
    Scene scene = terrain(1e5, 7e4, 20, 1e-3);
    const RenderRequest request = requestOf(160, 120);
    ResidentScene resident(device(), scene, request);
    for (const double back : {1.0, 1e5, 1.0}) {
        Scene moved = scene;
        moved.camera->eye.z *= back;
        const ResidentScene::Picture got = resident.draw({*moved.camera});
        const RenderResult want = renderGpu(device(), moved, request);
        EXPECT_EQ(want.plan.raised.empty(), back > 1);
        for (uint32_t y = 0; y < got.height; ++y)
            for (uint32_t x = 0; x < got.width; ++x)
                ASSERT_EQ(got.pixels[y * got.pitch + x] & 0xffffffu, want.frame.rgba[y * got.width + x] & 0xffffffu) << x << " " << y;
    }
}

}  // namespace
}  // namespace plumb
