// SPDX-License-Identifier: MIT
// Implicit spheres against the formulas of 16.5 in long double, from the scene: every pixel of pictures with overlapping spheres, lights of every kind and
// exponents from 0 to 10^6. Shares no code with the pass. The truth of such pictures against the same formulas and by exact ties.
#include "host/error.h"
#include "pipeline/render/render.h"
#include "pipeline/truth/frame_error.h"
#include "pipeline/truth/highlight_error.h"
#include "tests/support/compare.h"
#include "tests/support/scenes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

namespace plumb::test {
namespace {

using Real80 = long double;
using Vector = glm::vec<3, Real80>;

// What computes: a rounding to nearest, the error of its power, and below what its power is 0.
struct Precision {
    Real80 unit, powerError, powerFloor;
};
constexpr Real80 kFloatUnit = 0x1p-24L;
constexpr Precision kPass{kFloatUnit, (1.7e-7L + 4 * kFloatUnit) / 2.718281828L + 7.5e-8L + 3 * kFloatUnit, 0x1p-20L};
// The C library's hypot and pow may be off by a unit in the last place, 2 u, where the pass rounds once, and twice in a row.
constexpr Real80 kDoubleUnit = 4 * 0x1p-53L;
constexpr Precision kTruth{kDoubleUnit, kDoubleUnit, 0};

Real80 lengthOf(const Vector& v) { return std::sqrt(glm::dot(v, v)); }

Scene spheresScene(uint32_t seed, uint32_t count, bool whole) {
    Random r(seed);
    Scene scene;
    scene.path = "spheres";
    scene.leftHanded = true;
    scene.wholeSphereHeights = whole;
    scene.ambient = glm::vec3(0.25f);
    Camera camera;
    camera.eye = {0, 0, -600};
    camera.forward = {0, 0, 1};
    camera.focalPixels = camera.focusDistance = 600;
    scene.camera = camera;
    for (float n : {0.0f, 1.0f, 4.0f, 60.0f, 1e6f}) {
        Material m;
        m.ambient = {0.1f, 0.4f, 0.2f};
        m.diffuse = {0.3f, 0.6f, 0.1f};
        m.specular = glm::vec3(0.4f);
        m.shininess = n;
        scene.materials.push_back(m);
    }
    for (uint32_t i = 0; i < count; ++i)
        scene.spheres.push_back({"", {r(-90, 90), r(-70, 70), r(-40, 40)}, i % 2 ? double(5 + r.below(40)) : r(1, 40), r.below(5)});
    for (uint32_t i = 0; i < 5; ++i) {
        Light light;
        light.directional = i < 2;
        light.direction = {r(-1, 1), r(-1, 1), r(-1, 0.2)};
        light.position = {r(-200, 200), r(-200, 200), r(-400, -100)};
        light.intensity = glm::vec3(i < 2 ? 0.3f : i == 2 ? 0.2f : i == 3 ? 40.0f : 9000.0f);
        light.attenuation = i < 3 ? Attenuation::none : i == 3 ? Attenuation::inverse : Attenuation::inverseSquare;
        scene.lights.push_back(light);
    }
    return scene;
}

RenderRequest requestOf(uint32_t width, uint32_t height) {
    RenderRequest r;
    r.width = width;
    r.height = height;
    r.fill = Fill::notes;
    r.planes = kEveryPlane;
    return r;
}

struct Verdict {
    uint64_t pixels = 0, undecidedDepth = 0, edgeOfLight = 0;
    Real80 worst = 0;
};

// The spheres over a pixel, nearest first.
struct Candidate {
    size_t sphere;
    Real80 x, y, z, depth;
};

template <class Number>
void expectColour(const Scene& scene, const Candidate& c, const Number* drawn, const Precision& precision, Verdict& v) {
    const Real80 kUnit = precision.unit;
    // Direction of the unit normal: z (1 u) and the last product (1 u) of each component.
    const Real80 kNormalError = 2 * kUnit * 1.7320509L;
    // Length that unitVector leaves (fill_oracle_test.cpp derives it).
    const Real80 kUnitLengthError = 6.5L * kUnit;
    const SphereShape& s = scene.spheres[c.sphere];
    const Material& m = scene.materials[s.material];
    const Vector normal = Vector(c.x, c.y, -c.z) / lengthOf({c.x, c.y, c.z}), view(0, 0, -1);
    const Vector position = Vector(s.centre) + Vector(c.x, c.y, -c.z);
    const Real80 normalError = kNormalError + kUnitLengthError;
    Vector colour(0), bound(0);
    for (int i = 0; i < 3; ++i) {
        colour[i] = Real80(m.ambient[i]) * Real80(scene.ambient[i]) + Real80(m.emission[i]);
        bound[i] = 2 * kUnit * colour[i];
    }
    for (const Light& light : scene.lights) {
        const Vector toLight = light.directional ? Vector(light.direction) : Vector(light.position) - position;
        const Real80 distance = light.directional ? 1 : lengthOf(toLight);
        const Vector l = toLight / lengthOf(toLight);
        // Directional: a rounding a component, one more of the host's own. A place: light and point are rounded once relative to the eye, the point's sum
        // and the difference once more, each of lengths below those from the eye.
        const Vector eye(scene.camera->eye);
        const Real80 lightError =
            light.directional
                ? 2 * kUnit * 1.7320509L
                : 1.7320509L * kUnit * (lengthOf(Vector(light.position) - eye) + 3 * lengthOf(position - eye) + distance) / distance +
                      kUnitLengthError;
        const int power = int(light.attenuation);
        const Real80 fade = light.directional ? 1 : std::pow(distance, Real80(-power)),
                     fadeError = power * (lightError + kUnitLengthError) + 2 * kUnit;
        const Real80 nl = glm::dot(normal, l), nlError = normalError + lightError + 3 * kUnit;
        const bool lit = nl > 0, edge = std::abs(nl) <= nlError;
        v.edgeOfLight += edge;
        const Real80 n = m.shininess, rv = glm::dot(Real80(2) * nl * normal - l, view);
        const Real80 highlight = n == 0 ? 1 : std::pow(std::max<Real80>(rv, 0), n);
        const Real80 mirrorError = 2 * (normalError + nlError) + lightError + 4 * kUnit;
        const Real80 floor = rv < 0.01L ? precision.powerFloor : 0;
        const Real80 powerError = n == 0 ? 0 : truth::highlightError(n, mirrorError, floor) + precision.powerError;
        for (int i = 0; i < 3; ++i) {
            const Real80 intensity = Real80(light.intensity[i]) * fade,
                         term = (lit ? Real80(m.diffuse[i]) * nl + Real80(m.specular[i]) * highlight : 0) * intensity;
            colour[i] += term;
            bound[i] += intensity * (Real80(m.diffuse[i]) * nlError +
                                     Real80(m.specular[i]) * (lit || edge ? powerError + (edge ? highlight : 0) : 0)) +
                        (fadeError + (4 + Real80(scene.lights.size())) * kUnit) * (term + colour[i]);
        }
    }
    for (int i = 0; i < 3; ++i) {
        const Real80 error = std::abs(Real80(drawn[i]) - colour[i]);
        EXPECT_LE(error, bound[i]) << "sphere " << c.sphere << " at (" << double(c.x) << ", " << double(c.y) << ") "
                                   << "RGB"[i] << ": drawn " << drawn[i] << ", formula " << double(colour[i]);
        v.worst = std::max(v.worst, error / bound[i]);
    }
}

// Nearest first; of equal depths the first of the scene.
std::vector<Candidate> candidates(const Scene& scene, uint32_t width, uint32_t height, uint32_t column, uint32_t row) {
    std::vector<Candidate> over;
    for (size_t i = 0; i < scene.spheres.size(); ++i) {
        const SphereShape& s = scene.spheres[i];
        const Real80 x = Real80(column) - std::nearbyint(width / 2.0L + Real80(s.centre.x)),
                     y = std::nearbyint(height / 2.0L - Real80(s.centre.y)) - Real80(row);
        const Real80 rest = std::floor(Real80(s.radius) * Real80(s.radius)) - x * x - y * y;
        if (rest < 0) continue;
        const Real80 root = std::sqrt(rest), z = scene.wholeSphereHeights ? std::nearbyint(root) : root;
        over.push_back({i, x, y, z, Real80(s.centre.z) - z - Real80(scene.camera->eye.z)});
    }
    std::stable_sort(over.begin(), over.end(), [](const Candidate& a, const Candidate& b) { return a.depth < b.depth; });
    return over;
}

void expectFormula(const Scene& scene, const Frame& frame, Verdict& v) {
    const Real80 kUnit = kPass.unit;
    for (uint32_t row = 0; row < frame.height; ++row)
        for (uint32_t column = 0; column < frame.width; ++column) {
            const size_t at = size_t(row) * frame.width + column;
            const std::vector<Candidate> over = candidates(scene, frame.width, frame.height, column, row);
            ASSERT_EQ(frame.object[at] == kNone, over.empty()) << "pixel (" << column << ", " << row << ")";
            if (over.empty()) continue;
            ++v.pixels;
            const auto seen = std::find_if(over.begin(), over.end(), [&](const Candidate& c) { return c.sphere == frame.object[at]; });
            ASSERT_NE(seen, over.end()) << "pixel (" << column << ", " << row << ") shows a sphere that is not there";
            // Depth: the centre, z, the difference and the division by the unit are rounded once each.
            const Real80 depthError = kUnit * (3 * seen->depth + 2 * seen->z);
            EXPECT_LE(seen->depth - over[0].depth, 2 * depthError) << "pixel (" << column << ", " << row << ")";
            v.undecidedDepth += seen != over.begin();
            EXPECT_LE(std::abs(Real80(frame.depth[at]) - seen->depth), depthError);
            expectColour(scene, *seen, &frame.linear[3 * at], kPass, v);
        }
}

TEST(SpheresOracle, EveryPixelFollowsTheFormula) {
    Verdict v;
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        const Scene scene = spheresScene(seed, 12, seed % 2 == 0);
        expectFormula(scene, renderCpu(scene, requestOf(seed % 3 ? 200 : 181, 151)).frame, v);
        if (HasFatalFailure()) return;
    }
    std::printf(
        "implicit spheres: %llu pixels, %llu at undecided depth, %llu at the edge of a light, at most %.3f of the "
        "bound\n",
        static_cast<unsigned long long>(v.pixels), static_cast<unsigned long long>(v.undecidedDepth),
        static_cast<unsigned long long>(v.edgeOfLight), double(v.worst));
    EXPECT_GT(v.pixels, 10000u);
    EXPECT_GT(v.worst, 0) << "compared with itself";
}

// Centres on whole pixels and whole radii, where pass and truth mean the same points.
TEST(SpheresTruth, IsTheFormulaAtEveryPixelAndSeesWhatThePassSees) {
    Verdict v;
    for (uint32_t seed = 1; seed <= 4; ++seed) {
        Scene scene = spheresScene(seed, 12, false);
        for (SphereShape& s : scene.spheres) {
            s.centre.x = std::nearbyint(s.centre.x);
            s.centre.y = std::nearbyint(s.centre.y);
            s.radius = std::nearbyint(s.radius);
        }
        const RenderRequest request = requestOf(200, 150);
        const Truth truth = truthOf(scene, request);
        for (uint32_t row = 0; row < 150; ++row)
            for (uint32_t column = 0; column < 200; ++column) {
                const size_t at = size_t(row) * 200 + column;
                const std::vector<Candidate> over = candidates(scene, 200, 150, column, row);
                ASSERT_EQ(truth.object[at], over.empty() ? kNone : uint32_t(over[0].sphere)) << column << ", " << row;
                ASSERT_EQ(truth.alpha[at], over.empty() ? 0 : 1);
                if (over.empty()) continue;
                ++v.pixels;
                EXPECT_LE(std::abs(Real80(truth.depth[at]) - over[0].depth), kDoubleUnit * (3 * over[0].depth + 2 * over[0].z));
                expectColour(scene, over[0], &truth.linear[3 * at], kTruth, v);
            }
        const FrameError error = errorOf(renderCpu(scene, request).frame, truth, request.encoding, false);
        EXPECT_EQ(error.wrongPrimitive, 0u) << "no two of these fronts are as near as a float's rounding";
        EXPECT_GT(error.unrounded.max, 0) << "compared with itself";
        scene.wholeSphereHeights = true;
        const FrameError whole = errorOf(renderCpu(scene, request).frame, truth, request.encoding, false);
        EXPECT_EQ(whole.pixels, error.pixels);
        EXPECT_GT(whole.unrounded.rms, error.unrounded.rms) << "the truth does not round heights";
    }
    EXPECT_GT(v.pixels, 10000u);
    EXPECT_GT(v.worst, 0);
}

Scene twoSpheres(const SphereShape& first, const SphereShape& second) {
    Scene scene = spheresScene(1, 0, false);
    scene.spheres = {first, second};
    return scene;
}

// What pixel (x, y) from the middle, y up, shows.
uint32_t seenAt(const Scene& scene, int x, int y) {
    const Truth truth = truthOf(scene, requestOf(64, 64));
    return truth.object[size_t(32 - y) * 64 + size_t(32 + x)];
}

TEST(SpheresTruth, DecidesWithoutRounding) {
    // On the rim: 3, 4, 5.
    const SphereShape none{"", {1000, 0, 0}, 1, 0}, five{"", {0, 0, 0}, 5, 0};
    for (const auto& [x, y] : {std::pair(3, 4), std::pair(-4, 3), std::pair(5, 0), std::pair(0, -5)}) {
        EXPECT_EQ(seenAt(twoSpheres(five, none), x, y), 0u);
        EXPECT_EQ(seenAt(twoSpheres({"", {0, 0, 0}, std::nextafter(5.0, 0.0), 0}, none), x, y), kNone);
        EXPECT_EQ(seenAt(twoSpheres({"", {0x1p-80, 0x1p-80, 0}, 5, 0}, none), x, y), x + y > 0 ? 0u : kNone);
    }
    // Equal depths where two equal spheres meet: the first is seen.
    const SphereShape left{"", {-4, 0, 0}, 5, 0}, right{"", {4, 0, 0}, 5, 0};
    for (int y = -3; y <= 3; ++y) EXPECT_EQ(seenAt(twoSpheres(left, right), 0, y), 0u);
    EXPECT_EQ(seenAt(twoSpheres(left, {"", {4 - 0x1p-60, 0, 0}, 5, 0}), 0, 1), 0u) << "4 - 2^-60 is 4 in binary64: the same";
    EXPECT_EQ(seenAt(twoSpheres(left, {"", {4 - 0x1p-50, 0, 0}, 5, 0}), 0, 1), 1u);
    // A larger sphere behind a smaller one whose fronts touch: 0 - 5 = 8 - 13.
    for (const double moved : {-0x1p-40, 0.0, 0x1p-40}) {
        const SphereShape thirteen{"", {0, 0, 8 + moved}, 13, 0};
        EXPECT_EQ(seenAt(twoSpheres(five, thirteen), 0, 0), moved < 0 ? 1u : 0u) << moved;
        EXPECT_EQ(seenAt(twoSpheres(thirteen, five), 0, 0), moved > 0 ? 1u : 0u) << moved;
        EXPECT_EQ(seenAt(twoSpheres(five, thirteen), 3, 4), 1u);
    }
    const Truth truth = truthOf(twoSpheres(left, right), requestOf(64, 64));
    EXPECT_GT(truth.redone, 0u);
}

TEST(SpheresTruth, SamplesShareAPixelByArea) {
    Scene scene = spheresScene(1, 0, false);
    scene.spheres = {{"", {0.25, -0.5, 0}, 20.5, 0}};
    RenderRequest request = requestOf(64, 64);
    request.samples = 16;
    const Truth truth = truthOf(scene, request);
    Real80 area = 0;
    for (const double a : truth.alpha) area += a;
    // The lattice of the samples has a cell of 1/4: fewer than pi / 4 (2 sqrt(2) r + 1/2) of area are in cells that the rim cuts.
    EXPECT_LE(std::abs(area - 3.14159265L * 20.5L * 20.5L), 3.14159265L / 4 * (2 * 1.4142136L * 20.5L + 0.5L));
    EXPECT_GT(std::count_if(truth.alpha.begin(), truth.alpha.end(), [](double a) { return a > 0 && a < 1; }), 50);
    // Around the whole coordinate: what is a half plane there covers half of its samples.
    scene.spheres = {{"", {4000, 0, 0}, 4000, 0}};
    const Truth half = truthOf(scene, request);
    EXPECT_EQ(half.alpha[32 * 64 + 32], 0.5);
}

std::string refusalOf(const Scene& scene, const RenderRequest& request, Exit exit) {
    try {
        renderCpu(scene, request);
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), exit) << error.what();
        return error.what();
    }
    return "drawn";
}

TEST(SpheresOracle, WhatCannotBeDrawnIsRefusedBySentence) {
    const RenderRequest request = requestOf(64, 48);
    const auto with = [](const auto& change) {
        Scene scene = spheresScene(1, 2, false);
        scene.spheres = {{"ball", {0, 0, 0}, 10, 0}};
        change(scene);
        return scene;
    };
    EXPECT_EQ(refusalOf(with([](Scene&) {}), request, Exit::done), "drawn");
    EXPECT_EQ(refusalOf(with([](Scene& s) { s.spheres[0].radius = 0.5; }), request, Exit::input),
              "spheres: sphere 'ball': its radius is 0.5; --fill notes draws spheres of 1 to 4096 pixels");
    EXPECT_EQ(refusalOf(with([](Scene& s) { s.spheres[0].radius = 4097; }), request, Exit::input),
              "spheres: sphere 'ball': its radius is 4097; --fill notes draws spheres of 1 to 4096 pixels");
    EXPECT_EQ(refusalOf(with([](Scene& s) { s.spheres[0].centre.z = -595; }), request, Exit::input),
              "spheres: sphere 'ball': it reaches behind the near plane, and --fill notes cuts no spheres: move it or "
              "the viewer");
    EXPECT_EQ(refusalOf(with([](Scene& s) { s.spheres[0].centre.x = 1e29; }), request, Exit::input),
              "spheres: sphere 'ball': it is further from the eye than 2^60 times the near plane");
    EXPECT_EQ(refusalOf(with([](Scene& s) { s.camera->focalPixels = 0; }), request, Exit::input),
              "spheres: --fill notes draws spheres for the viewer of camera.distance, a pixel a unit");
    EXPECT_EQ(refusalOf(with([](Scene& s) { s.planes.push_back({}); }), request, Exit::input),
              "spheres: it has spheres or planes, which only --shading ray draws, spheres --fill notes too");
    EXPECT_EQ(refusalOf(with([](Scene& s) { s.lights.resize(10001); }), request, Exit::input),
              "spheres: 10001 lights; --fill notes draws spheres under at most 10000");
    RenderRequest other = request;
    other.shading = Shading::gouraud;
    EXPECT_EQ(refusalOf(with([](Scene&) {}), other, Exit::usage), "--fill notes illuminates spheres at each pixel: --shading phong");
    other = request;
    other.samples = 4;
    EXPECT_EQ(refusalOf(with([](Scene&) {}), other, Exit::usage), "--fill notes draws one sample a pixel: leave --samples out");
}

}  // namespace
}  // namespace plumb::test
