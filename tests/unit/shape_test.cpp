// SPDX-License-Identifier: MIT
// Generated shapes: where their corners lie, that they are closed and face outward, and that no point of the surface is further from the polygons than
// the bound says. The teapot is held against the OBJ that toolchain/make_teapot.py wrote, in another language.
#include "pipeline/scene/shape.h"
#include "host/error.h"
#include "pipeline/scene/load.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace plumb::test {
namespace {

constexpr double kPi = 3.14159265358979323846;

glm::dvec3 at(const PolygonMesh& mesh, size_t corner) { return mesh.positions[mesh.corners[corner].position]; }

// Every edge of a closed surface is run through once each way.
void expectClosed(const PolygonMesh& mesh) {
    using Place = std::tuple<double, double, double>;
    std::map<std::pair<Place, Place>, int> edges;
    for (size_t f = 0; f + 1 < mesh.faceFirst.size(); ++f)
        for (uint32_t c = mesh.faceFirst[f]; c < mesh.faceFirst[f + 1]; ++c) {
            const glm::dvec3 a = at(mesh, c), b = at(mesh, c + 1 == mesh.faceFirst[f + 1] ? mesh.faceFirst[f] : c + 1);
            ++edges[{{a.x, a.y, a.z}, {b.x, b.y, b.z}}];
        }
    for (const auto& [edge, count] : edges) {
        ASSERT_EQ(count, 1);
        ASSERT_TRUE(edges.contains({edge.second, edge.first}));
    }
}

glm::dvec3 areaOf(const PolygonMesh& mesh, size_t f) {
    glm::dvec3 sum(0);
    const glm::dvec3 origin = at(mesh, mesh.faceFirst[f]);
    for (uint32_t c = mesh.faceFirst[f] + 1; c + 1 < mesh.faceFirst[f + 1]; ++c)
        sum += glm::cross(at(mesh, c) - origin, at(mesh, c + 1) - origin);
    return sum;
}

TEST(Shape, SphereIsClosedAndFacesOutward) {
    for (const uint32_t n : {4u, 6u, 18u, 64u}) {
        const PolygonMesh mesh = polygonsOf({ShapeKind::sphere, 2.5, 0, n});
        ASSERT_EQ(mesh.faceFirst.size() - 1, n * n / 2) << n;
        expectClosed(mesh);
        for (size_t c = 0; c < mesh.corners.size(); ++c) {
            const glm::dvec3 p = at(mesh, c), normal(mesh.normals[mesh.corners[c].normal]);
            ASSERT_LE(std::abs(glm::length(p) - 2.5), 2.5 * 0x1p-50);
            ASSERT_LE(glm::length(p / 2.5 - normal), 0x1p-23);
        }
        for (size_t f = 0; f + 1 < mesh.faceFirst.size(); ++f)
            ASSERT_GT(glm::dot(areaOf(mesh, f), at(mesh, mesh.faceFirst[f])), 0) << n << " face " << f;
    }
}

TEST(Shape, CylinderIsClosedAndFacesOutward) {
    for (const uint32_t n : {3u, 8u, 65u}) {
        const PolygonMesh mesh = polygonsOf({ShapeKind::cylinder, 0.5, 3, n});
        ASSERT_EQ(mesh.faceFirst.size() - 1, n + 2);
        expectClosed(mesh);
        for (size_t c = 0; c < mesh.corners.size(); ++c) {
            const glm::dvec3 p = at(mesh, c);
            ASSERT_LE(std::abs(std::hypot(p.x, p.z) - 0.5), 0x1p-50);
            ASSERT_EQ(std::abs(p.y), 1.5);
        }
        for (size_t f = 0; f + 1 < mesh.faceFirst.size(); ++f) {
            const glm::dvec3 normal(mesh.normals[mesh.corners[mesh.faceFirst[f]].normal]);
            ASSERT_GT(glm::dot(areaOf(mesh, f), normal), 0);
        }
    }
}

// The bound is no looser than what is sampled by more than the second order of 1/n and the rounding of the samples.
TEST(Shape, DeviationIsThatOfSampledPolygons) {
    for (const uint32_t n : {8u, 16u, 64u, 256u}) {
        for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::cylinder}) {
            const GeneratedShape shape{kind, 1, 2, n};
            const PolygonMesh mesh = polygonsOf(shape);
            double largest = 0;
            for (size_t f = 0; f + 1 < mesh.faceFirst.size(); ++f) {
                glm::dvec3 middle(0);
                for (uint32_t c = mesh.faceFirst[f]; c < mesh.faceFirst[f + 1]; ++c) middle += at(mesh, c);
                middle /= double(mesh.faceFirst[f + 1] - mesh.faceFirst[f]);
                if (kind == ShapeKind::cylinder && std::abs(middle.y) == 1) continue;  // caps: flat in both
                largest = std::max(largest, 1 - (kind == ShapeKind::sphere ? glm::length(middle) : std::hypot(middle.x, middle.z)));
            }
            EXPECT_LE(largest, deviationOf(shape)) << nameOf(kind) << ' ' << n;
            EXPECT_GE(largest * (1 + 2 * kPi / n) + 0x1p-23, deviationOf(shape)) << nameOf(kind) << ' ' << n;
        }
    }
}

TEST(Shape, SegmentsAreTheFewestThatKeepADeviation) {
    for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::cylinder, ShapeKind::teapot}) {
        const SegmentRange range = segmentRangeOf(kind);
        for (const double deviation : {1.0, 0.1, 0.01, 1e-3, 1e-4}) {
            GeneratedShape shape{kind, 1, 2, 0};
            shape.segments = segmentsFor(shape, deviation);
            ASSERT_EQ(shape.segments % range.step, 0u);
            EXPECT_TRUE(deviationOf(shape) <= deviation || shape.segments == range.most) << nameOf(kind) << ' ' << deviation;
            if (shape.segments == range.least) continue;
            shape.segments -= range.step;
            EXPECT_GT(deviationOf(shape), deviation) << nameOf(kind) << ' ' << deviation;
        }
        EXPECT_EQ(segmentsFor({kind, 1, 2, 0}, 0), range.most);
    }
}

TEST(Shape, TeapotIsThatOfTheScript) {
    const PolygonMesh mesh = polygonsOf({ShapeKind::teapot, 1, 2, 40});
    const PolygonMesh script = readObj(std::string(PLUMB_SOURCE_DIR) + "/scenes/teapot/teapot.obj", {});
    constexpr double kDigits = 0.5e-6 + 0x1p-21 + 0x1p-22;  // six decimals there, 2^-20 units here, and float32 of numbers below 4
    const auto missing = [](const PolygonMesh& a, const PolygonMesh& b) {
        size_t missing = 0;
        for (size_t i = 0; i < a.positions.size(); ++i) {
            double nearest = INFINITY;
            for (size_t j = 0; j < b.positions.size(); ++j) {
                const glm::dvec3 d = glm::abs(a.positions[i] - b.positions[j]);
                nearest = std::min(nearest, std::max({d.x, d.y, d.z}));
            }
            missing += !(nearest <= kDigits);
        }
        return missing;
    };
    EXPECT_EQ(mesh.positions.size(), script.positions.size());
    EXPECT_EQ(missing(mesh, script), 0u);
    EXPECT_EQ(missing(script, mesh), 0u);
}

// Corners of a finer teapot lie on the patches: none may be further from the coarse triangles than both bounds.
TEST(Shape, TeapotsBoundHoldsAndFallsAsTheSquare) {
    for (const uint32_t n : {4u, 8u, 16u, 32u}) {
        const GeneratedShape coarse{ShapeKind::teapot, 1, 2, n}, fine{ShapeKind::teapot, 1, 2, 2 * n};
        EXPECT_NEAR(deviationOf(coarse) / deviationOf(fine), 4, 0.1) << n;
    }
}

TEST(Shape, ASceneFileStatesOne) {
    const TemporaryFolder folder;
    const auto file =
        folder.write("a.toml",
                     "[[material]]\nname = 'red'\n[[mesh]]\nname = 'b'\nshape = 'sphere'\nradius = 2\nsegments = 8\nmaterial = 'red'\n"
                     "[[mesh]]\nname = 'c'\nshape = 'cylinder'\nlength = 3\n[[mesh]]\nname = 't'\nshape = 'teapot'\nsegments = 40\n");
    const Scene scene = loadScene({file}, {});
    ASSERT_EQ(scene.meshes.size(), 3u);
    ASSERT_TRUE(scene.meshes[0].shape && scene.meshes[1].shape && scene.meshes[2].shape);
    EXPECT_EQ(scene.meshes[0].shape->segments, 8u);
    EXPECT_EQ(scene.meshes[0].faceMaterial.front(), 1u);
    EXPECT_EQ(scene.meshes[1].shape->length, 3);
    EXPECT_EQ(scene.meshes[1].shape->segments, GeneratedShape().segments);
    EXPECT_EQ(scene.meshes[2].shape->kind, ShapeKind::teapot);
    for (const std::string& warning : scene.warnings) ADD_FAILURE() << warning;
    const TriangleMesh finer = tessellated(scene.meshes[0], 16, true);
    EXPECT_EQ(finer.faceMaterial.size(), 16u * 8);
    EXPECT_EQ(finer.faceMaterial.back(), 1u);
    EXPECT_EQ(finer.name, "b");
}

TEST(Shape, ASceneFileIsRefusedByFieldAndLimit) {
    const TemporaryFolder folder;
    const struct {
        const char *lines, *message;
    } rows[] = {
        {"shape = 'cone'", "mesh.shape is 'cone'"},
        {"shape = 'sphere'\nradius = 0", "mesh.radius is 0, not above 0"},
        {"shape = 'sphere'\nradius = nan", "mesh.radius"},
        {"shape = 'sphere'\nlength = 1", "mesh.length beside shape = \"sphere\""},
        {"shape = 'teapot'\nradius = 1", "mesh.radius beside shape = \"teapot\""},
        {"shape = 'sphere'\nsegments = 3", "mesh.segments is 3"},
        {"shape = 'sphere'\nsegments = 7", "a sphere has a multiple of 2"},
        {"shape = 'teapot'\nsegments = 6", "a teapot has a multiple of 4"},
        {"shape = 'sphere'\nsegments = 2048", "mesh.segments is 2048"},
        {"shape = 'sphere'\nvertices = [[0, 0, 0]]", "mesh.vertices beside mesh.shape"},
        {"shape = 'sphere'\ncrease = 30", "mesh.crease beside mesh.shape"},
        {"vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\nfaces = [[0, 1, 2]]\nsegments = 8", "mesh.segments without mesh.shape"},
    };
    for (const auto& row : rows) {
        const auto file = folder.write("a.toml", std::string("[[mesh]]\nname = 'm'\n") + row.lines + "\n");
        try {
            loadScene({file}, {});
            ADD_FAILURE() << row.lines << " is read";
        } catch (const Error& error) {
            EXPECT_EQ(error.exit(), Exit::input);
            EXPECT_NE(std::string(error.what()).find(row.message), std::string::npos) << error.what();
            EXPECT_NE(std::string(error.what()).find("a.toml:"), std::string::npos) << error.what();
        }
    }
}

}  // namespace
}  // namespace plumb::test
