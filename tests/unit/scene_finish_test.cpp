// SPDX-License-Identifier: MIT
// Polygons to triangles: area, order, normals, vertices and edges, against closed forms.
#include "host/error.h"
#include "pipeline/scene/load.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;

constexpr double kPi = 3.14159265358979323846;

// Rounding a unit vector to float32 changes each component by at most 2^-25, so its length by at most sqrt(3) 2^-25.
constexpr double kUnitTolerance = 0x1p-23;

PolygonMesh polygons(std::vector<vec3> positions, const std::vector<std::vector<uint32_t>>& faces) {
    PolygonMesh mesh;
    mesh.name = "made";
    mesh.positions = std::move(positions);
    mesh.faceFirst.push_back(0);
    for (const auto& face : faces) {
        for (uint32_t p : face) mesh.corners.push_back({p});
        mesh.faceFirst.push_back(uint32_t(mesh.corners.size()));
        mesh.faceMaterial.push_back(kNone);
    }
    return mesh;
}

PolygonMesh onePolygon(const std::vector<vec3>& outline) {
    std::vector<uint32_t> face(outline.size());
    for (uint32_t i = 0; i < face.size(); ++i) face[i] = i;
    return polygons(outline, {face});
}

TriangleMesh finish(const PolygonMesh& mesh, double crease = 60) {
    std::vector<Material> materials(1);
    LoadOptions options;
    options.creaseDegrees = crease;
    return finishMesh(mesh, materials, 0, options);
}

dvec3 areaVector(const TriangleMesh& mesh, const TriangleMesh::Triangle& t) {
    const dvec3 a(mesh.positions[t.vertex[0]]), b(mesh.positions[t.vertex[1]]), c(mesh.positions[t.vertex[2]]);
    return glm::cross(b - a, c - a) / 2.0;
}

dvec3 newell(const std::vector<vec3>& outline) {
    dvec3 sum(0);
    for (size_t i = 0; i < outline.size(); ++i) sum += glm::cross(dvec3(outline[i]), dvec3(outline[(i + 1) % outline.size()]));
    return sum / 2.0;
}

// The triangles tile the face: as many as corners - 2, none turned over, and their areas add up to the face's.
void expectTiles(const std::vector<vec3>& outline, const std::string& what, uint32_t withoutArea = 0) {
    const TriangleMesh mesh = finish(onePolygon(outline));
    ASSERT_EQ(mesh.triangles.size(), outline.size() - 2) << what;
    EXPECT_EQ(mesh.selfCrossingFaces, 0u) << what;
    const dvec3 whole = newell(outline);
    const dvec3 normal = glm::normalize(whole);
    double area = 0;
    uint32_t empty = 0;
    for (const auto& t : mesh.triangles) {
        const double part = glm::dot(areaVector(mesh, t), normal);
        EXPECT_GE(part, -1e-12 * glm::length(whole)) << what << ": a triangle is turned over";
        empty += part <= 1e-12 * glm::length(whole);
        area += std::abs(part);
    }
    EXPECT_NEAR(area, glm::length(whole), 1e-6 * glm::length(whole)) << what;
    EXPECT_EQ(empty, withoutArea) << what << ": triangles without area";
}

std::vector<vec3> inPlane(const std::vector<dvec2>& outline, const dvec3& u, const dvec3& v, const dvec3& origin) {
    std::vector<vec3> out;
    for (const dvec2& p : outline) out.push_back(vec3(origin + u * p.x + v * p.y));
    return out;
}

TEST(SceneFinish, ConcaveFacesAreTiledInTheirOwnPlane) {
    const std::map<std::string, std::vector<dvec2>> outlines = {
        {"quad", {{0, 0}, {2, 0}, {2, 1}, {0, 1}}},
        {"arrow", {{0, 0}, {2, 1}, {0, 2}, {0.5, 1}}},
        {"arrow, first corner reflex", {{0.5, 1}, {0, 0}, {2, 1}, {0, 2}}},
        {"L", {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}},
        {"U", {{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}},
        {"notch whose tip lies on a diagonal", {{0, 0}, {4, 0}, {4, 4}, {2, 2}, {0, 4}}},
        {"star", {{0, 3}, {-0.7, 1}, {-2.9, 0.9}, {-1.1, -0.4}, {-1.8, -2.4}, {0, -1.2}, {1.8, -2.4}, {1.1, -0.4}, {2.9, 0.9}, {0.7, 1}}},
        {"spiral", {{0, 0}, {6, 0}, {6, 6}, {1, 6}, {1, 2}, {4, 2}, {4, 4}, {3, 4}, {3, 3}, {2, 3}, {2, 5}, {5, 5}, {5, 1}, {0, 1}}},
        {"square with midpoints", {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}},
        {"triangle with many points on one side", {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {2, 3}}},
        {"square with a square hole, bridged", {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}}},
    };
    const dvec3 origins[] = {{0, 0, 0}, {5, -3, 2}};
    for (const auto& [name, outline] : outlines)
        for (const auto& [u, v] : std::vector<std::pair<dvec3, dvec3>>{{{1, 0, 0}, {0, 1, 0}},
                                                                       {{0, 1, 0}, {1, 0, 0}},
                                                                       {{0, 0, 1}, {1, 0, 0}},
                                                                       {{0, 1, 0}, {0, 0, 1}},
                                                                       {{0, 0, -1}, {0, 1, 0}},
                                                                       {{0.5, 0, 0.25}, {-0.125, 0.5, 0.25}},
                                                                       {{64, 32, 0}, {0, -32, 8}}})
            for (const dvec3& origin : origins)
                for (size_t turn = 0; turn < outline.size(); ++turn) {
                    std::vector<dvec2> turned(outline.begin() + long(turn), outline.end());
                    turned.insert(turned.end(), outline.begin(), outline.begin() + long(turn));
                    expectTiles(inPlane(turned, u, v, origin), fmt::format("{} turned by {}", name, turn));
                    if (HasFailure()) return;
                }
}

TEST(SceneFinish, RandomSimplePolygonsAreTiled) {
    std::mt19937 random(20260801);  // the distribution below is ours: std's differ between libraries
    const auto unit = [&] { return double(random() >> 8) / double(1 << 24); };
    for (int n = 4; n < 60; ++n)
        for (int round = 0; round < 20; ++round) {
            std::vector<vec3> outline;  // star-shaped, so simple; a third of the corners reflex
            for (int i = 0; i < n; ++i) {
                const double angle = 2 * kPi * (i + 0.8 * unit()) / n, radius = 0.2 + unit();
                outline.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
            }
            expectTiles(outline, fmt::format("{} corners, round {}", n, round));
            if (HasFailure()) return;
        }
}

TEST(SceneFinish, ALargeConcaveFaceTakesOrdinaryTime) {
    std::vector<vec3> comb;
    for (int i = 0; i < 4000; ++i) comb.push_back({float(i), float(i % 2), 0});
    comb.push_back({3999, 5, 0});
    comb.push_back({0, 5, 0});
    expectTiles(comb, "comb");
}

TEST(SceneFinish, ConvexFacesAreFansAndAnySizeIsTaken) {
    std::vector<vec3> circle;
    for (int i = 0; i < 20000; ++i) circle.push_back({std::cos(2 * kPi * i / 20000) * 1000, std::sin(2 * kPi * i / 20000) * 1000, 0});
    const TriangleMesh mesh = finish(onePolygon(circle));
    ASSERT_EQ(mesh.triangles.size(), 19998u);
    const std::vector<vec3> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const TriangleMesh fan = finish(onePolygon(square));
    ASSERT_EQ(fan.triangles.size(), 2u);
    EXPECT_EQ(fan.triangles[0].vertex[2], 2u);
    EXPECT_EQ(fan.triangles[1].vertex[1], 2u);
}

TEST(SceneFinish, SelfCrossingFacesAreCutAsFansAndCounted) {
    const std::vector<vec3> bow = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 2, 0}, {2, 3, 0}};
    TriangleMesh mesh = finish(onePolygon(bow));
    EXPECT_EQ(mesh.triangles.size(), 3u);
    std::vector<vec3> pentagram;
    for (int i = 0; i < 5; ++i) pentagram.push_back({std::cos(4 * kPi * i / 5), std::sin(4 * kPi * i / 5), 0});
    mesh = finish(onePolygon(pentagram));
    EXPECT_EQ(mesh.triangles.size(), 3u);
    EXPECT_EQ(mesh.selfCrossingFaces, 1u);
    // A bow tie whose halves cancel has no area at all.
    mesh = finish(onePolygon({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(mesh.degenerateFaces, 1u);
    EXPECT_EQ(mesh.triangles.size(), 2u);
}

TEST(SceneFinish, FacesWithoutAreaAreCountedAndKeepTheirNumber) {
    const PolygonMesh in =
        polygons({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0.1f, 0.1f, 0.1f}, {0.2f, 0.2f, 0.2f}, {0.3f, 0.3f, 0.3f}},
                 {{0, 1, 2}, {0, 0, 3}, {0, 1, 3}, {1, 1, 1}, {4, 5, 6}});
    const TriangleMesh mesh = finish(in);
    // 0.1f, 0.2f, 0.3f are not quite in proportion, but on one line all the same: x = y = z.
    EXPECT_EQ(mesh.degenerateFaces, 4u);
    ASSERT_EQ(mesh.triangles.size(), 5u);
    for (uint32_t f = 0; f < 5; ++f) EXPECT_EQ(mesh.triangles[f].face, f);
    EXPECT_EQ(mesh.faceNormal[0], vec3(0, 0, 1));
    for (const vec3& n : mesh.normals) EXPECT_EQ(glm::length(dvec3(n)), 1.0);
}

const std::vector<vec3> kCube = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
const std::vector<std::vector<uint32_t>> kCubeFaces = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

TEST(SceneFinish, ACubeHasCreasesAndASphereHasNone) {
    const TriangleMesh cube = finish(polygons(kCube, kCubeFaces));
    EXPECT_EQ(cube.positions.size(), 24u);
    EXPECT_EQ(cube.triangles.size(), 12u);
    EXPECT_EQ(cube.edges.size(), 12u);
    for (const auto& t : cube.triangles)
        for (uint32_t v : t.vertex) EXPECT_EQ(cube.normals[v], cube.faceNormal[t.face]);
    EXPECT_EQ(cube.boundsMin, vec3(0));
    EXPECT_EQ(cube.boundsMax, vec3(1));

    const TriangleMesh round = finish(polygons(kCube, kCubeFaces), 100);
    ASSERT_EQ(round.positions.size(), 8u);
    for (size_t v = 0; v < 8; ++v) {
        const dvec3 diagonal = glm::normalize(dvec3(round.positions[v]) - 0.5);
        EXPECT_NEAR(glm::dot(dvec3(round.normals[v]), diagonal), 1, kUnitTolerance);
    }

    LoadOptions options;
    std::vector<Material> materials(1);
    const TriangleMesh sphere =
        finishMesh(readPly(std::string(PLUMB_SOURCE_DIR) + "/scenes/procedural/icosphere.ply", options), materials, 0, options);
    EXPECT_EQ(sphere.positions.size(), 2562u) << "10 * 4^4 + 2: no vertex is split";
    for (size_t v = 0; v < sphere.positions.size(); ++v) {
        // Faces of 2.2 degrees' radius; the mean's error is of second order: far below a quarter of a degree.
        EXPECT_GT(glm::dot(dvec3(sphere.normals[v]), glm::normalize(dvec3(sphere.positions[v]))), std::cos(0.25 * kPi / 180));
        EXPECT_NEAR(glm::length(dvec3(sphere.normals[v])), 1, kUnitTolerance);
    }
}

TEST(SceneFinish, CuttingAFaceInTwoLeavesItsNormalsAlone) {
    // A cube smoothed over, as quads and as triangles cut along either diagonal: angle weights do not notice.
    const TriangleMesh quads = finish(polygons(kCube, kCubeFaces), 100);
    for (const int first : {0, 1}) {
        std::vector<std::vector<uint32_t>> cut;
        for (const auto& f : kCubeFaces) {
            const size_t a = size_t(first), b = a + 1, c = a + 2, d = (a + 3) % 4;
            cut.push_back({f[a], f[b], f[c]});
            cut.push_back({f[a], f[c], f[d]});
        }
        const TriangleMesh triangles = finish(polygons(kCube, cut), 100);
        std::map<std::array<float, 3>, vec3> normalAt;
        for (size_t v = 0; v < quads.positions.size(); ++v)
            normalAt[{quads.positions[v].x, quads.positions[v].y, quads.positions[v].z}] = quads.normals[v];
        ASSERT_EQ(triangles.positions.size(), 8u);
        for (size_t v = 0; v < 8; ++v)
            EXPECT_GT(glm::dot(dvec3(triangles.normals[v]),
                               dvec3(normalAt[{triangles.positions[v].x, triangles.positions[v].y, triangles.positions[v].z}])),
                      1 - 1e-6);
    }
}

TEST(SceneFinish, TheCreaseAngleIsTheAngleBetweenNormals) {
    // Two squares that share the edge x = 0 and meet at `degrees` between their normals.
    for (const double degrees : {5.0, 30.0, 59.0, 61.0, 89.0, 120.0}) {
        const float c = float(std::cos(degrees * kPi / 180)), s = float(std::sin(degrees * kPi / 180));
        const TriangleMesh mesh =
            finish(polygons({{-1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {-1, 1, 0}, {c, 0, -s}, {c, 1, -s}}, {{0, 1, 2, 3}, {1, 4, 5, 2}}));
        EXPECT_EQ(mesh.positions.size(), degrees < 60 ? 6u : 8u) << degrees;
        EXPECT_EQ(mesh.edges.size(), 7u);
    }
}

TEST(SceneFinish, SmoothingGroupsOverruleTheCreaseAngle) {
    PolygonMesh cube = polygons(kCube, kCubeFaces);
    cube.faceSmoothing.assign(6, 1);
    EXPECT_EQ(finish(cube).positions.size(), 8u) << "one group: smooth over right angles";
    cube.faceSmoothing = {1, 1, 2, 2, 2, 2};
    EXPECT_EQ(finish(cube).positions.size(), 16u) << "sides among themselves";
    cube.faceSmoothing.assign(6, kNone);
    EXPECT_EQ(finish(cube).positions.size(), 24u);
    cube.faceSmoothing.assign(6, 0);
    EXPECT_EQ(finish(cube, 179).positions.size(), 24u) << "off is flat";
}

TEST(SceneFinish, PositionsOfEqualBitsAreOnePlace) {
    // STL's way: every triangle has its own positions. Also -0 is 0.
    std::vector<vec3> soup;
    std::vector<std::vector<uint32_t>> faces;
    for (const auto& f : kCubeFaces)
        for (const std::array<size_t, 3> t : {std::array<size_t, 3>{0, 1, 2}, {0, 2, 3}}) {
            faces.push_back({uint32_t(soup.size()), uint32_t(soup.size() + 1), uint32_t(soup.size() + 2)});
            for (size_t i : t) {
                soup.push_back(kCube[f[i]]);
                if (faces.size() % 2 && soup.back().x == 0) soup.back().x = -0.0f;
            }
        }
    const TriangleMesh mesh = finish(polygons(soup, faces));
    EXPECT_EQ(mesh.positions.size(), 24u);
    EXPECT_EQ(mesh.edges.size(), 18u) << "12 edges and 6 diagonals, each once";
    EXPECT_EQ(mesh.flushedDenormals, 0u);
    for (const vec3& p : mesh.positions)
        for (int i = 0; i < 3; ++i) EXPECT_FALSE(std::signbit(p[i]));
}

TEST(SceneFinish, VerticesAreDistinctAndFirstUsedFirst) {
    LoadOptions options;
    std::vector<Material> materials(1);
    const TriangleMesh mesh =
        finishMesh(readObj(std::string(PLUMB_SOURCE_DIR) + "/scenes/procedural/gear.obj", options), materials, 0, options);
    std::set<std::array<uint32_t, 7>> seen;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const vec3 &p = mesh.positions[v], &n = mesh.normals[v];
        EXPECT_TRUE(
            seen.insert({std::bit_cast<uint32_t>(p.x), std::bit_cast<uint32_t>(p.y), std::bit_cast<uint32_t>(p.z),
                         std::bit_cast<uint32_t>(n.x), std::bit_cast<uint32_t>(n.y), std::bit_cast<uint32_t>(n.z), mesh.vertexMaterial[v]})
                .second);
    }
    EXPECT_EQ(materials.size(), 2u);
    EXPECT_EQ(mesh.faceMaterial[0], 1u) << "after those that were there";
    std::set<std::pair<uint32_t, uint32_t>> edges;
    for (const auto& e : mesh.edges) EXPECT_TRUE(edges.insert(std::minmax(e.x, e.y)).second);
}

TEST(SceneFinish, EdgesAreOnceByPositionEvenAcrossCreases) {
    const TriangleMesh cube = finish(polygons(kCube, kCubeFaces));
    std::set<std::set<std::array<float, 3>>> edges;
    for (const auto& e : cube.edges) {
        const vec3 a = cube.positions[e.x], b = cube.positions[e.y];
        EXPECT_TRUE(edges.insert({{a.x, a.y, a.z}, {b.x, b.y, b.z}}).second);
        EXPECT_EQ(glm::length(a - b), 1.0f) << "a polygon edge, not a diagonal";
    }
}

TEST(SceneFinish, GivenNormalsAreMadeUnitZeroAndOppositeOnesReplaced) {
    PolygonMesh in = onePolygon({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    in.normals = {{0, 0, 5}, {0, 0, 0}, {0, 0, -1}, {3, 0, 4}, {1, 0, -0.1f}, {1e-40f, 0, 0}, {0, 1e30f, 1e30f}};
    const auto with = [&](uint32_t normal) {
        for (auto& corner : in.corners) corner.normal = normal;
        return finish(in);
    };
    EXPECT_EQ(with(0).normals[0], vec3(0, 0, 1));
    EXPECT_EQ(with(0).repairedNormals, 0u);
    EXPECT_EQ(with(1).normals[0], vec3(0, 0, 1));
    EXPECT_EQ(with(1).repairedNormals, 3u);
    EXPECT_EQ(with(2).normals[0], vec3(0, 0, 1)) << "opposite";
    EXPECT_EQ(with(2).repairedNormals, 3u);
    EXPECT_EQ(with(3).normals[0], vec3(0.6f, 0, 0.8f));
    EXPECT_EQ(with(4).repairedNormals, 0u) << "a little beyond the horizon is the file's business";
    EXPECT_EQ(with(5).flushedDenormals, 1u);
    EXPECT_EQ(with(5).normals[0], vec3(0, 0, 1));
    EXPECT_NEAR(with(6).normals[0].y, std::sqrt(0.5), 1e-7) << "no overflow";
}

TEST(SceneFinish, ANormalThatCancelsIsTheFaces) {
    // One group smooths two faces that lie back to back: their mean is nothing.
    PolygonMesh in = polygons({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}});
    in.faceSmoothing = {1, 1};
    const TriangleMesh mesh = finish(in);
    EXPECT_EQ(mesh.repairedNormals, 6u);
    for (const auto& t : mesh.triangles) EXPECT_EQ(mesh.normals[t.vertex[0]], mesh.faceNormal[t.face]);
    // Nearly back to back: what is left of the mean has lost more than 10 bits. Less nearly: it is kept.
    in = polygons({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 1e-4f}}, {{0, 1, 2}, {0, 3, 1}});
    in.faceSmoothing = {1, 1};
    EXPECT_EQ(finish(in).repairedNormals, 4u) << "the two corners on the common edge, in both faces";
    in.positions.set(3, {0, 1, 0.1});
    EXPECT_EQ(finish(in).repairedNormals, 0u);
}

TEST(SceneFinish, DenormalsBecomeZeroAndAreCounted) {
    PolygonMesh in = onePolygon({{1e-40f, 0, 0}, {1, -1e-39f, 0}, {0, 1, 0x1p-126f}});
    in.materials.emplace_back();
    in.materials[0].diffuse = {1e-41f, 0.5f, 0};
    in.faceMaterial[0] = 0;
    std::vector<Material> materials;
    const TriangleMesh mesh = finishMesh(in, materials, kNone, {});
    EXPECT_EQ(mesh.flushedDenormals, 3u);
    EXPECT_EQ(mesh.positions[0], vec3(0));
    EXPECT_EQ(mesh.positions[2].z, 0x1p-126f) << "the smallest normal stays";
    EXPECT_EQ(materials.at(0).diffuse.x, 0.0f);
}

TEST(SceneFinish, FaceRecordsFollowTheFile) {
    const TriangleMesh mesh = finish(polygons({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}}, {{0, 1, 2, 3}, {0, 4, 1}}));
    EXPECT_EQ(mesh.faceCentre[0], vec3(1, 1, 0));
    EXPECT_EQ(mesh.faceNormal[0], vec3(0, 0, 1));
    EXPECT_EQ(mesh.faceNormal[1], vec3(0, 1, 0));
    EXPECT_EQ(mesh.triangles[0].face, 0u);
    EXPECT_EQ(mesh.triangles[1].face, 0u);
    EXPECT_EQ(mesh.triangles[2].face, 1u);
}

// Row 2 of docs/extremes.md: scaling by a power of two changes no bit but exponents, so nothing here has an absolute threshold.
TEST(SceneFinish, PowersOfTwoScaleEverythingExactly) {
    LoadOptions options;
    const PolygonMesh in = readObj(std::string(PLUMB_SOURCE_DIR) + "/scenes/procedural/gear.obj", options);
    std::vector<Material> materials(1);
    const TriangleMesh base = finishMesh(in, materials, 0, options);
    for (const int k : {-60, -1, 1, 60}) {
        PolygonMesh scaled = in;
        for (size_t i = 0; i < in.positions.size(); ++i) scaled.positions.set(i, in.positions[i] * std::ldexp(1.0, k));
        const TriangleMesh mesh = finishMesh(scaled, materials, 0, options);
        EXPECT_EQ(mesh.normals, base.normals) << k;
        EXPECT_EQ(mesh.edges, base.edges) << k;
        ASSERT_EQ(mesh.triangles.size(), base.triangles.size());
        for (size_t t = 0; t < mesh.triangles.size(); ++t)
            for (int i = 0; i < 3; ++i) EXPECT_EQ(mesh.triangles[t].vertex[i], base.triangles[t].vertex[i]) << k;
    }
}

}  // namespace
}  // namespace plumb
