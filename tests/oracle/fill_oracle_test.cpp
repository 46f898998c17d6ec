// SPDX-License-Identifier: MIT
// The drawn picture against witnesses that share no function with the passes: rational spans for coverage, lavapipe's fixed-function
// rasteriser for the whole fill, binary128 planes for depth, and Phong's formula in long double for colour. Everything is derived from
// the snapped screen vertices, so that snapping does not enter; the vertices themselves are checked against binary64 projection.
#include "pipeline/passes/encode.h"
#include "pipeline/passes/lines.h"
#include "pipeline/render/raster/twin_frame.h"
#include "pipeline/scene/load.h"
#include "pipeline/truth/highlight_error.h"
#include "shared/bounds.h"
#include "tests/oracle/coverage_oracle.h"
#include "tests/oracle/fixed_function.h"
#include "tests/oracle/screen_scene.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <bit>
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

using oracle::SubpixelTriangle;
__extension__ typedef __float128 Quad;
using Real80 = long double;

constexpr double kUnit = 0x1p-24;  // u, unit round-off of float32

// Depth (fill.h, depthPlane and depthBits), to first order, F = f1 |z1 - z0| + f2 |z2 - z0| with f the exact barycentric weights:
// the reciprocal of the area has 3 u (two roundings of the sum, one of the division), k 5 u (difference, product), e k 7 u (e rounded,
// product) and rho k 6 u, so both parts together 7 u F; three additions of parts below F: 3 u F; the addition of z0 and the last one:
// u z0 + u z. Second order is below 1 % of that.
constexpr double kDepthErrorOfSpan = gpu::kDepthSpanUnits * kUnit, kDepthErrorOfSum = gpu::kDepthSumUnits * kUnit;

// The vertices (transform.h): rows rounded once (1 u) and four products summed in order (4 u) of S = sum |m v|; the quotient, the added
// centre, then half a sub-pixel.
constexpr double kRowError = gpu::kRowUnits * kUnit;
constexpr double kSnapPixels = 0x1p-9;

struct Drawn {
    SubpixelTriangle place;
    double z[3];
    uint32_t source;
    const uint32_t* vertex;  // of the triangle's corners in screen and attributes
};

// What the picture must consist of: triangles inside every plane straight from the scene's list, clipped ones as the fan left them.
// Back faces and triangles without area are left out here, by 128-bit area.
std::vector<Drawn> drawnTriangles(const DrawList& list, const TwinGeometry& g) {
    std::vector<Drawn> drawn;
    const auto add = [&](const uint32_t* v, uint32_t source) {
        Drawn d{{}, {}, source, v};
        for (size_t i = 0; i < 3; ++i) {
            d.place[i] = {g.screen[v[i]].x, g.screen[v[i]].y};
            d.z[i] = g.screen[v[i]].z;
        }
        const __int128_t area = __int128_t(d.place[1].y - d.place[0].y) * (d.place[2].x - d.place[0].x) -
                                __int128_t(d.place[1].x - d.place[0].x) * (d.place[2].y - d.place[0].y);
        if (area > 0 || (area < 0 && !list.cullBackFaces)) drawn.push_back(d);
    };
    std::vector<std::vector<const gpu::DrawTriangle*>> fans(list.triangles.size());
    for (const gpu::DrawTriangle& d : g.draws)
        if (d.vertex[0] >= list.positions.size() && d.vertex[0] != d.vertex[1]) fans[d.source].push_back(&d);
    for (uint32_t t = 0; t < list.triangles.size(); ++t) {
        const uint32_t* v = &list.triangles[t].x;
        if ((g.screen[v[0]].outcode | g.screen[v[1]].outcode | g.screen[v[2]].outcode) == 0)
            add(v, t);
        else
            for (const gpu::DrawTriangle* d : fans[t]) add(d->vertex, t);
    }
    return drawn;
}

// Weights of the corners at a pixel centre, exact in binary128: the ray through the centre meets the plane of the three corners.
struct AtPixel {
    Quad weight[3];  // sum 1
    double z, bound;
};
AtPixel exactly(const Drawn& d, int x, int y) {
    const Quad px = Quad(x) * 256 + 128, py = Quad(y) * 256 + 128;
    AtPixel a{};
    Quad area = 0;
    for (int i = 0; i < 3; ++i) {
        const oracle::SubpixelPoint &b = d.place[size_t(i + 1) % 3], &c = d.place[size_t(i + 2) % 3];
        a.weight[i] = (Quad(b.x) - px) * (Quad(c.y) - py) - (Quad(b.y) - py) * (Quad(c.x) - px);
        area += a.weight[i];
    }
    Quad z = 0;
    for (int i = 0; i < 3; ++i) {
        a.weight[i] /= area;
        z += a.weight[i] * Quad(d.z[i]);
    }
    a.z = double(z);
    // The passes start from the lowest corner; the bound takes the worst of the three.
    double span = 0, most = 0;
    for (int i = 0; i < 3; ++i) {
        double here = 0;
        for (int j = 0; j < 3; ++j) here += double(a.weight[j]) * std::abs(d.z[j] - d.z[i]);
        span = std::max(span, here);
        most = std::max(most, d.z[i]);
    }
    a.bound = kDepthErrorOfSpan * span + kDepthErrorOfSum * (most + a.z);
    return a;
}

struct Picture {
    Scene scene;
    RenderRequest request;
    Prepared prepared;
    TwinGeometry geometry;
    Frame frame;
    std::vector<Drawn> drawn;

    Picture(Scene s, const RenderRequest& r) : scene(std::move(s)), request(r), prepared(prepare(scene, r)) {
        geometry = twinGeometry(prepared.list, prepared.choices, false, 0);
        frame = renderCpu(scene, request).frame;
        drawn = drawnTriangles(prepared.list, geometry);
    }
    // In scene units: as stated, or the largest power of two not above 2^-10 of the distance in focus.
    float near() const {
        return float(scene.camera->near > 0 ? scene.camera->near : std::exp2(std::floor(std::log2(scene.camera->focusDistance)) - 10));
    }
    int width() const { return int(request.width); }
    int height() const { return int(request.height); }
};

RenderRequest requestOf(uint32_t width, uint32_t height) {
    RenderRequest request;
    request.width = width;
    request.height = height;
    request.planes = kPlaneColour | kPlaneLinear | kPlaneZ | kPlaneTriangle | kPlaneNormal;
    return request;
}

Scene committed(const std::string& file, uint32_t width, uint32_t height, const std::string& view = "") {
    const std::filesystem::path path = std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes" / file;
    Scene scene = loadScene({path}, {});
    completeScene(scene, {width, height}, view, isBareMesh(path));
    return scene;
}

// Triangles of every size, some behind the eye and far outside the frame, at depths from the near plane to 100.
Picture soup(uint32_t seed, uint32_t width, uint32_t height, int count, bool exactCorners) {
    test::ScreenScene s(width, height);
    s.request = requestOf(width, height);
    std::mt19937 random(seed);
    const auto pick = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
    for (int t = 0; t < count; ++t) {
        const double extent = 256 * std::exp2(pick(-1, exactCorners ? 7 : 12)), x = pick(0, width * 256.0), y = pick(0, height * 256.0);
        std::array<test::ScreenPoint, 3> corners{};
        for (test::ScreenPoint& c : corners) {
            c.x = x + pick(-extent, extent);
            c.y = y + pick(-extent, extent);
            c.w = exactCorners ? std::exp2(std::floor(pick(-4, 4))) : pick(0, 10) < 1 ? pick(-1, 0.01) : std::exp2(pick(-6, 6.6));
            if (exactCorners) c.x = std::floor(c.x), c.y = std::floor(c.y);
        }
        s.add(corners);
    }
    s.scene.cullBackFaces = seed % 2 == 0;
    return {std::move(s.scene), s.request};
}

// Every pixel: covered exactly when a witness triangle covers it, by one that does, at its depth, and none is nearer by more than both bounds.
void expectExactFill(const Picture& p, const std::string& name) {
    const size_t pixels = size_t(p.width()) * size_t(p.height());
    std::vector<double> nearest(pixels, -1), slack(pixels, 0), winnerZ(pixels, -1), winnerBound(pixels, 0);
    uint64_t fragments = 0;
    for (const Drawn& d : p.drawn)
        for (const oracle::CoveredSpan& s : coveredSpans(d.place, p.width(), p.height()))
            for (int x = s.first; x < s.end; ++x) {
                const size_t at = size_t(s.row) * size_t(p.width()) + size_t(x);
                const AtPixel a = exactly(d, x, s.row);
                ++fragments;
                if (a.z > nearest[at]) nearest[at] = a.z, slack[at] = a.bound;
                if (d.source == p.frame.triangle[at] && a.z > winnerZ[at]) winnerZ[at] = a.z, winnerBound[at] = a.bound;
            }
    uint64_t covered = 0;
    double worst = 0, worstUnits = 0;
    for (size_t at = 0; at < pixels; ++at) {
        const std::string where = fmt::format("{}: pixel ({}, {})", name, at % size_t(p.width()), at / size_t(p.width()));
        ASSERT_EQ(nearest[at] >= 0, p.frame.triangle[at] != kNone) << where;
        if (p.frame.triangle[at] == kNone) continue;
        ++covered;
        ASSERT_GE(winnerZ[at], 0) << where << ": triangle " << p.frame.triangle[at] << " does not cover it";
        const double error = std::abs(double(p.frame.z[at]) - winnerZ[at]);
        ASSERT_LE(error, winnerBound[at]) << where << ": z " << p.frame.z[at] << ", exact " << winnerZ[at];
        ASSERT_LE(nearest[at] - winnerZ[at], slack[at] + winnerBound[at]) << where << ": a nearer triangle was passed over";
        worst = std::max(worst, error / winnerBound[at]);
        worstUnits = std::max(worstUnits, error / kUnit / winnerZ[at]);
    }
    ASSERT_GT(covered, pixels / 50) << name << ": an empty picture is no evidence";
    fmt::print(
        "coverage oracle {:<12} {}x{}: {} triangles, {} pixels covered, {} fragments, 0 differ; depth error at most {:.2f} of its bound, "
        "{:.1f} u of z\n",
        name, p.width(), p.height(), p.drawn.size(), covered, fragments, worst, worstUnits);
}

const char* const kMeshes[] = {"suzanne/suzanne.obj", "mug/mug.obj", "apple/apple.ply", "procedural/torus.obj"};

TEST(FillOracle, CoverageAndDepthOfCommittedMeshesAreExact) {
    for (const char* mesh : kMeshes) expectExactFill({committed(mesh, 333, 211), requestOf(333, 211)}, std::filesystem::path(mesh).stem());
    expectExactFill({committed("procedural/slivers.stl", 320, 200), requestOf(320, 200)}, "slivers");
}

TEST(FillOracle, CoverageAndDepthOfSoupsAreExact) {
    for (uint32_t seed = 1; seed <= 4; ++seed) expectExactFill(soup(seed, 193, 131, 200, seed > 2), fmt::format("soup {}", seed));
}

TEST(FillOracle, TheDeviceDrawsWhatTheOracleSaw) {
    const Picture p(committed("suzanne/suzanne.obj", 333, 211), requestOf(333, 211));
    const RenderResult device = renderGpu(test::lavapipe(), p.scene, p.request);
    test::expectSameFrames(p.frame, device.frame, "suzanne 333x211");
    const Picture s = soup(3, 193, 131, 200, true);
    test::expectSameFrames(s.frame, renderGpu(test::lavapipe(), s.scene, s.request).frame, "soup 3");
    for (const std::string& line : test::lavapipe().validationMessages()) ADD_FAILURE() << line;
}

TEST(FillOracle, VerticesAreWithinTheBoundOfBinary64Projection) {
    double worst = 0;
    uint64_t vertices = 0;
    for (const char* mesh : kMeshes) {
        const Picture p(committed(mesh, 1920, 1080), requestOf(1920, 1080));
        const Camera& c = *p.scene.camera;
        const double focal = p.height() / 2.0 / std::tan(c.fovYDegrees * std::acos(-1.0) / 360);
        for (const DrawList::Range& r : p.prepared.list.ranges) {
            const Object& object = p.scene.objects[r.sceneObject];
            for (uint32_t i = 0; i < r.vertexCount; ++i) {
                const gpu::ScreenVertex& v = p.geometry.screen[r.firstVertex + i];
                if (v.outcode) continue;
                const glm::dvec3 local(p.scene.meshes[object.mesh].positions[i]);
                const glm::dvec3 toPoint = glm::dvec3(object.worldFromObject * glm::dvec4(local, 1)) - c.eye;
                const double w = glm::dot(c.forward, toPoint);
                const auto check = [&](const glm::dvec3& axis, double centre, int got) {
                    const double q = focal * glm::dot(axis, toPoint) / w;
                    double rowSum = 0, wSum = 0;
                    for (int k = 0; k < 3; ++k) {
                        const glm::dvec3 column(object.worldFromObject[k]);
                        rowSum += std::abs(focal * glm::dot(axis, column) * local[k]);
                        wSum += std::abs(glm::dot(c.forward, column) * local[k]);
                    }
                    const glm::dvec3 origin = glm::dvec3(object.worldFromObject[3]) - c.eye;
                    rowSum += std::abs(focal * glm::dot(axis, origin));
                    wSum += std::abs(glm::dot(c.forward, origin));
                    const double bound =
                        kRowError * (rowSum + std::abs(q) * wSum) / w + kUnit * (std::abs(q) + std::abs(q + centre)) + kSnapPixels;
                    const double error = std::abs(got / 256.0 - (q + centre));
                    ASSERT_LE(error, bound) << mesh << " vertex " << i;
                    worst = std::max(worst, error / bound);
                };
                check(c.right, p.width() / 2.0, v.x);
                check(-c.up, p.height() / 2.0, v.y);
                const double depthBound = (kRowError * 2 * (glm::length(toPoint) + glm::length(local)) / w + kUnit) * v.z;
                ASSERT_LE(std::abs(double(v.z) - double(p.near()) / w), depthBound) << mesh << " vertex " << i;
                ++vertices;
            }
        }
    }
    EXPECT_GT(vertices, 4000u);
    fmt::print("transform oracle: {} vertices, error at most {:.3f} of the bound\n", vertices, worst);
}

// --- the fixed-function witness ---------------------------------------------------------------------------------------------------------

// llvmpipe evaluates depth by float gradients over the viewport; where two triangles are that close in depth, which is nearer is not
// decided by it. Its gradients dz/dx, dz/dy have a few u of relative error each and are multiplied by offsets of up to the viewport.
constexpr double kWitnessGradientUnits = 16;

struct Verdict {
    uint64_t covered = 0, nearEdge = 0, undecidedDepth = 0, wrong = 0;
    std::string first;
};

Verdict against(const Picture& p, const oracle::DrawnFrame& witness) {
    Verdict v;
    std::vector<std::vector<const Drawn*>> of(p.prepared.list.triangles.size());
    for (const Drawn& d : p.drawn) of[d.source].push_back(&d);
    for (size_t at = 0; at < witness.ids.size(); ++at) {
        const uint32_t ours = p.frame.triangle[at], theirs = witness.ids[at];
        v.covered += ours != kNone;
        if (ours == theirs) continue;
        const int x = int(at % size_t(p.width())), y = int(at / size_t(p.width()));
        bool near = false;
        double z[2] = {-1, -1}, margin = 0;
        for (int side = 0; side < 2; ++side)
            for (const Drawn* d : (side ? theirs : ours) == kNone ? std::vector<const Drawn*>() : of[side ? theirs : ours]) {
                near |= oracle::isNearBoundary(d->place, x, y);
                const AtPixel a = exactly(*d, x, y);
                z[side] = a.z;
                const double most = std::max({d->z[0], d->z[1], d->z[2]}), least = std::min({d->z[0], d->z[1], d->z[2]});
                // Gradients are (dz * dy) / area: relative error of a few u, times the distance to the triangle's first corner.
                double area = 0, reach = 0;
                for (size_t i = 0; i < 3; ++i) {
                    const auto &b = d->place[i], &c = d->place[(i + 1) % 3];
                    area += double(b.x) * double(c.y) - double(c.x) * double(b.y);
                    reach = std::max(reach, std::hypot(double(b.x - c.x), double(b.y - c.y)));
                }
                const double slope = (most - least) * reach / std::abs(area);
                margin += a.bound + kWitnessGradientUnits * kUnit *
                                        (most + slope * (reach + 256.0 * oracle::kGuard * std::max(p.width(), p.height())));
            }
        if (near)
            ++v.nearEdge;
        else if (z[0] >= 0 && z[1] >= 0 && std::abs(z[0] - z[1]) <= margin)
            ++v.undecidedDepth;
        else if (v.wrong++ == 0)
            v.first =
                fmt::format("pixel ({}, {}): ours {} at z {:.9g}, fixed function {} at z {:.9g}", x, y, int(ours), z[0], int(theirs), z[1]);
    }
    return v;
}

oracle::FixedFunction& fixedFunction() {
    static oracle::FixedFunction witness;
    return witness;
}

// The witness gets our snapped corners, exactly: nothing but depth can differ.
void expectFixedFunctionAgrees(const Picture& p, const std::string& name) {
    std::vector<oracle::ClipPosition> vertices;
    std::vector<uint32_t> ids;
    for (const Drawn& d : p.drawn) {
        bool inside = true;  // the witness has its own clipping beyond its guard
        for (size_t i = 0; i < 3; ++i)
            inside &= std::abs(d.place[i].x / (128.0 * p.width()) - 1) <= oracle::kGuard &&
                      std::abs(d.place[i].y / (128.0 * p.height()) - 1) <= oracle::kGuard;
        ASSERT_TRUE(inside) << name << ": choose a view inside the witness's guard";
        for (size_t i = 0; i < 3; ++i)
            vertices.push_back({float(double(d.place[i].x) / (128.0 * p.width()) - 1),
                                float(double(d.place[i].y) / (128.0 * p.height()) - 1), float(d.z[i]), 1.0f});
        ids.push_back(d.source);
    }
    const Verdict v = against(p, fixedFunction().draw(p.request.width, p.request.height, vertices, ids));
    fmt::print(
        "fixed function {:<12} {}x{}, snapped corners: {} pixels covered, {} differ within 2^-8 px of an edge, {} at undecided depth, {} "
        "others\n",
        name, p.width(), p.height(), v.covered, v.nearEdge, v.undecidedDepth, v.wrong);
    EXPECT_EQ(v.wrong, 0u) << name << ": " << v.first;
    EXPECT_GT(v.covered, 1000u);
}

// The witness gets unsnapped clip coordinates in perspective and does everything itself.
void expectFixedFunctionAgreesUnsnapped(const Picture& p, const std::string& name) {
    const Camera& c = *p.scene.camera;
    const double focal = p.height() / 2.0 / std::tan(c.fovYDegrees * std::acos(-1.0) / 360);
    std::vector<oracle::ClipPosition> vertices;
    std::vector<uint32_t> ids;
    std::vector<bool> facing(p.prepared.list.triangles.size());
    for (const Drawn& d : p.drawn) facing[d.source] = true;
    for (const DrawList::Range& r : p.prepared.list.ranges) {
        const Object& object = p.scene.objects[r.sceneObject];
        for (uint32_t t = r.firstTriangle; t < r.firstTriangle + r.triangleCount; ++t) {
            if (!facing[t]) continue;  // the witness draws both windings
            for (int i = 0; i < 3; ++i) {
                const glm::dvec3 local(p.scene.meshes[object.mesh].positions[p.prepared.list.triangles[t][i] - r.firstVertex]);
                const glm::dvec3 toPoint = glm::dvec3(object.worldFromObject * glm::dvec4(local, 1)) - c.eye;
                vertices.push_back({float(focal * glm::dot(c.right, toPoint) / (p.width() / 2.0)),
                                    float(-focal * glm::dot(c.up, toPoint) / (p.height() / 2.0)), p.near(),
                                    float(glm::dot(c.forward, toPoint))});
            }
            ids.push_back(t);
        }
    }
    const Verdict v = against(p, fixedFunction().draw(p.request.width, p.request.height, vertices, ids));
    fmt::print(
        "fixed function {:<12} {}x{}, its own projection: {} pixels covered, {} differ within 2^-8 px of an edge, {} at undecided depth, "
        "{} others\n",
        name, p.width(), p.height(), v.covered, v.nearEdge, v.undecidedDepth, v.wrong);
    EXPECT_EQ(v.wrong, 0u) << name << ": " << v.first;
    EXPECT_GT(v.covered, 1000u);
}

TEST(FillOracle, FixedFunctionDrawsTheSameMeshes) {
    for (const char* mesh : kMeshes) {
        const Picture p(committed(mesh, 512, 512), requestOf(512, 512));
        expectFixedFunctionAgrees(p, std::filesystem::path(mesh).stem());
        expectFixedFunctionAgreesUnsnapped(p, std::filesystem::path(mesh).stem());
    }
}

TEST(FillOracle, FixedFunctionDrawsTheSameSoups) {
    for (uint32_t seed = 11; seed <= 18; ++seed) expectFixedFunctionAgrees(soup(seed, 256, 256, 150, true), fmt::format("soup {}", seed));
}

// The comparison can go red: one triangle less is noticed, away from edges.
TEST(FillOracle, FixedFunctionNoticesAMissingTriangle) {
    Picture p(committed("suzanne/suzanne.obj", 256, 256), requestOf(256, 256));
    oracle::DrawnFrame witness{256, 256, p.frame.triangle, p.frame.z};
    const uint32_t gone = p.frame.triangle[128 * 256 + 128];
    ASSERT_NE(gone, kNone);
    for (uint32_t& id : witness.ids)
        if (id == gone) id = kNone;
    EXPECT_GT(against(p, witness).wrong, 0u);
}

// --- shading ----------------------------------------------------------------------------------------------------------------------------

using Vector = glm::vec<3, Real80>;

Real80 lengthOf(const Vector& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

// Error of the interpolated normal's direction, over kappa = sum f w |n| / |sum f w n|: a component of an attribute has 4 u of its row, then
// edge value 2 u, weight and products 2 u, two additions 2 u: 10 u a component, sqrt(3) for the vector.
constexpr double kNormalError = gpu::kAttributeUnits * kUnit * 1.7320508;
// Length of a vector that unitVector left: squares and sums 3 u (half of it in the root), root 4 u, product 1 u.
constexpr double kUnitLengthError = 6.5 * kUnit;
// Ray: three rounded rows (1 u), two products and two sums (4 u) of the sum of magnitudes, a component; sqrt(3) for the vector.
constexpr double kRayError = 5 * kUnit * 1.7320508;
// Planar depth from z: reciprocal 9 u, times near and ray 2 u.
constexpr double kDistanceError = 11 * kUnit;
// Relative error of specularPower for exact delta: log2's polynomial (1.7e-7) and four roundings scale p, and s |ln s| <= 1/e;
// exp2's polynomial (7.5e-8) and three roundings scale s.
constexpr double kPowerError = (1.7e-7 + gpu::kLog2RoundingUnits * kUnit) / 2.718281828 + 7.5e-8 + gpu::kExp2RoundingUnits * kUnit;
// 1 - delta is kept at 2^-20 or more.
constexpr double kPowerFloor = 0x1p-20;

struct ShadingVerdict {
    uint64_t pixels = 0, undecided = 0;
    double worst = 0, worstCodes = 0;
};

void expectShading(const Picture& p, const std::string& name, ShadingVerdict& v) {
    const Camera& c = *p.scene.camera;
    const Real80 focal = c.focalPixels > 0 ? Real80(c.focalPixels) : p.height() / 2.0L / std::tan(c.fovYDegrees * std::acos(-1.0L) / 360);
    std::vector<std::vector<const Drawn*>> of(p.prepared.list.triangles.size());
    for (const Drawn& d : p.drawn) of[d.source].push_back(&d);
    const DrawList& list = p.prepared.list;
    for (size_t at = 0; at < p.frame.triangle.size(); ++at) {
        const uint32_t t = p.frame.triangle[at];
        if (t == kNone || of[t].size() != 1 || list.triangles[t].x != of[t][0]->vertex[0])
            continue;  // corners that clipping made have no normal of the file
        const int x = int(at % size_t(p.width())), y = int(at / size_t(p.width()));
        const Drawn& d = *of[t][0];
        const AtPixel a = exactly(d, x, y);
        const DrawList::Range* range = &list.ranges[0];
        while (t >= range->firstTriangle + range->triangleCount) ++range;
        const Object& object = p.scene.objects[range->sceneObject];
        const TriangleMesh& mesh = p.scene.meshes[object.mesh];
        const glm::dmat3 m(object.worldFromObject);
        const glm::dmat3 normalMatrix = glm::transpose(glm::inverse(m));
        const Material& material = p.scene.materials[mesh.faceMaterial[mesh.triangles[t - range->firstTriangle].face]];
        // Normal
        Vector n(0);
        Real80 sum = 0;
        for (int i = 0; i < 3; ++i) {
            const glm::vec3 file = mesh.normals[d.vertex[i] - range->firstVertex];
            Vector world(0);
            Real80 magnitude = 0;
            for (int k = 0; k < 3; ++k) {
                world += Vector(normalMatrix[k]) * Real80(file[k]);
                magnitude += lengthOf(Vector(normalMatrix[k])) * std::abs(Real80(file[k]));
            }
            const Real80 weight = Real80(a.weight[i]) * Real80(d.z[i]);
            n += world * weight;
            sum += magnitude * weight;
        }
        const Real80 kappa = sum / lengthOf(n);
        n /= lengthOf(n);
        const Real80 normalError = Real80(kNormalError) * kappa + Real80(kUnitLengthError);
        // Ray and position
        const Real80 sx = (x + 0.5L - p.width() / 2.0L) / focal, sy = (y + 0.5L - p.height() / 2.0L) / focal;
        const Vector ray = Vector(c.forward) + Vector(c.right) * sx - Vector(c.up) * sy;
        const Real80 rayParts =
            lengthOf(Vector(c.forward)) + (p.width() + std::abs(x + 0.5L)) / focal + (p.height() + std::abs(y + 0.5L)) / focal;
        const Real80 rayError = Real80(kRayError) * rayParts / lengthOf(ray);
        const Vector toEye = -ray / lengthOf(ray);
        const Vector position = ray * (Real80(p.near()) / Real80(a.z));
        const Real80 positionError = lengthOf(position) * (Real80(kDistanceError) + Real80(a.bound) / Real80(a.z) + rayError);
        Vector colour(0), bound(0);
        for (int i = 0; i < 3; ++i) {
            colour[i] = Real80(material.ambient[i]) * Real80(p.scene.ambient[i]) + Real80(material.emission[i]);
            bound[i] = 2 * kUnit * colour[i];
        }
        bool undecided = false;
        for (const Light& light : p.scene.lights) {
            Vector l = light.directional ? Vector(light.direction) : Vector(light.position - c.eye) - position;
            const Real80 distance = light.directional ? 1 : lengthOf(l);
            const Real80 lightError =
                light.directional
                    ? Real80(kUnit) * 1.7320508L
                    : (positionError + 2 * kUnit * (lengthOf(Vector(light.position - c.eye)) + lengthOf(position))) / distance +
                          Real80(kUnitLengthError);
            l /= lengthOf(l);
            Real80 fade = 1, fadeError = 0;
            if (!light.directional && light.attenuation != Attenuation::none) {
                const int power = light.attenuation == Attenuation::inverse ? 1 : 2;
                fade = std::pow(distance, Real80(-power));
                fadeError = power * lightError + 2 * kUnit;
            }
            const Real80 nl = n.x * l.x + n.y * l.y + n.z * l.z;
            const Real80 nlError = normalError + lightError + 3 * kUnit;
            const bool lit = nl > 0;
            const Real80 exponent = material.shininess;
            const Vector mirrored = n * (2 * nl) - l;
            const Real80 rv = mirrored.x * toEye.x + mirrored.y * toEye.y + mirrored.z * toEye.z;
            const Real80 power = exponent == 0 ? 1 : std::pow(std::max<Real80>(rv, 0), exponent);
            const Real80 mirrorError = 2 * (normalError + nlError) + lightError + rayError + Real80(kUnitLengthError) + 4 * kUnit;
            const Real80 floor = rv < 0.01L ? Real80(kPowerFloor) : 0;
            const Real80 powerError = exponent == 0 ? 0 : truth::highlightError(exponent, mirrorError, floor) + Real80(kPowerError);
            const bool edgeOfLight = std::abs(nl) <= nlError;  // N.L > 0 itself is not decided
            undecided |= edgeOfLight;
            for (int i = 0; i < 3; ++i) {
                const Real80 intensity = Real80(light.intensity[i]) * fade;
                const Real80 term = (lit ? Real80(material.diffuse[i]) * nl + Real80(material.specular[i]) * power : 0) * intensity;
                colour[i] += term;
                bound[i] += intensity * (material.diffuse[i] * nlError +
                                         material.specular[i] * (lit || edgeOfLight ? powerError + (edgeOfLight ? power : 0) : 0)) +
                            (fadeError + (4 + Real80(p.scene.lights.size())) * kUnit) * (term + colour[i]);
            }
        }
        ++v.pixels;
        v.undecided += undecided;
        for (int i = 0; i < 3; ++i) {
            const Real80 error = std::abs(Real80(p.frame.linear[3 * at + size_t(i)]) - colour[i]);
            ASSERT_LE(double(error), double(bound[i])) << name << ": pixel (" << x << ", " << y << ") "
                                                       << "RGB"[i] << ": drawn " << p.frame.linear[3 * at + size_t(i)] << ", formula "
                                                       << double(colour[i]) << (undecided ? ", at the edge of a light" : "");
            v.worst = std::max(v.worst, bound[i] > 0 ? double(error / bound[i]) : 0.0);
            v.worstCodes = std::max(v.worstCodes, double(error * 255));
            const float got = p.frame.normal[3 * at + size_t(i)];
            ASSERT_LE(std::abs(double(got) - double(n[i])), double(normalError)) << name << ": pixel (" << x << ", " << y << ") normal "
                                                                                 << "xyz"[i];
        }
    }
}

TEST(FillOracle, PhongFollowsTheFormulaAtEveryPixel) {
    for (const char* mesh : kMeshes)
        for (const float shininess : {0.0f, 1.0f, 30.0f, 1000.0f, 1e6f}) {
            Scene scene = committed(mesh, 333, 211);
            for (Material& m : scene.materials) {
                m.specular = {0.5f, 0.25f, 0.125f};
                m.shininess = shininess;
            }
            const Camera& c = *scene.camera;
            for (const Attenuation attenuation : {Attenuation::none, Attenuation::inverse, Attenuation::inverseSquare}) {
                Light light;
                light.directional = false;
                light.position = c.eye + c.forward * (0.4 * c.focusDistance) + c.right * (0.3 * c.focusDistance * (1 + int(attenuation))) +
                                 c.up * (0.2 * c.focusDistance);
                light.intensity = glm::vec3(0.25f) * float(attenuation == Attenuation::none ? 1 : c.focusDistance);
                light.attenuation = attenuation;
                scene.lights.push_back(light);
            }
            ShadingVerdict v;
            const std::string name = fmt::format("{} n={}", std::filesystem::path(mesh).stem().string(), shininess);
            expectShading({std::move(scene), requestOf(333, 211)}, name, v);
            if (HasFatalFailure()) return;
            EXPECT_GT(v.pixels, 5000u);
            fmt::print(
                "shading oracle {:<20} {} pixels, {} at the edge of a light, error at most {:.2f} of its bound, {:.5f} of a code (x/255)\n",
                name, v.pixels, v.undecided, v.worst, v.worstCodes);
        }
}

// --- encode and lines -------------------------------------------------------------------------------------------------------------------

// The curve itself, forward; the tables were made by its inverse.
Real80 srgbOf(Real80 linear) { return linear <= 0.0031308L ? 12.92L * linear : 1.055L * std::pow(linear, 1 / 2.4L) - 0.055L; }

TEST(EncodeOracle, EveryCodeIsTheNearestOfTheCurve) {
    uint64_t checked = 0;
    const auto check = [&](float f) {
        ASSERT_EQ(encodeSrgbCpu(f), uint32_t(std::floor(255 * srgbOf(std::min<Real80>(f, 1)) + 0.5L))) << fmt::format("{:.9g}", f);
        ++checked;
    };
    for (int code = 1; code < 256; ++code) {  // the floats about every threshold, found by bisection of the forward curve
        float low = 0, high = 1;
        while (std::nextafter(low, high) < high) {
            const float middle = low + (high - low) / 2;
            (255 * srgbOf(middle) >= code - 0.5L ? high : low) = middle;
        }
        for (int i = 0; i < 4; ++i) check(low), check(high), low = std::nextafter(low, 0.0f), high = std::nextafter(high, 2.0f);
    }
    for (uint32_t bits = 0; bits <= 0x3f800000u; bits += 4099) check(std::bit_cast<float>(bits));
    fmt::print("sRGB oracle: {} floats, 255 thresholds with 4 floats on each side, 0 differ\n", checked);
}

TEST(LinesOracle, APixelIsTheFloorOfTheExactLineAtItsCentre) {
    constexpr int kSide = 97;
    std::mt19937 random(42);
    std::uniform_int_distribution<int> place(-200, kSide * 256 + 200), lattice(0, kSide * 2 - 1), kind(0, 3);
    uint64_t owned = 0;
    for (int line = 0; line < 20000; ++line) {
        int x[2], y[2];
        const int k = kind(random);
        for (int i = 0; i < 2; ++i) x[i] = k ? place(random) : 128 * lattice(random), y[i] = k ? place(random) : 128 * lattice(random);
        if (k == 1) y[1] = y[0];
        if (k == 2) y[1] = y[0] + (x[1] - x[0]);
        if (y[1] < -200 || y[1] > kSide * 256 + 200) continue;
        gpu::ObjectRecord o{};
        o.rowX = {1, 0, 0, 0};
        o.rowY = {0, 1, 0, 0};
        o.rowW = {0, 0, 0, 1};
        const float centre = kSide / 2.0f;
        const std::vector<glm::vec4> positions{{float(x[0]) / 256 - centre, float(y[0]) / 256 - centre, 0, 1},
                                               {float(x[1]) / 256 - centre, float(y[1]) / 256 - centre, 0, 1}};
        const std::vector<glm::uvec2> edges{{0, 1}};
        const std::vector<gpu::ObjectRecord> objects{o};
        std::vector<uint32_t> owners(kSide * kSide, gpu::kNoEdge), want = owners;
        gpu::LinesPush push{};
        push.edgeCount = 1;
        push.rowPixels = push.width = push.height = push.rows = kSide;
        push.viewport = {centre, centre, centre + 1, centre + 1, 0.5f};
        linesCpu(push, edges, positions, objects, owners);
        const bool steep = std::abs(y[1] - y[0]) > std::abs(x[1] - x[0]);
        int *major = steep ? y : x, *minor = steep ? x : y;
        if (major[1] < major[0]) std::swap(major[0], major[1]), std::swap(minor[0], minor[1]);
        for (int pixel = -1; pixel <= kSide; ++pixel) {
            const int64_t centreOf = pixel * 256 + 128;
            if (centreOf < major[0] || centreOf >= major[1]) continue;
            // floor(numerator / (256 run)), numerator / run the exact minor coordinate
            const __int128_t run = major[1] - major[0],
                             numerator = __int128_t(minor[0]) * run + __int128_t(minor[1] - minor[0]) * (centreOf - major[0]);
            __int128_t cell = numerator / (256 * run);
            if (cell * 256 * run > numerator) --cell;
            const int px = steep ? int(cell) : pixel, py = steep ? pixel : int(cell);
            if (px >= 0 && px < kSide && py >= 0 && py < kSide) want[size_t(py) * kSide + size_t(px)] = 0, ++owned;
        }
        ASSERT_EQ(owners, want) << fmt::format("({}, {}) to ({}, {})", x[0], y[0], x[1], y[1]);
    }
    EXPECT_GT(owned, 500000u);
    fmt::print("lines oracle: 20000 lines, {} pixels, 0 differ\n", owned);
}

}  // namespace
}  // namespace plumb
