// SPDX-License-Identifier: MIT
// The truth against what does not need it: closed forms in long double, the witness of coverage in rationals, exact ties, and planted mistakes that
// its error figures must notice.
#include "host/error.h"
#include "pipeline/truth/exact.h"
#include "pipeline/truth/frame_error.h"
#include "tests/oracle/coverage_oracle.h"
#include "tests/oracle/screen_scene.h"
#include "tests/support/scenes.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using Real80 = long double;
using truth::Exact;

constexpr double kUnit = 0x1p-53;
// Closed forms below take fewer than 64 operations, each off by u of a quantity at most `condition` times the result, to first order.
double slack(double condition) { return 64 * kUnit * condition; }

constexpr uint32_t kAllPlanes = kPlaneColour | kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive;

RenderRequest requestOf(uint32_t width, uint32_t height, uint32_t samples = 1) {
    RenderRequest r;
    r.width = width;
    r.height = height;
    r.samples = samples;
    r.planes = kAllPlanes;
    return r;
}

// --- exact arithmetic -------------------------------------------------------------------------------------------------------------------

TEST(TruthExact, SumsAndProductsLoseNothing) {
    test::Random random(1);
    for (int i = 0; i < 2000; ++i) {
        const double a = std::ldexp(random(-1, 1), int(random(-200, 200))), b = std::ldexp(random(-1, 1), int(random(-200, 200)));
        const Exact x = a, y = b;
        EXPECT_EQ(((x + y) * (x - y) - (x * x - y * y)).sign(), 0);
        EXPECT_EQ(((x + y) - y - x).sign(), 0);
        EXPECT_EQ((x * y - Exact(a * b) - Exact(std::fma(a, b, -(a * b)))).sign(), 0)
            << "a product is what the processor rounds it to, and the rest";
        EXPECT_EQ((x - y).sign(), a < b ? -1 : a > b ? 1 : 0);
    }
    EXPECT_EQ((Exact(1) + Exact(0x1p-1000) - Exact(1)).sign(), 1);
    EXPECT_EQ((Exact(1) - Exact(0x1p-1000) - Exact(1)).sign(), -1);
    EXPECT_EQ(Exact(0.0).sign(), 0);
    EXPECT_EQ((Exact(-3) * Exact(0x1p-1074)).rounded(), -3 * 0x1p-1074);
    EXPECT_EQ((Exact(0x1.fffffffffffffp1023) * Exact(2) - Exact(0x1.fffffffffffffp1023)).rounded(), 0x1.fffffffffffffp1023);
}

// --- closed forms -----------------------------------------------------------------------------------------------------------------------

// Corners at pixels (20, 8), (4, 40), (44, 36) and depths 1, 2, 4, so that perspective matters; a normal and a light for each.
struct OneTriangle {
    test::View view{48, 48};
    double px[3] = {20, 4, 44}, py[3] = {8, 40, 36}, w[3] = {1, 2, 4};
    Scene scene;

    OneTriangle() {
        test::Corners c;
        for (size_t i = 0; i < 3; ++i) c[i] = view.pointAt(px[i], py[i], w[i]);
        scene = test::litScene();
        scene.materials.resize(1);
        scene.materials[0].specular = glm::vec3(0.5f);
        scene.materials[0].shininess = 40;
        TriangleMesh mesh = test::soupOf({c}, 1);
        mesh.normals = {glm::vec3(0, 0, 1), glm::vec3(0.6f, 0, 0.8f), glm::vec3(0, 0.8f, 0.6f)};
        test::addObject(scene, std::move(mesh));
    }
    // Weights of the corners in perspective, by the ratio of areas on the screen.
    std::array<Real80, 3> weights(Real80 x, Real80 y) const {
        std::array<Real80, 3> b{};
        Real80 sum = 0;
        for (size_t i = 0; i < 3; ++i) {
            const size_t j = (i + 1) % 3, k = (i + 2) % 3;
            b[i] = ((px[j] - x) * (py[k] - y) - (px[k] - x) * (py[j] - y)) / w[i];
            sum += b[i];
        }
        for (Real80& v : b) v /= sum;
        return b;
    }
};

using Vector80 = std::array<Real80, 3>;
Real80 dot80(const Vector80& a, const Vector80& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector80 unit80(Vector80 v) {
    const Real80 length = std::sqrt(dot80(v, v));
    for (Real80& c : v) c /= length;
    return v;
}

// The formula of docs/truth.md once more, in long double, for a point relative to the eye at the origin.
Vector80 phong80(const Scene& s, const Material& m, const Vector80& n, const Vector80& p) {
    Vector80 colour{};
    const Vector80 v = unit80({-p[0], -p[1], -p[2]});
    for (int c = 0; c < 3; ++c) colour[size_t(c)] = Real80(m.ambient[c]) * Real80(s.ambient[c]) + Real80(m.emission[c]);
    for (const Light& light : s.lights) {
        Vector80 l{};
        for (int c = 0; c < 3; ++c)
            l[size_t(c)] = light.directional ? Real80(light.direction[c]) : Real80(light.position[c]) - p[size_t(c)];
        const Real80 distance = std::sqrt(dot80(l, l));
        l = unit80(l);
        const Real80 nl = dot80(n, l);
        if (nl <= 0) continue;
        Vector80 r{};
        for (size_t c = 0; c < 3; ++c) r[c] = 2 * nl * n[c] - l[c];
        const Real80 rv = dot80(r, v), shine = m.shininess == 0 ? 1 : rv > 0 ? std::pow(rv, Real80(m.shininess)) : 0;
        const Real80 fade = light.directional ? 1 : std::pow(distance, -Real80(int(light.attenuation)));
        for (int c = 0; c < 3; ++c)
            colour[size_t(c)] += Real80(light.intensity[c]) * fade * (Real80(m.diffuse[c]) * nl + Real80(m.specular[c]) * shine);
    }
    return colour;
}

TEST(Truth, OneTriangleHasKnownWeightsDepthAndColour) {
    const OneTriangle one;
    const Truth t = truthOf(one.scene, requestOf(48, 48));
    const TriangleMesh& mesh = one.scene.meshes[0];
    uint32_t inside = 0;
    for (uint32_t y = 0; y < 48; ++y)
        for (uint32_t x = 0; x < 48; ++x) {
            const size_t at = y * 48 + x;
            const auto b = one.weights(x + 0.5L, y + 0.5L);
            const bool here = b[0] > 0 && b[1] > 0 && b[2] > 0;
            ASSERT_EQ(t.object[at] == 0, here) << x << ", " << y;
            ASSERT_EQ(std::isinf(t.depth[at]), !here);
            if (!here) continue;
            ++inside;
            Real80 w = 0;
            Vector80 n{}, p{};
            for (size_t i = 0; i < 3; ++i) {
                w += b[i] * one.w[i];
                for (size_t c = 0; c < 3; ++c) {
                    n[c] += b[i] * Real80(mesh.normals[i][int(c)]);
                    p[c] += b[i] * Real80(mesh.positions[i][int(c)]);
                }
            }
            // Weights are areas out of a 24 px offset squared over an area of some 500 square pixels; n and the exponent 40 multiply it.
            const double condition = 48 * 48;
            EXPECT_LE(std::abs(double(t.depth[at] - w)), slack(condition) * double(w)) << x << ", " << y;
            const Vector80 colour = phong80(one.scene, one.scene.materials[0], unit80(n), p);
            for (size_t c = 0; c < 3; ++c)
                EXPECT_LE(std::abs(double(t.linear[3 * at + c] - colour[c])), slack(condition) * 40 * 4) << x << ", " << y;
        }
    EXPECT_GT(inside, 500u);
}

TEST(Truth, APlaneHasThePlanesDepth) {
    // The floor y = -1 under an eye at the origin: a ray (X, Y, 1) with the focal length f meets it at w = f / Y.
    const test::View view{64, 40};
    const float far = 64;
    const std::vector<test::Corners> floor = {{glm::vec3(-far, -1, far), glm::vec3(-far, -1, -far), glm::vec3(far, -1, -far)},
                                              {glm::vec3(-far, -1, far), glm::vec3(far, -1, -far), glm::vec3(far, -1, far)}};
    const Truth t = truthOf(test::sceneOf(floor), requestOf(view.width, view.height));
    uint32_t seen = 0;
    for (uint32_t y = 0; y < view.height; ++y)
        for (uint32_t x = 0; x < view.width; ++x) {
            const Real80 down = y + 0.5L - view.height / 2.0L, across = x + 0.5L - view.width / 2.0L;
            const Real80 w = down > 0 ? test::kFocal / down : INFINITY;
            const bool here = w <= far && std::abs(across / test::kFocal) * w <= far;
            const size_t at = y * view.width + x;
            ASSERT_EQ(t.object[at] == 0, here) << x << ", " << y;
            if (!here) continue;
            ++seen;
            // Corners at +-64 and a plane at distance 1: products are 64 times what is left of them.
            EXPECT_LE(std::abs(double(t.depth[at] - w)), slack(64 * 64) * double(w));
        }
    EXPECT_GT(seen, view.width * view.height / 3);  // the triangles behind the eye are cut by the near plane alone
}

TEST(Truth, ASphereIsShadedByItsTrueNormals) {
    // A tessellated sphere with radial normals: any weights give the direction from its centre, so the colour follows from the depth alone.
    const test::View view{96, 96};
    Scene scene = test::litScene();
    TriangleMesh sphere = test::committed(std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes/procedural/icosphere.ply", {96, 96}).meshes[0];
    for (size_t i = 0; i < sphere.positions.size(); ++i) sphere.normals[i] = sphere.positions[i];  // radial; any length
    for (uint32_t& m : sphere.vertexMaterial) m = 0;
    for (uint32_t& m : sphere.faceMaterial) m = 0;
    scene.materials.resize(1);
    scene.materials[0].specular = glm::vec3(0.25f);
    scene.materials[0].shininess = 20;
    glm::dmat4 back(1.0);
    back[3] = {0.25, -0.125, -4, 1};
    float radius = 0;
    for (const glm::vec3& p : sphere.positions) radius = std::max(radius, glm::length(p));
    test::addObject(scene, sphere, back);
    const Truth t = truthOf(scene, requestOf(view.width, view.height));
    uint32_t seen = 0;
    for (uint32_t y = 0; y < view.height; ++y)
        for (uint32_t x = 0; x < view.width; ++x) {
            const size_t at = y * view.width + x;
            if (t.object[at] == kNone) continue;
            ++seen;
            const Real80 w = t.depth[at];
            const Vector80 p{(x + 0.5L - view.width / 2.0L) / test::kFocal * w, (view.height / 2.0L - y - 0.5L) / test::kFocal * w, -w};
            const Vector80 radial{p[0] - 0.25L, p[1] + 0.125L, p[2] + 4};
            EXPECT_LE(std::sqrt(dot80(radial, radial)), Real80(radius) * (1 + slack(1)));
            const Vector80 colour = phong80(scene, scene.materials[0], unit80(radial), p);
            for (size_t c = 0; c < 3; ++c)
                EXPECT_LE(std::abs(double(t.linear[3 * at + c] - colour[c])), slack(96 * 96) * 20 * 4) << x << ", " << y;
        }
    EXPECT_GT(seen, 2000u);
}

TEST(Truth, SamplesAreTheMeanOfALargerPicture) {
    Scene scene = test::sheet({64, 48}, 12);
    scene.camera->focalPixels = 0;
    scene.camera->fovYDegrees = 20;
    RenderRequest request = requestOf(64, 48, 4);
    request.background = {0.25f, 0.5f, 0.75f};
    const Truth four = truthOf(scene, request);
    RenderRequest large = requestOf(128, 96);
    large.background = request.background;
    const Truth one = truthOf(scene, large);
    EXPECT_GT(std::count_if(four.alpha.begin(), four.alpha.end(), [](double a) { return a > 0 && a < 1; }), 10);
    for (uint32_t y = 0; y < 48; ++y)
        for (uint32_t x = 0; x < 64; ++x) {
            const size_t at = y * 64 + x, corner = size_t(2 * y) * 128 + 2 * x;
            for (size_t c = 0; c < 3; ++c) {
                const double sum = one.linear[3 * corner + c] + one.linear[3 * (corner + 1) + c] + one.linear[3 * (corner + 128) + c] +
                                   one.linear[3 * (corner + 129) + c];
                ASSERT_EQ(four.linear[3 * at + c], sum / 4);
            }
            ASSERT_EQ(four.primitive[at], one.primitive[corner + 129]) << "the sample at (side / 2, side / 2) stands for the pixel";
            ASSERT_EQ(four.depth[at], one.depth[corner + 129]);
        }
}

// --- decisions --------------------------------------------------------------------------------------------------------------------------

// Screen corners on the grid of 1/256 px at depths that are powers of two: what is covered is known without rounding.
TEST(Truth, CoverageOnTheGridIsThatOfTheRationalWitness) {
    std::mt19937 random(5);
    const auto pick = [&](int low, int high) { return low + int(random() % uint32_t(high - low + 1)); };
    uint64_t covered = 0, redone = 0;
    for (int trial = 0; trial < 150; ++trial) {
        test::ScreenScene s(64, 48);
        s.scene.cullBackFaces = false;
        std::array<test::ScreenPoint, 3> corners{};
        oracle::SubpixelTriangle place{};
        const int step = trial % 3 == 0 ? 128 : trial % 3 == 1 ? 64 : 1;  // many samples exactly on edges and corners
        const auto onGrid = [&](int pixel) { return double((pixel * 256 + pick(0, 255)) & -step); };
        for (size_t i = 0; i < 3; ++i) {
            corners[i] = {onGrid(pick(-20, 84)), onGrid(pick(-20, 68)), std::exp2(pick(-3, 3))};
            place[i] = {int64_t(corners[i].x), int64_t(corners[i].y)};
        }
        s.add(corners);
        const Truth t = truthOf(s.scene, requestOf(64, 48));
        std::vector<bool> expected(64 * 48);
        for (const oracle::CoveredSpan& span : oracle::coveredSpans(place, 64, 48))
            for (int x = span.first; x < span.end; ++x) expected[size_t(span.row) * 64 + size_t(x)] = true, ++covered;
        for (size_t at = 0; at < expected.size(); ++at)
            ASSERT_EQ(t.object[at] != kNone, expected[at]) << "trial " << trial << ", pixel " << at % 64 << ", " << at / 64;
        redone += t.redone;
    }
    EXPECT_GT(covered, 20000u);
    EXPECT_GT(redone, 100u) << "ties must have been met, or nothing was tried";
    fmt::print("truth: {} pixels of 150 triangles on the grid, {} decisions without rounding, 0 differ\n", covered, redone);
}

// Where the passes need no rounding, what they see is what is there.
TEST(Truth, TiesInDepthAndOnEdgesGoWhereTheConventionsSay) {
    for (const char* name : {"throughCentres", "equalDepths", "soup"}) {
        const test::View view{131, 67};
        Scene scene = std::string(name) == "throughCentres" ? test::throughCentres(view)
                      : std::string(name) == "equalDepths"
                          ? test::equalDepths(view)
                          : [&] {
                                // Triangles parallel to the screen at depths 1, 2, 4: no depth is rounded.
                                test::Random r(3);
                                std::vector<test::Corners> triangles(120);
                                for (test::Corners& c : triangles) {
                                    const double w = std::exp2(std::floor(r(0, 3)));
                                    for (glm::vec3& p : c) p = view.pointAt(std::floor(r(-10, 141)) + 0.5, std::floor(r(-10, 77)) + 0.5, w);
                                }
                                return test::sceneOf(triangles);
                            }();
        uint64_t redone = 0, drawn = 0;
        for (const bool cull : {false, true})
            for (const bool left : {false, true})
                for (const bool mirror : {false, true}) {
                    scene.cullBackFaces = cull;
                    scene.leftHanded = left;
                    scene.objects[0].worldFromObject[0][0] = mirror ? -1 : 1;
                    const Frame frame = renderCpu(scene, requestOf(view.width, view.height)).frame;
                    const Truth t = truthOf(scene, requestOf(view.width, view.height));
                    uint64_t differing = 0;
                    redone += t.redone;
                    for (size_t at = 0; at < frame.primitive.size(); ++at) {
                        differing += frame.primitive[at] != t.primitive[at];
                        drawn += t.primitive[at] != kNone;
                    }
                    EXPECT_EQ(differing, 0u) << name << (cull ? " culled" : "") << (left ? " left-handed" : "")
                                             << (mirror ? " mirrored" : "");
                }
        EXPECT_GT(redone, 100u) << name;
        EXPECT_GT(drawn, 10000u) << name;
    }
}

TEST(Truth, ThreadsChangeNothing) {
    const Scene scene = test::soupSmall({131, 67});
    RenderRequest request = requestOf(131, 67, 4);
    request.threads = 1;
    const Truth one = truthOf(scene, request);
    request.threads = 3;
    const Truth three = truthOf(scene, request);
    EXPECT_EQ(one.linear, three.linear);
    EXPECT_EQ(one.primitive, three.primitive);
    EXPECT_EQ(one.redone, three.redone);
}

TEST(Truth, CanBeInterruptedAndRefusesWireFrames) {
    const Scene scene = test::soupSmall({131, 67});
    RenderRequest request = requestOf(131, 67);
    request.onProgress = [](double) { return false; };
    try {
        truthOf(scene, request);
        FAIL() << "not interrupted";
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::interrupted);
    }
    request.onProgress = nullptr;
    request.shading = Shading::wire;
    EXPECT_THROW(truthOf(scene, request), Error);
}

// --- the error of a picture -------------------------------------------------------------------------------------------------------------

Scene suzanne() { return test::committed(std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes/suzanne.toml", {160, 120}); }

FrameError errorOfTwin(const Scene& drawn, const Scene& real, Shading shading = Shading::phong, Encoding encoding = Encoding::srgb) {
    RenderRequest request = requestOf(160, 120);
    request.shading = shading;
    request.encoding = encoding;
    return errorOf(renderCpu(drawn, request).frame, truthOf(real, request), encoding, false);
}

// float32 and 1/256 px must cost something: an error of 0 would mean that a picture is compared with itself.
TEST(TruthError, IsNeverZeroByConstruction) {
    for (const char* file : {"suzanne.toml", "cornell.toml", "mug.toml", "still-life.toml", "pyramid.toml", "cylinder.toml"}) {
        Scene scene = loadScene({std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes" / file}, {});
        const glm::uvec2 size = scene.size.x != 0 && scene.camera->focalPixels > 0 ? scene.size : glm::uvec2(160, 120);
        completeScene(scene, size, "", false);
        for (const Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong}) {
            RenderRequest request = requestOf(size.x, size.y);
            request.shading = shading;
            const FrameError e = errorOf(renderCpu(scene, request).frame, truthOf(scene, request), Encoding::srgb, false);
            EXPECT_GT(e.linear.max, 0) << file;
            EXPECT_GT(e.unrounded.rms, 0) << file;
            EXPECT_GT(e.picture.rms, 0) << file;
            EXPECT_GT(e.depthRelative, 0) << file;
            EXPECT_GT(e.pixels, 500u) << file;
        }
    }
}

// Mean and root mean square are of one quantity: of all channels.
TEST(TruthError, TheMeanIsNeverAboveTheRootMeanSquare) {
    const Scene scene = suzanne();
    for (const bool transparent : {false, true})
        for (const Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong}) {
            RenderRequest request = requestOf(64, 48);
            request.shading = shading;
            request.transparent = transparent;
            const FrameError e = errorOf(renderCpu(scene, request).frame, truthOf(scene, request), request.encoding, transparent);
            for (const ErrorFigures& f : {e.picture, e.unrounded, e.linear}) {
                EXPECT_GT(f.mean, 0);
                EXPECT_LE(f.mean, f.rms);
                EXPECT_LE(f.rms, f.max);
            }
        }
}

// The scene's own model is no error; another viewer than the scene's is.
TEST(TruthError, TheTruthHasTheViewerOfTheScene) {
    Scene scene = suzanne();
    RenderRequest request = requestOf(64, 48);
    const auto errorFor = [&](bool asked, bool drawn) {
        scene.distantViewer = asked;
        request.distantViewer = drawn;
        return errorOf(renderCpu(scene, request).frame, truthOf(scene, request), request.encoding, false).linear.rms;
    };
    const double local = errorFor(false, false), distant = errorFor(true, true);
    EXPECT_LT(distant, 2 * local) << "float32 and snapping cost the same for either viewer";
    EXPECT_GT(errorFor(false, true), 16 * local);
    EXPECT_GT(errorFor(true, false), 16 * local);
}

TEST(TruthError, OrdersTheShadings) {
    const Scene scene = suzanne();
    const double unlit = errorOfTwin(scene, scene, Shading::unlit).picture.rms, flat = errorOfTwin(scene, scene, Shading::flat).picture.rms,
                 gouraud = errorOfTwin(scene, scene, Shading::gouraud).picture.rms;
    const FrameError phong = errorOfTwin(scene, scene);
    EXPECT_GT(unlit, flat);
    EXPECT_GT(flat, gouraud);
    EXPECT_GT(gouraud, phong.picture.rms);
    // Rounding to bytes alone is half a step; what remains of Phong's picture is that and pixels at edges.
    EXPECT_LE(phong.picture.mean, 0.5);
    fmt::print(
        "suzanne 160x120, rms in steps of 1/255: unlit {:.2f}, flat {:.2f}, gouraud {:.2f}, phong {:.3f}; phong linear "
        "max {:.2g}, wrong {} of {}\n",
        unlit, flat, gouraud, phong.picture.rms, phong.linear.max, phong.wrongPrimitive, phong.pixels);
}

// The fewer directions, the further from the truth, under a lamp that is near; faces are small here.
TEST(TruthError, DirectionsOfVerticesFacesAndTheSceneCostInThisOrder) {
    Scene scene = suzanne();
    for (Light& light : scene.lights) {
        light.directional = false;
        light.position = scene.camera->eye + glm::dvec3(0.5, 0.5, 0);
    }
    RenderRequest request = requestOf(160, 120);
    const Truth t = truthOf(scene, request);
    using Vectors = Trade::Vectors;
    double before = 0;
    for (const Vectors vectors : {Vectors::pixel, Vectors::vertex, Vectors::face, Vectors::scene}) {
        request.trade.vectors = vectors;
        const double rms = errorOf(renderCpu(scene, request).frame, t, Encoding::srgb, false).linear.rms;
        EXPECT_GT(rms, before) << int(vectors);
        before = rms;
    }
}

// The more accurate transforms gain where the products of float32 cancel: an object far from its own origin, near the eye.
TEST(TruthError, LongTransformsGain) {
    Scene scene = suzanne();
    for (TriangleMesh& mesh : scene.meshes) {
        for (glm::vec3& p : mesh.positions) p.x += 8192.0f;
        mesh.stated.clear();  // the file's numbers are of another mesh now
        mesh.boundsMin.x += 8192.0f;
        mesh.boundsMax.x += 8192.0f;
    }
    for (Object& object : scene.objects) object.worldFromObject[3] -= object.worldFromObject[0] * 8192.0;
    RenderRequest request = requestOf(160, 120);
    const Truth t = truthOf(scene, request);
    request.knobs.float32Only = true;  // else the plan takes more for the object by itself
    const FrameError single = errorOf(renderCpu(scene, request).frame, t, Encoding::srgb, false);
    request.knobs.float32Only = false;
    for (const Precision precision : {Precision::blockInteger, Precision::fp64}) {
        request.trade.precision = precision;
        const FrameError longer = errorOf(renderCpu(scene, request).frame, t, Encoding::srgb, false);
        EXPECT_LT(longer.unrounded.rms, single.unrounded.rms) << int(precision);
        EXPECT_LT(2 * longer.wrongPrimitive, single.wrongPrimitive) << int(precision);
    }
}

// What is traded away costs: each choice of the trade is further from the truth than the default.
TEST(TruthError, EveryTradeCosts) {
    const Scene scene = suzanne();
    RenderRequest request = requestOf(160, 120);
    const Truth t = truthOf(scene, request);
    const FrameError clean = errorOf(renderCpu(scene, request).frame, t, Encoding::srgb, false);
    const auto errorWith = [&](auto change) {
        RenderRequest traded = request;
        change(traded.trade);
        return errorOf(renderCpu(scene, traded).frame, t, Encoding::srgb, false);
    };
    EXPECT_GT(errorWith([](Trade& x) { x.specular = Trade::Specular::schlick; }).linear.rms, clean.linear.rms);
    EXPECT_GT(errorWith([](Trade& x) { x.vectors = Trade::Vectors::scene; }).linear.rms, clean.linear.rms);
    EXPECT_GT(errorWith([](Trade& x) { x.affine = true; }).linear.rms, clean.linear.rms);
    EXPECT_GT(errorWith([](Trade& x) { x.depthBits = 16; }).depthRelative, clean.depthRelative);
    EXPECT_GT(errorWith([](Trade& x) { x.depthBits = Trade::kStandardDepth; }).depthRelative, clean.depthRelative);
    EXPECT_GT(errorWith([](Trade& x) { x.unitNormals = false; }).linear.rms, clean.linear.rms);
    EXPECT_GT(errorWith([](Trade& x) { x.coarse = true; }).linear.rms, clean.linear.rms);
    const FrameError coarse = errorWith([](Trade& x) { x.subpixelBits = 4; });
    EXPECT_GT(coarse.depthRelative, clean.depthRelative);
    EXPECT_GT(coarse.wrongPrimitive, clean.wrongPrimitive);
}

// Each planted mistake raises the figure that is there to notice it.
TEST(TruthError, NoticesPlantedMistakes) {
    const Scene real = suzanne();
    const FrameError clean = errorOfTwin(real, real);
    const auto expectWorse = [&](const char* what, const Scene& drawn, double ErrorFigures::*figure) {
        FrameError e = errorOfTwin(drawn, real);
        EXPECT_GT(e.linear.*figure, clean.linear.*figure) << what;
        EXPECT_GT(e.unrounded.*figure, clean.unrounded.*figure) << what;
        return e;
    };
    Scene drawn = real;
    drawn.lights[0].direction.x += 1e-3;
    expectWorse("a light moved by 1e-3", drawn, &ErrorFigures::rms);
    drawn = real;
    drawn.materials[0].shininess *= 1.001f;
    for (Material& m : drawn.materials) m.shininess *= 1.001f;
    expectWorse("a specular exponent off by 0.1 %", drawn, &ErrorFigures::rms);
    drawn = real;
    for (Material& m : drawn.materials) m.diffuse.y += 1e-4f;
    expectWorse("green off by 1e-4", drawn, &ErrorFigures::mean);
    drawn = real;
    drawn.camera->eye.x += 1e-2;
    EXPECT_GT(expectWorse("an eye moved by 1e-2", drawn, &ErrorFigures::p99).wrongShare(), clean.wrongShare());
    drawn = real;
    drawn.meshes[0].triangles.resize(drawn.meshes[0].triangles.size() / 2);
    EXPECT_GT(errorOfTwin(drawn, real).wrongShare(), 0.1);
    drawn = real;
    drawn.objects[0].worldFromObject[3][2] += 1e-3;
    EXPECT_GT(errorOfTwin(drawn, real).depthRelative, clean.depthRelative);
}

TEST(TruthError, OnePixelIsFoundAndCounted) {
    const Scene scene = suzanne();
    const RenderRequest request = requestOf(160, 120);
    const Truth t = truthOf(scene, request);
    const Frame clean = renderCpu(scene, request).frame;
    const FrameError before = errorOf(clean, t, Encoding::srgb, false);
    Frame broken = clean;
    const size_t at = 60 * 160 + 80;
    ASSERT_NE(broken.object[at], kNone);
    broken.rgba[at] ^= 0x00008000u;  // green by 128 steps
    broken.primitive[at] += 1;
    const FrameError e = errorOf(broken, t, Encoding::srgb, false);
    EXPECT_EQ(e.wrongPrimitive, before.wrongPrimitive + 1);
    EXPECT_EQ(e.picture.x, 80u);
    EXPECT_EQ(e.picture.y, 60u);
    EXPECT_GE(e.picture.max, 127.5);
    EXPECT_LE(e.picture.max, 128.5);
    EXPECT_GT(e.perPixel[at], before.perPixel[at]);
    EXPECT_EQ(e.linear.max, before.linear.max);
}

TEST(TruthError, ANumberThatIsNoneFailsFirst) {
    const Scene scene = suzanne();
    const RenderRequest request = requestOf(160, 120);
    const Truth t = truthOf(scene, request);
    Frame frame = renderCpu(scene, request).frame;
    frame.linear[3 * (60 * 160 + 80) + 1] = std::nanf("");
    try {
        errorOf(frame, t, Encoding::srgb, false);
        FAIL() << "an error was measured";
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::failed);
        EXPECT_NE(std::string(error.what()).find("(80, 60)"), std::string::npos) << error.what();
    }
}

TEST(TruthError, BothCurvesAreMeasuredInTheSameSteps) {
    const Scene scene = suzanne();
    const FrameError srgb = errorOfTwin(scene, scene), linear = errorOfTwin(scene, scene, Shading::phong, Encoding::linear);
    EXPECT_EQ(srgb.linear.max, linear.linear.max) << "the curve does not change the light";
    EXPECT_GT(linear.picture.rms, srgb.picture.rms) << "a linear byte is coarse in the dark";
}

TEST(TruthError, TransparencyIsAChannel) {
    const Scene scene = suzanne();
    RenderRequest request = requestOf(160, 120, 4);
    request.transparent = true;
    const Truth t = truthOf(scene, request);
    Frame frame = renderCpu(scene, request).frame;
    const FrameError clean = errorOf(frame, t, Encoding::srgb, true);
    uint64_t partly = 0;
    for (const double a : t.alpha) partly += a > 0 && a < 1;
    EXPECT_GT(partly, 100u);
    const size_t at = 60 * 160 + 80;
    frame.rgba[at] &= 0x00ffffffu;
    const FrameError e = errorOf(frame, t, Encoding::srgb, true);
    EXPECT_GT(e.picture.max, clean.picture.max);
    EXPECT_EQ(e.picture.max, 255);
}

}  // namespace
}  // namespace plumb
