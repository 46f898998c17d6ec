// SPDX-License-Identifier: MIT
// The rows of docs/extremes.md, one test a row, one printed line a row. Counts that take longer run with PLUMB_LONG=1.
#include "pipeline/passes/cull.h"
#include "pipeline/passes/fill.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/sha256.h"
#include "tests/oracle/coverage_oracle.h"
#include "tests/oracle/screen_scene.h"
#include "tests/support/temporary_folder.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <glm/glm.hpp>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using Real80 = long double;

constexpr double kUnit = 0x1p-24;  // u, unit round-off of float32

int countOf(int quick, int thorough) { return std::getenv("PLUMB_LONG") ? thorough : quick; }

template <class T>
std::string hashOf(const std::vector<T>& v) {
    return sha256Hex(std::as_bytes(std::span<const T>(v)));
}
std::string hashOf(const Frame& f) { return hashOf(f.triangle) + hashOf(f.z) + hashOf(f.linear) + hashOf(f.rgba); }

RenderRequest requestOf(uint32_t width, uint32_t height, Shading shading = Shading::phong) {
    RenderRequest request;
    request.width = width;
    request.height = height;
    request.shading = shading;
    request.planes = kPlaneColour | kPlaneLinear | kPlaneZ | kPlaneTriangle;
    return request;
}

constexpr glm::uvec2 kSize{160, 120};

// The torus with a highlight, two directional lights and one point light for each attenuation but the last.
Scene torus(glm::uvec2 size = kSize) {
    const std::filesystem::path path = std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes/procedural/torus.ply";
    Scene scene = loadScene({path}, {});
    completeScene(scene, size, "", true);
    for (Material& m : scene.materials) m.specular = glm::vec3(0.5f), m.shininess = 40;
    Light light;
    light.directional = false;
    light.position = scene.camera->eye + scene.camera->up * scene.camera->focusDistance;
    light.intensity = glm::vec3(0.3f);
    scene.lights.push_back(light);
    return scene;
}

// Scene in other units. Positions are multiplied in float32: exact for powers of two.
Scene scaled(Scene scene, double factor) {
    for (TriangleMesh& mesh : scene.meshes) {
        for (auto* list : {&mesh.positions, &mesh.faceCentre})
            for (glm::vec3& p : *list) p = glm::vec3(glm::dvec3(p) * factor);
        mesh.boundsMin = glm::vec3(glm::dvec3(mesh.boundsMin) * factor);
        mesh.boundsMax = glm::vec3(glm::dvec3(mesh.boundsMax) * factor);
    }
    scene.camera->eye *= factor;
    scene.camera->focusDistance *= factor;
    scene.camera->near *= factor;
    for (Light& light : scene.lights) light.position *= factor;
    return scene;
}

bool isFinite(const Frame& f) {
    return std::all_of(f.linear.begin(), f.linear.end(), [](float x) { return std::isfinite(x); });
}

std::string refusalOf(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        EXPECT_EQ(int(error.exit()), int(Exit::input)) << error.what();
        return error.what();
    }
    return "";
}

std::string objOfTorus(const std::string& exponent) {
    std::string text;
    const TriangleMesh mesh = loadScene({std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes/procedural/torus.ply"}, {}).meshes[0];
    for (const glm::vec3& p : mesh.positions)
        text += fmt::format("v {:.9f}{} {:.9f}{} {:.9f}{}\n", p.x, exponent, p.y, exponent, p.z, exponent);
    for (const TriangleMesh::Triangle& t : mesh.triangles)
        text += fmt::format("f {} {} {}\n", t.vertex[0] + 1, t.vertex[1] + 1, t.vertex[2] + 1);
    return text;
}

// Row 1. A mesh file whose coordinates are 10^k times those of the torus, framed as ever. Rounding of the decimal coordinates moves
// vertices by up to u of their size; an edge may then pass a pixel centre, and a silhouette pixel changes: at most one in 200 here.
constexpr uint64_t kDecadeSilhouetteShare = 200;
TEST(Extremes, Row01CoordinateDecades) {
    const test::TemporaryFolder folder;
    Frame reference;
    int drawn = 0, refused = 0, lowest = 99, highest = -99;
    uint64_t most = 0;
    std::vector<int> decades{0};
    for (int k = -38; k <= 38; ++k) decades.push_back(k);
    for (const int k : decades) {
        const auto path = folder.write(fmt::format("torus{}.obj", k), objOfTorus(fmt::format("e{}", k)));
        Frame frame;
        const std::string refusal = refusalOf([&] {
            Scene scene = loadScene({path}, {});
            completeScene(scene, kSize, "", true);
            for (Material& m : scene.materials) m.specular = glm::vec3(0.5f);
            for (const Shading shading : {Shading::flat, Shading::gouraud}) {
                EXPECT_TRUE(isFinite(renderCpu(scene, requestOf(kSize.x, kSize.y, shading)).frame)) << "10^" << k;
            }
            frame = k % 6 == 0 ? test::expectDeviceEqualsTwin(scene, requestOf(kSize.x, kSize.y), fmt::format("10^{}", k)).frame
                               : renderCpu(scene, requestOf(kSize.x, kSize.y)).frame;
        });
        if (!refusal.empty()) {
            EXPECT_GT(std::abs(k), 29) << refusal;
            EXPECT_TRUE(refusal.find("2^100") != std::string::npos || refusal.find("smallest that is drawn") != std::string::npos ||
                        refusal.find("largest magnitude") != std::string::npos)
                << "the limit is not named: " << refusal;
            ++refused;
            continue;
        }
        ++drawn;
        lowest = std::min(lowest, k);
        highest = std::max(highest, k);
        EXPECT_TRUE(isFinite(frame)) << "10^" << k;
        if (reference.triangle.empty()) reference = frame;
        uint64_t differ = 0;
        for (size_t i = 0; i < frame.triangle.size(); ++i) differ += frame.triangle[i] != reference.triangle[i];
        EXPECT_LE(differ, reference.coveredPixels / kDecadeSilhouetteShare) << "10^" << k;
        most = std::max(most, differ);
    }
    EXPECT_LE(lowest, -29);
    EXPECT_GE(highest, 29);
    fmt::print("row 1: decades 10^{} to 10^{} drawn ({}), {} refused by name; at most {} of {} pixels take another triangle\n", lowest,
               highest, drawn - 1, refused, most, reference.coveredPixels);
}

// Row 2. Every light kind; attenuations with intensities in the same units.
TEST(Extremes, Row02BinaryScale) {
    for (const Attenuation attenuation : {Attenuation::none, Attenuation::inverse, Attenuation::inverseSquare})
        for (const Shading shading : {Shading::flat, Shading::gouraud, Shading::phong}) {
            Scene scene = torus();
            scene.camera->near = std::exp2(std::floor(std::log2(scene.camera->focusDistance)) - 10);
            scene.lights.back().attenuation = attenuation;
            const std::string want = hashOf(renderCpu(scene, requestOf(kSize.x, kSize.y, shading)).frame);
            int equal = 0;
            for (int k = -60; k <= 60; ++k) {
                Scene other = scaled(scene, std::exp2(k));
                const int power = attenuation == Attenuation::none ? 0 : attenuation == Attenuation::inverse ? 1 : 2;
                other.lights.back().intensity = glm::vec3(std::ldexp(0.3f, power * k));
                if (power == 2 && std::abs(k) == 60)
                    test::expectDeviceEqualsTwin(other, requestOf(kSize.x, kSize.y, shading), fmt::format("2^{}", k));
                if (hashOf(renderCpu(other, requestOf(kSize.x, kSize.y, shading)).frame) == want)
                    ++equal;
                else
                    ADD_FAILURE() << "2^" << k << ", shading " << int(shading) << ", attenuation " << int(attenuation);
            }
            EXPECT_EQ(equal, 121);
        }
    fmt::print("row 2: scales 2^-60 to 2^60, 3 shadings, 3 attenuations: 121/121 the same bytes each\n");
}

// Row 3. Denormals and signed zeros in positions and normals are flushed at load, and counted.
TEST(Extremes, Row03Denormals) {
    const test::TemporaryFolder folder;
    const auto load = [&](const std::string& name, const char* tiny) {
        const std::string text = fmt::format("v {0} -1 0\nv 1 {0} 0\nv 0 1 {0}\nvn {0} 0 1\nvn 0 {0} 1\nf 1//1 2//2 3//1\n", tiny);
        Scene scene = loadScene({folder.write(name, text)}, {});
        completeScene(scene, kSize, "", true);
        return scene;
    };
    const Scene zero = load("zero.obj", "0");
    const std::string want = hashOf(renderCpu(zero, requestOf(kSize.x, kSize.y)).frame);
    int counted = 0;
    for (const char* tiny : {"1e-39", "-1e-39", "1.1e-38", "1e-45", "-1e-60"}) {
        const Scene scene = load("tiny.obj", tiny);
        EXPECT_EQ(scene.meshes[0].flushedDenormals, 5u) << tiny;
        counted += int(scene.meshes[0].flushedDenormals);
        EXPECT_EQ(scene.warnings.size(), 1u);
        EXPECT_EQ(hashOf(test::expectDeviceEqualsTwin(scene, requestOf(kSize.x, kSize.y), tiny).frame), want) << tiny;
    }
    EXPECT_EQ(hashOf(renderCpu(load("minus.obj", "-0"), requestOf(kSize.x, kSize.y)).frame), want);
    EXPECT_EQ(load("least.obj", "1.1754944e-38").meshes[0].flushedDenormals, 0u) << "2^-126 is normal";
    fmt::print("row 3: {} denormals flushed and counted; the pictures are the flushed scene's\n", counted);
}

// Row 4. Every coordinate of four formats. A normal that is not finite counts as not stated, with a warning; --strict refuses it. (Fields of scene files and glTF: tests/unit/scene_refusals_test.cpp, gltf_test.cpp.)
TEST(Extremes, Row04NotFinite) {
    const test::TemporaryFolder folder;
    int refused = 0, asked = 0, warned = 0, normals = 0;
    for (const char* value : {"nan", "-nan", "inf", "-inf", "1e999"})
        for (int field = 0; field < 6; ++field) {
            std::string f[6] = {"0", "1", "2", "0", "0", "1"};
            f[field] = value;
            const std::string position = f[0] + " " + f[1] + " " + f[2], normal = f[3] + " " + f[4] + " " + f[5];
            std::vector<std::pair<std::string, std::string>> files{
                {"a.obj", "v " + position + "\nv 1 0 0\nv 0 1 0\nvn " + normal + "\nf 1//1 2//1 3//1\n"},
                {"a.ply",
                 "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float "
                 "nx\nproperty float ny\nproperty float nz\n"
                 "element face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                     position + " " + normal + "\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n"}};
            if (field < 3) {
                files.push_back({"a.off", "OFF\n3 1 0\n" + position + "\n1 0 0\n0 1 0\n3 0 1 2\n"});
                files.push_back({"a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex " + position +
                                              "\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"});
            }
            for (const auto& [name, text] : files) {
                const std::string path = folder.write(name, text);
                const bool ofNormal = field >= 3;
                const std::string refusal = refusalOf([&] { loadScene({path}, {.strict = ofNormal}); });
                if (ofNormal) {
                    ++normals;
                    const std::vector<std::string> warnings = loadScene({path}, {}).warnings;
                    ASSERT_EQ(warnings.size(), 1u) << name << " took " << value << " in field " << field << " without a word";
                    EXPECT_NE(warnings[0].find("normal"), std::string::npos) << warnings[0];
                    ++warned;
                }
                ++asked;
                EXPECT_NE(refusal.find(name), std::string::npos) << name << " took " << value << " in field " << field << ": " << refusal;
                refused += !refusal.empty();
            }
        }
    EXPECT_EQ(refused, asked);
    fmt::print("row 4: {}/{} files with a number that is not finite refused by name; {}/{} warned of where it is of a normal\n", refused,
               asked, warned, normals);
}

// Row 5.
TEST(Extremes, Row05NoArea) {
    const int count = countOf(100000, 1000000);
    std::mt19937 random(5);
    std::uniform_int_distribution<int> place(0, 128 * 256), step(-3000, 3000), kind(0, 3), factor(-3, 4);
    test::ScreenScene s(128, 128);
    for (int i = 0; i < count; ++i) {
        const int k = kind(random), x = place(random), y = place(random), dx = step(random), dy = step(random), n = factor(random);
        const test::ScreenPoint a{double(x), double(y), 1}, b{double(x + dx), double(y + dy), 2},
            c{double(x + n * dx), double(y + n * dy), 4};
        if (k == 0) s.add({a, a, b});
        if (k == 1) s.add({a, b, a});
        if (k == 2) s.add({a, a, a});
        if (k == 3) s.add({a, b, c});
    }
    s.scene.cullBackFaces = false;
    const RenderResult r = test::expectDeviceEqualsTwin(s.scene, s.request, "no area");
    EXPECT_EQ(r.frame.coveredPixels, 0u);
    EXPECT_EQ(r.counters.culledZeroArea, uint64_t(count));
    fmt::print("row 5: {} triangles without area: {} pixels drawn, {} counted\n", count, r.frame.coveredPixels, r.counters.culledZeroArea);
}

// --- one drawn triangle, straight into the twin's fill ----------------------------------------------------------------------------------

struct OneTriangle {
    oracle::SubpixelTriangle place;
    std::array<gpu::ScreenVertex, 3> screen{};
    gpu::DrawTriangle draw{};

    explicit OneTriangle(const oracle::SubpixelTriangle& t, std::array<float, 3> z = {1, 1, 1}) : place(t) {
        glm::ivec2 p[3];
        for (size_t i = 0; i < 3; ++i) {
            p[i] = {int(t[i].x), int(t[i].y)};
            screen[i] = {p[i].x, p[i].y, z[i], 0};
        }
        draw = gpu::drawTriangle(0, 1, 2, p[0], p[1], p[2], 0);
    }
    bool hasArea() const {
        return __int128_t(place[1].x - place[0].x) * (place[2].y - place[0].y) !=
               __int128_t(place[1].y - place[0].y) * (place[2].x - place[0].x);
    }
};

// Row 6. Bound of tests/oracle/fill_oracle_test.cpp with F <= largest z: 10 u F + u z0 + u z <= 12 u of the largest corner.
constexpr double kDepthBound = 12 * kUnit * 1.01;
TEST(Extremes, Row06Needles) {
    constexpr int kSide = 128;
    const int count = countOf(40000, 400000);
    std::mt19937 random(6);
    std::uniform_int_distribution<int> place(0, kSide * 256), thin(1, 3);
    std::uniform_real_distribution<float> exponent(-20, 0);
    std::vector<int> z(kSide * kSide);
    std::vector<uint32_t> draw(z.size());
    uint64_t pixels = 0;
    double worst = 0;
    std::array<uint64_t, 12> histogram{};
    for (int i = 0; i < count; ++i) {
        oracle::SubpixelTriangle t;
        t[0] = {place(random), place(random)};
        t[1] = {place(random), place(random)};
        const int width = i % 4 ? thin(random) : 1 << (i / 4 % 12);
        t[2] = i % 2 ? oracle::SubpixelPoint{t[1].x + width, t[1].y}
                     : oracle::SubpixelPoint{(t[0].x + t[1].x) / 2, (t[0].y + t[1].y) / 2 + width};
        const std::array<float, 3> depth{std::exp2(exponent(random)), std::exp2(exponent(random)), std::exp2(exponent(random))};
        const OneTriangle one(t, depth);
        if (!one.hasArea()) continue;
        fillCpu({kSide, kSide, 0, kSide}, {&one.draw, 1}, one.screen, z, draw, 1);
        const double largest = std::max({depth[0], depth[1], depth[2]});
        for (const oracle::CoveredSpan& s : coveredSpans(t, kSide, kSide))
            for (int x = s.first; x < s.end; ++x) {
                const size_t at = size_t(s.row) * kSide + size_t(x);
                ASSERT_NE(draw[at], 0u);
                Real80 sum = 0, area = 0;
                for (size_t k = 0; k < 3; ++k) {
                    const auto &b = t[(k + 1) % 3], &c = t[(k + 2) % 3];
                    const int64_t px = x * 256 + 128, py = s.row * 256 + 128;
                    const Real80 e = Real80((b.x - px) * (c.y - py) - (b.y - py) * (c.x - px));
                    sum += e * depth[k];
                    area += e;
                }
                const double units = double(std::abs(Real80(gpu::realOf(z[at])) - sum / area)) / largest / kUnit;
                ASSERT_LE(units, kDepthBound / kUnit) << "needle " << i << " pixel (" << x << ", " << s.row << ")";
                worst = std::max(worst, units);
                ++histogram[std::min<size_t>(size_t(units * 4), 11)];
                ++pixels;
            }
    }
    EXPECT_GT(pixels, uint64_t(count));
    std::string bars;
    for (uint64_t n : histogram) bars += fmt::format(" {}", n);
    fmt::print(
        "row 6: {} needles from 2^-8 px, {} pixels: depth error at most {:.2f} u of the largest corner (bound {:.1f}); by quarters of "
        "u:{}\n",
        count, pixels, worst, kDepthBound / kUnit, bars);
    test::ScreenScene s(kSide, kSide);
    for (int i = 0; i < 2000; ++i) {
        const double x = place(random), y = place(random);
        s.add({{{x, y, 1}, {double(place(random)), double(place(random)), 4}, {x + thin(random), y, 2}}});
    }
    s.scene.cullBackFaces = false;
    test::expectDeviceEqualsTwin(s.scene, s.request, "needles");
}

// Row 7. Two triangles on either side of an edge through a pixel centre, or 1 to 3 sub-pixels beside it.
TEST(Extremes, Row07SharedEdges) {
    const int count = countOf(60000, 1000000);
    uint64_t gaps = 0, doubles = 0, pairs = 0;
    for (const int width : {512, 2048, 16384}) {
        std::mt19937 random(static_cast<uint32_t>(width));
        std::uniform_int_distribution<int> pixel(0, width - 1), direction(-700, 700), beside(-3, 3), reach(1, width > 512 ? 60 : 20);
        std::vector<int> z(static_cast<size_t>(width));
        std::vector<uint32_t> draw(z.size());
        for (int i = 0; i < count; ++i) {
            const int px = pixel(random), py = pixel(random);
            const int64_t cx = px * 256 + 128, cy = py * 256 + 128;
            const int64_t dx = direction(random), dy = i % 8 ? direction(random) : 0, shift = i % 2 ? beside(random) : 0;
            if (std::abs(dx) + std::abs(dy) < 8) continue;
            const int before = reach(random), after = reach(random), left = reach(random), right = reach(random);
            const bool vertical = i % 16 == 8;
            const int64_t ex = vertical ? 0 : dx, ey = vertical ? dx : dy;
            const int64_t ox = std::abs(ey) >= std::abs(ex) ? shift : 0, oy = ox ? 0 : shift;
            const oracle::SubpixelPoint a{cx - before * ex + ox, cy - before * ey + oy}, b{cx + after * ex + ox, cy + after * ey + oy};
            const oracle::SubpixelPoint p{cx - left * ey, cy + left * ex}, q{cx + right * ey, cy - right * ex};
            const int64_t limit = (int64_t(width) + 8192) * 256;
            bool inside = true;
            for (const auto& v : {a, b, p, q}) inside &= std::abs(v.x) < limit && std::abs(v.y) < limit;
            if (!inside) continue;
            int owners = 0;
            for (const OneTriangle& one : {OneTriangle({a, b, p}), OneTriangle({a, q, b})}) {
                if (!one.hasArea()) continue;
                fillCpu({px + 1, width, py, 1}, {&one.draw, 1}, one.screen, std::span(z).first(size_t(px) + 1),
                        std::span(draw).first(size_t(px) + 1), 1);
                owners += draw[size_t(px)] != 0;
            }
            ++pairs;
            gaps += owners == 0;
            doubles += owners > 1;
            ASSERT_EQ(owners, 1) << fmt::format("pixel ({}, {}), edge ({}, {}) to ({}, {})", px, py, a.x, a.y, b.x, b.y);
        }
    }
    EXPECT_GT(pairs, uint64_t(count) * 2);
    fmt::print("row 7: {} shared edges through or beside pixel centres, frames of 512 to 16384 px: {} gaps, {} doubles\n", pairs, gaps,
               doubles);
    test::ScreenScene s(256, 256);
    std::mt19937 random(77);
    std::uniform_int_distribution<int> lattice(0, 255);
    for (int i = 0; i < 4000; ++i) {
        std::array<test::ScreenPoint, 3> t{};
        for (test::ScreenPoint& c : t) c = {lattice(random) * 256.0 + 128, lattice(random) * 256.0 + 128, i % 3 ? 1.0 : 2.0};
        s.add(t);
    }
    test::expectDeviceEqualsTwin(s.scene, s.request, "corners on pixel centres");
}

// Row 8. A parallelogram cut along its diagonal; three corners run through every pattern of signs of w. A pixel must be covered by exactly
// one of the two halves when its ray and those of its eight neighbours meet the parallelogram in front of the near plane.
TEST(Extremes, Row08BehindTheViewer) {
    constexpr int kSide = 32;
    constexpr double kNear = 0x1p-10;
    const int count = countOf(100, 10000);
    std::mt19937 random(8);
    std::uniform_real_distribution<double> lateral(-4, 4), depth(0.1, 4);
    std::uniform_int_distribution<int> zeroKind(0, 3), triplet(0, 3);
    const float zeros[] = {0.0f, -0.0f, 0x1p-126f, -0x1p-126f};
    uint64_t required = 0, gaps = 0, doubles = 0, patternsSeen = 0, clipped = 0;
    test::ScreenScene all(kSide, kSide);
    all.scene.camera->focalPixels = kSide / 2.0;
    all.scene.cullBackFaces = false;
    std::string table;
    for (int pattern = 0; pattern < 27; ++pattern) {
        uint64_t here = 0;
        for (int i = 0; i < count; ++i) {
            glm::vec3 p[4];
            const int signs[] = {pattern % 3 - 1, pattern / 3 % 3 - 1, pattern / 9 - 1};
            for (int k = 0; k < 3; ++k) {
                const float w = signs[k] == 0 ? zeros[zeroKind(random)] : float(signs[k] * depth(random));
                p[k == 2 ? 3 : k] = {float(lateral(random)), float(lateral(random)), -w};
            }
            p[2] = p[1] + p[3] - p[0];
            test::ScreenScene halves[2] = {{kSide, kSide}, {kSide, kSide}};
            halves[0].addPlaces({p[0], p[1], p[2]});
            halves[1].addPlaces({p[0], p[2], p[3]});
            std::vector<uint32_t> owners(kSide * kSide);
            for (test::ScreenScene& h : halves) {
                h.scene.camera = all.scene.camera;
                h.scene.cullBackFaces = false;
                h.request.shading = Shading::unlit;
                h.request.threads = 1;
                h.request.planes = kPlaneTriangle;
                const RenderResult r = renderCpu(h.scene, h.request);
                clipped += r.counters.clipped;
                for (size_t at = 0; at < owners.size(); ++at) owners[at] += r.frame.triangle[at] != kNone;
                if (i < 8) all.addPlaces({h.scene.meshes[0].positions[0], h.scene.meshes[0].positions[1], h.scene.meshes[0].positions[2]});
            }
            const glm::dvec3 origin(p[0]), u(glm::dvec3(p[1]) - origin), v(glm::dvec3(p[3]) - origin);
            std::vector<bool> hit((kSide + 2) * (kSide + 2));
            for (int y = -1; y <= kSide; ++y)
                for (int x = -1; x <= kSide; ++x) {
                    const glm::dvec3 ray((x + 0.5 - kSide / 2.0) / (kSide / 2.0), -(y + 0.5 - kSide / 2.0) / (kSide / 2.0), -1);
                    const double det = glm::dot(ray, glm::cross(u, v));
                    if (det == 0) continue;
                    const double t = glm::dot(origin, glm::cross(u, v)) / det, a = glm::dot(ray, glm::cross(origin, v)) / -det,
                                 b = glm::dot(ray, glm::cross(u, origin)) / -det;
                    hit[size_t(y + 1) * (kSide + 2) + size_t(x + 1)] = t > kNear && a > 0 && a < 1 && b > 0 && b < 1;
                }
            for (int y = 0; y < kSide; ++y)
                for (int x = 0; x < kSide; ++x) {
                    bool must = true;
                    for (int n = 0; n < 9; ++n) must &= hit[size_t(y + n / 3) * (kSide + 2) + size_t(x + n % 3)];
                    if (!must) continue;
                    const uint32_t owned = owners[size_t(y) * kSide + size_t(x)];
                    ++required;
                    ++here;
                    gaps += owned == 0;
                    doubles += owned > 1;
                    ASSERT_EQ(owned, 1u) << fmt::format(
                        "pattern {}, case {}, pixel ({}, {}): corners ({}, {}, {}) ({}, {}, {}) ({}, {}, {})", pattern, i, x, y, p[0].x,
                        p[0].y, p[0].z, p[1].x, p[1].y, p[1].z, p[3].x, p[3].y, p[3].z);
                }
        }
        patternsSeen += here > 0;
        table += fmt::format(" {}{}{}:{}", "-0+"[pattern % 3], "-0+"[pattern / 3 % 3], "-0+"[pattern / 9], here);
    }
    EXPECT_GT(patternsSeen, 20u) << "patterns in which the parallelogram is seen";
    EXPECT_GT(clipped, 0u);
    fmt::print(
        "row 8: 27 patterns of w signs x {} parallelograms, {} triangles clipped, {} inner pixels: {} gaps, {} doubles; pixels by "
        "signs{}\n",
        count, clipped, required, gaps, doubles, table);
    test::expectDeviceEqualsTwin(all.scene, all.request, "sign patterns");
}

// Row 9. On the grid: corners as far out as a frame and its guard reach. Beyond: edges of 10^6 px are clipped at the guard band, where a
// corner is computed from the inside vertex: 4 roundings (t, difference, product, sum) of up to 10^6 px, then half a sub-pixel.
constexpr int kClipMoveSubpixels = int(4 * kUnit * 1e6 * 256) + 2;
TEST(Extremes, Row09LongEdges) {
    const int count = countOf(3000, 100000);
    std::mt19937 random(9);
    constexpr int kSide = 256;
    std::vector<int> z(kSide * kSide);
    std::vector<uint32_t> draw(z.size());
    std::uniform_int_distribution<int> far(-(8192 * 256), (65536 + 8192) * 256), near(0, kSide * 256);
    uint64_t pixels = 0;
    for (int i = 0; i < count; ++i) {
        oracle::SubpixelTriangle t;
        for (size_t k = 0; k < 3; ++k) t[k] = {far(random), far(random) / 4};
        if (i % 2) t[0] = {near(random), near(random)};
        const OneTriangle one(t);
        if (!one.hasArea()) continue;
        fillCpu({kSide, kSide, 0, kSide}, {&one.draw, 1}, one.screen, z, draw, 1);
        std::vector<uint32_t> want(z.size());
        for (const oracle::CoveredSpan& s : coveredSpans(t, kSide, kSide))
            for (int x = s.first; x < s.end; ++x) want[size_t(s.row) * kSide + size_t(x)] = 1, ++pixels;
        ASSERT_EQ(draw, want) << "triangle " << i;
    }
    EXPECT_GT(pixels, 100000u);
    uint64_t moved = 0, wrong = 0, drawnPixels = 0;
    const int clippedCount = countOf(300, 3000);
    test::ScreenScene all(kSide, kSide);
    all.scene.cullBackFaces = false;
    std::uniform_int_distribution<int> million(-256000000, 256000000);
    for (int i = 0; i < clippedCount; ++i) {
        const oracle::SubpixelTriangle t{
            {{near(random), near(random)}, {million(random), million(random)}, {million(random), million(random)}}};
        test::ScreenScene s(kSide, kSide);
        std::array<test::ScreenPoint, 3> corners{};
        oracle::SubpixelTriangle rounded;
        for (size_t k = 0; k < 3; ++k) {
            corners[k] = {double(t[k].x), double(t[k].y), 1};
            // what the float position holds
            rounded[k] = {std::llround((double(float(corners[k].x / 256 - kSide / 2.0)) + kSide / 2.0) * 256),
                          std::llround((double(float(corners[k].y / 256 - kSide / 2.0)) + kSide / 2.0) * 256)};
        }
        s.add(corners);
        if (i < 60) all.add(corners);
        s.scene.cullBackFaces = false;
        s.request.shading = Shading::unlit;
        const Frame frame = renderCpu(s.scene, s.request).frame;
        std::vector<uint32_t> want(frame.triangle.size(), kNone);
        for (const oracle::CoveredSpan& c : coveredSpans(rounded, kSide, kSide))
            for (int x = c.first; x < c.end; ++x) want[size_t(c.row) * kSide + size_t(x)] = 0;
        for (size_t at = 0; at < want.size(); ++at) {
            drawnPixels += frame.triangle[at] != kNone;
            if (want[at] == frame.triangle[at]) continue;
            (isNearBoundary(rounded, int(at % kSide), int(at / kSide), kClipMoveSubpixels) ? moved : wrong) += 1;
        }
    }
    EXPECT_EQ(wrong, 0u);
    fmt::print(
        "row 9: {} triangles to 73,728 px on the grid, {} pixels, 0 differ from 128-bit spans; {} triangles with edges to 10^6 px, "
        "clipped: {} pixels, {} differ within {}/256 px of "
        "an edge, {} others\n",
        count, pixels, clippedCount, drawnPixels, moved, kClipMoveSubpixels, wrong);
    test::expectDeviceEqualsTwin(all.scene, all.request, "edges of 10^6 px");
}

// Row 10. Depth of a corner: w has 4 u of its row and the quotient 1 u; in the plane 12 u (row 6).
constexpr double kLayerBound = (5 + 12) * kUnit * 1.01;
TEST(Extremes, Row10CoplanarLayers) {
    constexpr int kSide = 64;
    const auto layer = [&](double far, double scale, int rotate) {
        std::array<test::ScreenPoint, 3> t{{{-2000, -1000, 1}, {1500, 40000, std::sqrt(far)}, {50000, 700, far}}};
        for (test::ScreenPoint& p : t) p.w *= scale;
        std::rotate(t.begin(), t.begin() + rotate, t.end());
        return t;
    };
    test::ScreenScene same(kSide, kSide);
    for (int i = 0; i < 9; ++i) same.add(layer(30, 1, i % 3));
    const Frame stable = test::expectDeviceEqualsTwin(same.scene, same.request, "same corners").frame;
    EXPECT_GT(stable.coveredPixels, 1000u);
    for (uint32_t id : stable.triangle) EXPECT_TRUE(id == 0 || id == kNone) << id;
    fmt::print(
        "row 10: nine layers of the same corners in all rotations: the first owns all {} pixels; wrong pixels of two layers, all undecided "
        "by the bound:\n",
        stable.coveredPixels);
    for (int farDecade = 1; farDecade <= 8; ++farDecade) {
        std::string line;
        for (int gapDecade = -9; gapDecade <= -1; ++gapDecade) {
            const double gap = std::pow(10, gapDecade), far = std::pow(10, farDecade);
            test::ScreenScene s(kSide, kSide);
            s.add(layer(far, 1 + gap, 0));
            s.add(layer(far, 1, 0));  // nearer everywhere
            s.request.shading = Shading::unlit;
            const Frame frame =
                farDecade == 4 ? test::expectDeviceEqualsTwin(s.scene, s.request, "two layers").frame : renderCpu(s.scene, s.request).frame;
            uint64_t wrong = 0, undecided = 0;
            const double largest = 0x1p-10;
            for (int y = 0; y < kSide; ++y)
                for (int x = 0; x < kSide; ++x) {
                    const uint32_t id = frame.triangle[size_t(y) * kSide + size_t(x)];
                    if (id == kNone) continue;
                    const auto t = layer(far, 1, 0);
                    double sum = 0, area = 0;
                    for (size_t k = 0; k < 3; ++k) {
                        const auto &b = t[(k + 1) % 3], &c = t[(k + 2) % 3];
                        const double px = x * 256 + 128, py = y * 256 + 128, e = (b.x - px) * (c.y - py) - (b.y - py) * (c.x - px);
                        sum += e * 0x1p-10 / t[k].w;
                        area += e;
                    }
                    const double z = sum / area;
                    const bool isUndecided = z - z / (1 + gap) <= 2 * kLayerBound * largest;
                    undecided += isUndecided;
                    wrong += id == 0;
                    ASSERT_TRUE(id == 1 || isUndecided)
                        << fmt::format("gap 1e{}, far/near 1e{}, pixel ({}, {})", gapDecade, farDecade, x, y);
                }
            line += fmt::format(" {:5.1f}%", 100.0 * double(wrong) / double(frame.coveredPixels));
        }
        fmt::print("  far/near 1e{}, gap 1e-9 to 1e-1:{}\n", farDecade, line);
    }
}

// Row 11. Eye and object moved together by L. Eye and matrix are multiples of 2^-20, so that adding L <= 10^9 is exact in binary64.
TEST(Extremes, Row11Translation) {
    Scene scene = torus();
    for (int i = 0; i < 3; ++i) {
        scene.camera->eye[i] = std::round(scene.camera->eye[i] * 0x1p20) * 0x1p-20;
        scene.lights.back().position[i] = std::round(scene.lights.back().position[i] * 0x1p20) * 0x1p-20;
    }
    const std::string want = hashOf(test::expectDeviceEqualsTwin(scene, requestOf(kSize.x, kSize.y), "at the origin").frame);
    int equal = 0;
    for (int k = 0; k <= 9; ++k) {
        const glm::dvec3 move = glm::dvec3(1, -1, 1) * std::pow(10.0, k);
        Scene other = scene;
        other.camera->eye += move;
        other.lights.back().position += move;
        other.objects[0].worldFromObject[3] += glm::dvec4(move, 0);
        const Frame frame = k % 3 == 0
                                ? test::expectDeviceEqualsTwin(other, requestOf(kSize.x, kSize.y), fmt::format("moved by 10^{}", k)).frame
                                : renderCpu(other, requestOf(kSize.x, kSize.y)).frame;
        EXPECT_EQ(hashOf(frame), want) << "moved by 10^" << k;
        equal += hashOf(frame) == want;
    }
    fmt::print("row 11: scene and camera moved by 10^0 to 10^9: {}/10 the same bytes\n", equal);
}

// Row 21.
TEST(Extremes, Row21OppositeNormals) {
    const test::TemporaryFolder folder;
    const std::string corners = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\n";
    const auto load = [&](const std::string& name, const std::string& rest) {
        Scene scene = loadScene({folder.write(name, corners + rest)}, {});
        completeScene(scene, kSize, "front", true);
        return scene;
    };
    const std::string want = hashOf(renderCpu(load("face.obj", "vn 0 0 1\nf 1//1 2//1 3//1\n"), requestOf(kSize.x, kSize.y)).frame);
    uint32_t counted = 0;
    for (const char* normal : {"0 0 0", "0 0 -1", "1e-45 0 0", "-0 0 -0", "0 0 -3"}) {
        const Scene scene = load("bad.obj", fmt::format("vn {}\nvn 0 0 1\nf 1//1 2//2 3//1\n", normal));
        EXPECT_EQ(scene.meshes[0].repairedNormals, 2u) << normal;
        EXPECT_FALSE(scene.warnings.empty());
        counted += scene.meshes[0].repairedNormals;
        EXPECT_EQ(hashOf(test::expectDeviceEqualsTwin(scene, requestOf(kSize.x, kSize.y), normal).frame), want) << normal;
    }
    fmt::print("row 21: {} zero or opposite normals replaced by the face's, counted; the pictures are the face normal's\n", counted);
}

// Row 22. Device and twin; and the frame does not depend on bands and chunks.
TEST(Extremes, Row22Resolutions) {
    std::vector<glm::uvec2> sizes{{1, 1}, {1, 65535}, {65535, 8}, {17, 9}, {15, 7}, {333, 211}, {4096, 4096}};
    if (std::getenv("PLUMB_LONG")) sizes.push_back({16384, 16384});
    for (const glm::uvec2 size : sizes) {
        const Scene scene = torus(size);
        RenderRequest request = requestOf(size.x, size.y);
        if (uint64_t(size.x) * size.y > 1000000) request.planes = kPlaneColour | kPlaneTriangle;
        const RenderResult r = test::expectDeviceEqualsTwin(scene, request, fmt::format("{}x{}", size.x, size.y));
        if (uint64_t(size.x) * size.y <= 1000000) {
            request.knobs.bandRows = std::max(1u, size.y / 3);
            request.knobs.chunkTriangles = 100;
            test::expectSameFrames(r.frame, renderGpu(test::lavapipe(), scene, request).frame,
                                   fmt::format("{}x{} in bands and chunks", size.x, size.y));
        }
        fmt::print("row 22: {}x{}: {} pixels covered, device = twin, sha256 {:.12}\n", size.x, size.y, r.frame.coveredPixels,
                   hashOf(r.frame.rgba));
    }
    RenderRequest tooLarge = requestOf(65537, 1);
    std::string message;
    try {
        renderCpu(torus(), tooLarge);
    } catch (const Error& error) {
        message = error.what();
    }
    EXPECT_NE(message.find("65536"), std::string::npos) << "the limit is named: " << message;
}

}  // namespace
}  // namespace plumb
