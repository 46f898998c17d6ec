// SPDX-License-Identifier: MIT
// The truth of rays against the textbook tracer, against itself where two descriptions of one thing must agree, against exact ties, and against the
// passes; and mistakes that its figures must notice.
#include "pipeline/truth/rays.h"

#include "pipeline/truth/frame_error.h"
#include "tests/oracle/trace_oracle.h"
#include "tests/support/ray_scenes.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

namespace plumb::test {
namespace {

using truth::Pinhole;
using truth::RayLimits;
using truth::RaySeen;
using truth::RayTruth;
using truth::RayWorld;

constexpr uint32_t kWidth = 64, kHeight = 48;
// The oracle's own rounding: a unit round-off at its start, times 64 for each of at most seven hits (curved surfaces spread what comes before).
constexpr double kOracleError = 0x1p-53 * 4398046511104.0;  // 64^7: 2^-11 where a path is as wild as can be
constexpr double kCalm = 0x1p-30;                           // and what all but a few pixels keep

RenderRequest requestOf(const Scene& scene) {
    RenderRequest r;
    r.width = kWidth;
    r.height = kHeight;
    r.shading = Shading::ray;
    r.background = scene.background.value_or(glm::vec3(0));
    r.maxDepth = scene.maxDepth;
    r.planes = kPlaneColour | kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive;
    return r;
}

struct Compared {
    int pixels = 0, wild = 0, differing = 0;
};

// Every pixel: the same object, distance and colour, unless the oracle itself decides otherwise 2^-26 of a pixel beside.
Compared compareWithOracle(const Scene& scene, const RayLimits& limits) {
    Compared out;
    const glm::dvec3 sky(*scene.background);
    const TraceOracle oracle(scene, sky, limits.maxDepth);
    const Pinhole pinhole(*scene.camera, kWidth, kHeight, 1);
    const RayWorld world(scene);
    RayTruth truth(world, pinhole, sky, limits);
    const Camera& camera = *scene.camera;
    const auto direction = [&](double x, double y) { return camera.forward * pinhole.focal + camera.right * x - camera.up * y; };
    for (uint32_t j = 0; j < kHeight; ++j)
        for (uint32_t i = 0; i < kWidth; ++i) {
            const double x = i + 0.5 - kWidth / 2.0, y = j + 0.5 - kHeight / 2.0;
            const OracleSeen expected = oracle.look(camera.eye, direction(x, y));
            const RaySeen seen = truth.look(x, y);
            ++out.pixels;
            const double off = glm::length(seen.colour - expected.colour);
            const int object = seen.object == kNone ? -1 : int(seen.object);
            bool beside = false;
            if (!(off <= kCalm) || object != expected.object)
                for (int k = 0; k < 8; ++k)
                    beside |=
                        oracle
                            .look(camera.eye, direction(x + 0x1p-26 * std::cos(k * 0.7853981634), y + 0x1p-26 * std::sin(k * 0.7853981634)))
                            .path != expected.path;
            if (beside) {
                ++out.wild;
                continue;
            }
            EXPECT_EQ(object, expected.object) << "pixel " << i << ", " << j;
            EXPECT_LE(off, kOracleError) << "pixel " << i << ", " << j;
            out.differing += off > kCalm;
            if (object >= 0) {
                EXPECT_NEAR(seen.distance, expected.distance, 0x1p-30 * expected.distance);
            }
        }
    return out;
}

TEST(RayTruth, AgreesWithTheTextbookTracer) {
    for (const auto& [name, scene] : {std::pair("mirrors", mirrors()), std::pair("glass", glass()), std::pair("inGlass", inGlass())}) {
        RayLimits limits;
        limits.maxDepth = scene.maxDepth;
        limits.leastWeight = 0;
        const Compared c = compareWithOracle(scene, limits);
        std::printf("%s: %d pixels, %d beside a decision of the oracle, %d off by more than 2^-30\n", name, c.pixels, c.wild, c.differing);
        EXPECT_LE(c.wild, c.pixels / 100) << name;
        EXPECT_LE(c.differing, c.pixels / 100) << name;
    }
}

// Seeds are fixed: the same scenes in every run.
TEST(RayTruth, AgreesWithTheTextbookTracerOnRandomScenes) {
    Random r(2101);
    int wild = 0, pixels = 0, differing = 0;
    for (int n = 0; n < 12; ++n) {
        Scene s = rayScene();
        s.shadows = n % 4 != 3;
        for (int k = 0; k < 4; ++k) {
            const float reflect = float(r(0, 0.6)), transmit = k % 2 ? float(r(0, 0.9 - double(reflect))) : 0.0f;
            addRayMaterial(s, glm::vec3(float(r(0, 1)), float(r(0, 1)), float(r(0, 1))), reflect, transmit, float(r(0.5, 2)),
                           float(int(r(0, 200))));
        }
        const auto any = [&] { return 1 + uint32_t(r(0, 3.99)); };
        for (int k = 0; k < 6; ++k) s.spheres.push_back(ball({r(-3, 3), r(-1, 3), r(-4, 3)}, r(0.2, 1.2), any()));
        s.planes.push_back(floorAt(r(-2, -1), any(), any(), r(0.3, 2)));
        s.planes.back().twoSided = n % 2 == 0;
        s.planes.back().mirrored = n % 3 == 0;
        s.lights[0].position = {r(-4, 4), r(2, 7), r(0, 6)};
        RayLimits limits;
        limits.maxDepth = uint32_t(r(1, 6.99));
        limits.leastWeight = 0;
        const Compared c = compareWithOracle(s, limits);
        pixels += c.pixels, wild += c.wild, differing += c.differing;
    }
    std::printf("random scenes: %d pixels, %d beside a decision of the oracle, %d off by more than 2^-30\n", pixels, wild, differing);
    EXPECT_LE(wild, pixels / 100);
    EXPECT_LE(differing, pixels / 100);
}

// A bounded plane as two triangles, with a transform, as itself: the same light, mirrors, shadows and glass.
TEST(RayTruth, TwoTrianglesAreTheBoundedPlaneThatTheyCover) {
    for (const float transmit : {0.0f, 0.4f}) {
        Scene planes = rayScene();
        const uint32_t mirror = addRayMaterial(planes, {0.4f, 0.5f, 0.6f}, 0.3f, transmit, 1.3f),
                       red = addRayMaterial(planes, {0.8f, 0.1f, 0.1f}, 0.2f, 0, 1);
        planes.spheres = {ball({0.3, 0.9, 1.5}, 0.5, red), ball({-1.5, 0.5, -2}, 1.4, red)};
        planes.lights[0].attenuation = Attenuation::inverseSquare;
        planes.lights[0].intensity = glm::vec3(20);
        Scene meshes = planes;
        PlaneShape p;
        p.point = {0, 0, 0};
        p.normal = glm::normalize(glm::dvec3(0, 1, 0.4));
        p.u = {1, 0, 0};
        p.v = glm::cross(p.u, p.normal);
        p.uMin = -3, p.uMax = 2.5, p.vMin = -2, p.vMax = 1.5;
        p.material = mirror;
        planes.planes.push_back(p);
        TriangleMesh mesh;
        mesh.positions = {{-6, 0, -1}, {5, 0, -1}, {5, 0, 0.75}, {-6, 0, 0.75}};  // twice as wide and half as deep: the matrix undoes it
        mesh.normals = std::vector<glm::vec3>(4, glm::vec3(0, 1, 0));
        mesh.triangles = {{{0, 2, 1}, 0}, {{0, 3, 2}, 0}};
        mesh.faceMaterial = {mirror};
        mesh.vertexMaterial = std::vector<uint32_t>(4, mirror);
        meshes.meshes.push_back(mesh);
        Object object;
        object.worldFromObject = glm::dmat4(1);
        object.worldFromObject[0] = glm::dvec4(p.u * 0.5, 0);
        object.worldFromObject[1] = glm::dvec4(p.normal, 0);
        object.worldFromObject[2] = glm::dvec4(p.v * 2.0, 0);
        meshes.objects.push_back(object);
        const glm::dvec3 sky(*planes.background);
        const Pinhole pinhole(*planes.camera, kWidth, kHeight, 1);
        const RayWorld a(planes), b(meshes);
        RayTruth whole(a, pinhole, sky), cut(b, pinhole, sky);
        int hits = 0;
        for (uint32_t j = 0; j < kHeight; ++j)
            for (uint32_t i = 0; i < kWidth; ++i) {
                const double x = i + 0.5 - kWidth / 2.0, y = j + 0.5 - kHeight / 2.0;
                const RaySeen one = whole.look(x, y), other = cut.look(x, y);
                hits += one.object == 2;
                EXPECT_EQ(one.object == 2, other.object == 0) << "pixel " << i << ", " << j;
                EXPECT_LE(glm::length(one.colour - other.colour), kCalm) << "pixel " << i << ", " << j;
            }
        EXPECT_GT(hits, 500);
    }
}

// The notes' board: row 182 of 320x240 looks exactly along the line between its squares 27 and 28, and the end of an even square belongs to it.
TEST(RayTruth, ExactTiesOnABoardAreDecidedAsTies) {
    Scene s = rayScene();
    s.leftHanded = true;
    s.lights.clear();
    s.ambient = glm::vec3(1);
    Camera c;
    c.eye = {0, 0, -800};
    c.right = {1, 0, 0}, c.up = {0, 1, 0}, c.forward = {0, 0, 1};
    c.focalPixels = 800;
    c.focusDistance = 800;
    s.camera = c;
    const uint32_t white = addRayMaterial(s, glm::vec3(1), 0, 0, 1), black = addRayMaterial(s, glm::vec3(0), 0, 0, 1);
    PlaneShape board = floorAt(-500, white, black, 200);
    board.mirrored = true;
    s.planes.push_back(board);
    const Pinhole pinhole(c, 320, 240, 1);
    const RayWorld world(s);
    RayTruth truth(world, pinhole, glm::dvec3(0));
    for (int i = 0; i < 320; ++i) {
        const double x = i + 0.5 - 160, y = 62.5;  // z = 8 * 800 - 800 = 28 * 200: square 28 begins, or 27 ends
        const double u = 8 * x;
        bool other = u < 0;
        if (std::fmod(std::abs(u), 400) > 200) other = !other;
        const RaySeen seen = truth.look(x, y);
        EXPECT_EQ(seen.colour.x, other ? 0.0 : 1.0) << x;
    }
    EXPECT_GT(truth.undecided(), 0u) << "ties are counted";
}

// What the passes draw lies between what the truth sees within the error of a primary ray beside it; meshes with transforms, instances and mirrored ones, glass, a fading light.
TEST(RayTruth, MeshesAreWhatThePassesDraw) {
    Scene scene = meshesAmongMirrors();
    scene.lights[0].attenuation = Attenuation::inverse;
    scene.lights[0].intensity *= 6.0f;
    scene.maxDepth = 4;
    const RenderRequest request = requestOf(scene);
    const RenderResult drawn = renderCpu(scene, request);
    const Pinhole pinhole(*scene.camera, kWidth, kHeight, 1);
    const RayWorld world(scene);
    RayLimits limits;
    limits.maxDepth = scene.maxDepth;
    limits.leastWeight = 0;
    RayTruth truth(world, pinhole, glm::dvec3(request.background), limits);
    // float32 carries a ray to within 64 u of its way a hit, and a curved surface of radius 1/10 of it spreads that by 20 (docs/accuracy.md, rays).
    const double edge = 4 * 64 * 20 * 0x1p-24 * pinhole.focal;
    int edges = 0, beyond = 0;
    for (uint32_t j = 0; j < kHeight; ++j)
        for (uint32_t i = 0; i < kWidth; ++i) {
            const double x = i + 0.5 - kWidth / 2.0, y = j + 0.5 - kHeight / 2.0;
            const RaySeen seen = truth.look(x, y);
            glm::dvec3 low = seen.colour, high = seen.colour;
            bool same = true;
            for (int k = 0; k < 8; ++k) {
                const RaySeen beside = truth.look(x + edge * std::cos(k * 0.7853981634), y + edge * std::sin(k * 0.7853981634));
                low = glm::min(low, beside.colour), high = glm::max(high, beside.colour);
                same &= beside.object == seen.object && beside.primitive == seen.primitive;
            }
            const size_t at = size_t(j) * kWidth + i;
            if (same) {
                EXPECT_EQ(drawn.frame.object[at], seen.object) << "pixel " << i << ", " << j;
                if (seen.object != kNone && seen.object < scene.objects.size()) {
                    EXPECT_EQ(drawn.frame.primitive[at], seen.primitive) << "pixel " << i << ", " << j;
                }
            }
            edges += !same;
            bool out = false;
            for (int c = 0; c < 3; ++c) {
                const double code = srgbCode(double(drawn.frame.linear[3 * at + size_t(c)]));
                out |= code < srgbCode(low[c]) - 1 || code > srgbCode(high[c]) + 1;
            }
            // Behind the first hit an edge may be nearer than its neighbours show: what is outside must then be few.
            beyond += out;
        }
    std::printf("meshes: %d pixels of %u within %.2g px of an edge, %d beyond their neighbours by a level\n", edges, kWidth * kHeight, edge,
                beyond);
    EXPECT_LE(edges, int(kWidth * kHeight / 10));
    EXPECT_LE(beyond, int(kWidth * kHeight / 500));
}

// Spheres that the eye is close to, with a ball, a board and a lamp of the gap's size: nothing is missed, and no colour is off by more than half
// of what a byte cannot hold. Mirrors among curved surfaces spread float32's error, so there a few pixels may.
constexpr float kUnseenSteps = 0.25f;
TEST(RayTruth, SpheresCloseToTheEyeAreDrawnRight) {
    for (const double radius : {1e-6, 1e-3, 1.0, 1e3, 6.371e6, 1e9})
        for (const int ratio : {-30, -24, -17, -10, -5, -1})
            for (const int side : {1, -1}) {
                Scene scene = closeTo(radius, side * std::ldexp(radius, ratio) * (side < 0 ? 0.2 : 1));
                RenderRequest request = requestOf(scene);
                const Truth truth = truthOf(scene, request);
                const FrameError e = errorOf(renderCpu(scene, request).frame, truth, request.encoding, false);
                const auto off =
                    std::count_if(e.unroundedPerPixel.begin(), e.unroundedPerPixel.end(), [](float steps) { return steps > kUnseenSteps; });
                EXPECT_EQ(e.wrongPrimitive, 0u) << radius << ", 2^" << ratio << ", side " << side;
                EXPECT_LE(off, kWidth * kHeight / 400) << radius << ", 2^" << ratio << ", side " << side;
                EXPECT_GT(e.pixels, kWidth * kHeight / 3u) << "little is seen";
            }
}

TEST(RayTruth, TheErrorOfAPictureNoticesMistakes) {
    Scene scene = mirrors();
    const uint32_t clear = addRayMaterial(scene, glm::vec3(0.05f), 0.1f, 0.8f, 1.5f);
    scene.spheres.push_back(ball({-0.3, 0.3, 2.8}, 0.8, clear));
    RenderRequest request = requestOf(scene);
    const Truth truth = truthOf(scene, request);
    const auto errorFor = [&](const Scene& drawn, const RenderRequest& r) {
        return errorOf(renderCpu(drawn, r).frame, truth, r.encoding, false);
    };
    const FrameError plain = errorFor(scene, request);
    EXPECT_GT(plain.unrounded.rms, 0.0) << "a picture would be compared with itself";
    EXPECT_EQ(truth.samples, 1u);
    double last = 256;
    for (const uint32_t depth : {1u, 2u, 3u, 5u, 16u}) {
        request.maxDepth = depth;
        const double rms = errorFor(scene, request).unrounded.rms;
        EXPECT_LT(rms, last) << "depth " << depth;
        last = rms;
    }
    // Deep enough, what is left is float32 and, here and there, an edge: the squares of the board meet on diagonals through pixels' middles.
    const auto farOff = [](const FrameError& e) {
        return std::count_if(e.unroundedPerPixel.begin(), e.unroundedPerPixel.end(), [](float steps) { return steps > 0.25f; });
    };
    const FrameError deep = errorFor(scene, request);
    EXPECT_LT(farOff(deep), kWidth * kHeight / 50);
    EXPECT_LT(deep.depthRelative, 0x1p-10);
    for (int mistake = 0; mistake < 5; ++mistake) {
        Scene wrong = scene;
        if (mistake == 0) wrong.lights[0].position.x += 0.1;
        if (mistake == 1) wrong.spheres[0].radius *= 1.001;
        if (mistake == 2) wrong.materials[clear].refractiveIndex *= 1.002f;
        if (mistake == 3) wrong.shadows = false;
        if (mistake == 4) wrong.planes[0].square *= 1.02;
        EXPECT_GT(farOff(errorFor(wrong, request)), 2 * farOff(deep)) << "mistake " << mistake;
    }
}

TEST(RayTruth, SamplesLieWhereThePicturesDo) {
    const Scene scene = mirrors();
    RenderRequest request = requestOf(scene);
    request.maxDepth = 20;
    for (const auto sampling :
         {RayChoices::Sampling::grid, RayChoices::Sampling::centre, RayChoices::Sampling::corners, RayChoices::Sampling::notes}) {
        for (const uint32_t samples : {1u, 4u}) {
            if (samples != 1 && sampling == RayChoices::Sampling::corners) continue;
            request.samples = samples;
            request.rays.sampling = sampling;
            const Truth truth = truthOf(scene, request);
            const FrameError error = errorOf(renderCpu(scene, request).frame, truth, request.encoding, false);
            // Any other place shows another colour nearly everywhere. The board's squares meet on diagonals, on which pixels of these pictures lie exactly.
            const auto farOff = [](const FrameError& e) {
                return std::count_if(e.unroundedPerPixel.begin(), e.unroundedPerPixel.end(), [](float steps) { return steps > 0.25f; });
            };
            EXPECT_LT(farOff(error), kWidth * kHeight / 20) << int(sampling) << " " << samples;
            EXPECT_LE(error.wrongPrimitive, 4u) << int(sampling) << " " << samples;
            RenderRequest elsewhere = request;
            elsewhere.rays.sampling = sampling == RayChoices::Sampling::notes ? RayChoices::Sampling::grid : RayChoices::Sampling::notes;
            EXPECT_GT(farOff(errorOf(renderCpu(scene, elsewhere).frame, truth, request.encoding, false)), kWidth * kHeight / 10)
                << int(sampling) << " " << samples;
        }
    }
}

TEST(RayTruth, ThreadsAndBackgroundsMakeNoDifference) {
    const Scene scene = glass();
    RenderRequest request = requestOf(scene);
    request.width = 16;
    request.height = 12;
    request.threads = 1;
    const Truth one = truthOf(scene, request);
    request.threads = 3;
    const Truth three = truthOf(scene, request);
    EXPECT_EQ(one.linear, three.linear);
    EXPECT_EQ(one.redone, three.redone);
    EXPECT_EQ(one.leftOut, three.leftOut);
    EXPECT_GT(one.leftOut, 0.0);
    EXPECT_LT(one.leftOut, 1.0 / 64) << "glass among glass: no more than this weight is left out of any pixel";
    Scene bare = scene;
    bare.planes.clear();
    request.transparent = true;
    request.samples = 4;
    request.background = glm::vec3(0);
    request.maxDepth = 20;
    const Truth clear = truthOf(bare, request);
    const FrameError error = errorOf(renderCpu(bare, request).frame, clear, request.encoding, true);
    EXPECT_LT(error.picture.mean, 0.5);
    EXPECT_LT(error.picture.p99, 1.0);
}

// What is left out of the tree is at most its weight times the brightest colour, and grows with the weight at which it is cut.
TEST(RayTruth, WhatIsCutWeighsWhatIsSaid) {
    const Scene scene = glass();
    const glm::dvec3 sky(*scene.background);
    const Pinhole pinhole(*scene.camera, kWidth, kHeight, 1);
    const RayWorld world(scene);
    const double brightest = world.brightness(sky).most;
    RayTruth whole(world, pinhole, sky, {12, 0x1p-14, 1u << 20});
    double before = 0;
    for (const double least : {0x1p-8, 0x1p-6, 0x1p-4}) {
        RayTruth cut(world, pinhole, sky, {12, least, 1u << 20});
        double sum = 0;
        for (uint32_t k = 0; k < kWidth * kHeight; k += 7) {
            const uint32_t row = k / kWidth;
            const double x = k % kWidth + 0.5 - kWidth / 2.0, y = row + 0.5 - kHeight / 2.0;
            const RaySeen a = whole.look(x, y), b = cut.look(x, y);
            for (int c = 0; c < 3; ++c) {
                EXPECT_LE(a.colour[c] - b.colour[c], b.leftOut * brightest + kCalm);
                EXPECT_GE(a.colour[c] - b.colour[c], -a.leftOut * brightest - kCalm);
            }
            sum += b.leftOut;
        }
        EXPECT_GT(sum, before);
        before = sum;
    }
}

}  // namespace
}  // namespace plumb::test
