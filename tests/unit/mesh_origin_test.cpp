// SPDX-License-Identifier: MIT
// A mesh far from 0 keeps the digits of its file: its origin, what is left from there, and what readers hand on.
#include "pipeline/scene/mesh_origin.h"
#include "host/error.h"
#include "pipeline/scene/load.h"
#include "tests/support/temporary_folder.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace plumb {
namespace {

using glm::dvec3;
using glm::vec3;
using test::TemporaryFolder;

// Unit round-off of float32.
constexpr double kUnit = 0x1p-24;
// From an origin a coordinate is at most its half extent and half a step of the origin's grid, 1/16 of the largest half extent.
constexpr double kReach = 1 + 1.0 / 16;

TEST(MeshOrigin, StaysAtZeroForMeshesThatLieAboutIt) {
    EXPECT_EQ(originOfBox(dvec3(-1), dvec3(1)), dvec3(0));
    EXPECT_EQ(originOfBox(dvec3(0), dvec3(1)), dvec3(0)) << "a corner at 0";
    EXPECT_EQ(originOfBox(dvec3(2, 0, 0), dvec3(4, 1, 1)), dvec3(0)) << "four half extents away";
    EXPECT_EQ(originOfBox(dvec3(0, -1, 0), dvec3(10, -1, 10)), dvec3(0)) << "a floor below 0";
    EXPECT_EQ(originOfBox(dvec3(5), dvec3(5)), dvec3(0)) << "a point has no extent to measure with";
    EXPECT_EQ(originOfBox(dvec3(0), dvec3(-1)), dvec3(0)) << "an empty box";
    EXPECT_NE(originOfBox(dvec3(2.01, 0, 0), dvec3(4.01, 1, 1)).x, 0.0) << "just beyond four";
}

TEST(MeshOrigin, IsTakenFromTheAxesThatAreFarOnly) {
    const dvec3 origin = originOfBox({1e5, -1, -2}, {1e5 + 3, 1, 2});
    EXPECT_GT(origin.x, 1e5);
    EXPECT_LT(origin.x, 1e5 + 3);
    EXPECT_EQ(origin.y, 0.0);
    EXPECT_EQ(origin.z, 0.0);
}

// Whatever a box's place and size: what is left is no larger than kReach half extents, and a float32 number stays a float32 number.
TEST(MeshOrigin, LeavesLittleAndTakesFloat32NumbersExactly) {
    std::mt19937 random(12);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int round = 0; round < 20000; ++round) {
        const double half = std::ldexp(1 + std::abs(unit(random)), int(random() % 60) - 30);
        const double away = half * std::exp2(2.01 + 18 * std::abs(unit(random))) * (unit(random) < 0 ? -1 : 1);
        const float low = float(away - half), high = float(away + half);
        if (!(high > low)) continue;
        const dvec3 origin = originOfBox(dvec3(double(low), 0, 0), dvec3(double(high), 0, 0));
        const double extent = (double(high) - double(low)) / 2;
        ASSERT_EQ(origin.x != 0, double(std::max(std::abs(low), std::abs(high))) > kNearHalfExtents * extent);
        for (int i = 0; i < 8; ++i) {
            const float p = float(double(low) + (double(high) - double(low)) * std::abs(unit(random)));
            const double left = double(p) - origin.x;
            ASSERT_EQ(double(float(left)), left) << fmt::format("{} from {} in {} to {}", p, origin.x, low, high);
            ASSERT_LE(std::abs(left), origin.x != 0 ? kReach * extent : kNearHalfExtents * extent);
        }
    }
}

// A tilted quad with centimetres of detail, at a place that float32 spaces by 1/2 or nothing.
constexpr double kCorners[4][3] = {{0, 0, 0.001}, {0.3217, 0, 0.0339}, {0.32, 0.3203, 0.0559}, {0.0101, 0.319, 0.0584}};
const dvec3 kNear(0), kMap(412345.67, 5287654.32, 412.44);

std::string number(double corner, double at) { return fmt::format("{:.4f}", corner + at); }
std::string line(const double (&corner)[3], const dvec3& at) {
    return number(corner[0], at.x) + " " + number(corner[1], at.y) + " " + number(corner[2], at.z);
}

template <class T>
void put(std::string& bytes, T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes.append(raw, sizeof(T));
}

struct File {
    const char* name;
    std::string bytes;
};
// Four formats that hold the digits; a PLY of doubles, and one whose header says float and whose text says more.
std::vector<File> filesAt(const dvec3& at) {
    std::string obj, off = "OFF\n4 1 0\n", ascii, binary, stl = "solid s\n", toml = "[[mesh]]\nname = 'm'\nvertices = [";
    for (const auto& corner : kCorners) {
        obj += "v " + line(corner, at) + "\n";
        off += line(corner, at) + "\n";
        ascii += line(corner, at) + "\n";
        toml += "[" + number(corner[0], at.x) + ", " + number(corner[1], at.y) + ", " + number(corner[2], at.z) + "],";
        for (int i = 0; i < 3; ++i) put(binary, std::stod(number(corner[i], at[i])));
    }
    for (const auto& face : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
        stl += "facet normal 0 0 0\nouter loop\n";
        for (int v : face) stl += "vertex " + line(kCorners[v], at) + "\n";
        stl += "endloop\nendfacet\n";
    }
    const auto header = [](const char* format, const char* type) {
        return fmt::format(
            "ply\nformat {0} 1.0\nelement vertex 4\nproperty {1} x\nproperty {1} y\nproperty {1} z\nelement face 1\nproperty list uchar "
            "int vertex_indices\nend_header\n",
            format, type);
    };
    put(binary, uint8_t(4));
    for (int32_t i = 0; i < 4; ++i) put(binary, i);
    return {{"m.obj", obj + "f 1 2 3 4\n"},
            {"m.off", off + "4 0 1 2 3\n"},
            {"m.stl", stl + "endsolid s\n"},
            {"m.toml", toml + "]\nfaces = [[0, 1, 2, 3]]\n[[object]]\nmesh = 'm'\n"},
            {"double.ply", header("binary_little_endian", "double") + binary},
            {"text.ply", header("ascii", "float") + ascii + "4 0 1 2 3\n"}};
}

Scene sceneOf(const File& file, bool keepNumbers) {
    const TemporaryFolder folder;
    LoadOptions options;
    options.keepNumbers = keepNumbers;
    return loadScene({folder.write(file.name, file.bytes)}, options);
}

TEST(MeshOrigin, EveryReaderKeepsTheDigitsOfAFarMesh) {
    const std::vector<File> near = filesAt(kNear), far = filesAt(kMap);
    for (size_t f = 0; f < far.size(); ++f) {
        const Scene here = sceneOf(near[f], true), there = sceneOf(far[f], true);
        const TriangleMesh &a = here.meshes.at(0), &b = there.meshes.at(0);
        EXPECT_EQ(a.origin, dvec3(0)) << near[f].name;
        for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(b.origin[i] - kMap[i]), 1) << far[f].name;
        EXPECT_EQ(b.degenerateFaces, 0u) << far[f].name;
        ASSERT_EQ(a.positions.size(), b.positions.size()) << far[f].name;
        ASSERT_EQ(a.triangles.size(), b.triangles.size()) << far[f].name;
        for (size_t v = 0; v < a.positions.size(); ++v)
            for (int i = 0; i < 3; ++i) {
                // The file's own number, to half an ULP of float32 at a coordinate from the origin.
                const double half = 0.5 * 0.3217;
                const double left = std::abs(b.origin[i] + double(b.positions[v][i]) - b.statedAt(v)[i]);
                EXPECT_LE(left, kUnit * kReach * half + 0x1p-53 * kMap[i]) << far[f].name << " vertex " << v;
                EXPECT_LE(left, b.lost[i] + 0x1p-53 * kMap[i]);
                // What the text says, read by the C library.
                EXPECT_EQ(b.statedAt(v)[i], std::stod(number(a.statedAt(v)[i], kMap[i]))) << far[f].name << " vertex " << v;
            }
        // Normals follow from the recentred positions: those of the near twin to the rounding of 4 decimals in either file.
        for (size_t v = 0; v < a.normals.size(); ++v) EXPECT_GT(glm::dot(a.normals[v], b.normals[v]), 1 - 1e-6f) << far[f].name;
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(b.statedMin[i], kMap[i] + a.statedMin[i], 1e-4) << far[f].name;
            EXPECT_NEAR(b.statedMax[i], kMap[i] + a.statedMax[i], 1e-4) << far[f].name;
        }
        // Where the mesh is in the world, through the composite that the passes take.
        const glm::dmat4 m = worldFromMesh(there, there.objects.at(0));
        EXPECT_LT(glm::length(dvec3(m * glm::dvec4(b.positions[0], 1)) - b.statedAt(0)), 1e-6) << far[f].name;
    }
}

TEST(MeshOrigin, NumbersAreKeptOnlyWhereAskedForAndRounded) {
    const File far = filesAt(kMap)[0];
    EXPECT_EQ(sceneOf(far, true).meshes[0].stated.size(), 4u);
    const Scene without = sceneOf(far, false);
    EXPECT_TRUE(without.meshes[0].stated.empty());
    EXPECT_EQ(without.meshes[0].positions, sceneOf(far, true).meshes[0].positions) << "what is drawn does not depend on it";
    // Halves: float32 holds them, there too.
    const File halves{"m.obj", "v 400000.5 0 0\nv 400001.5 0 0\nv 400001 1 0\nf 1 2 3\n"};
    const TriangleMesh exact = sceneOf(halves, true).meshes[0];
    EXPECT_NE(exact.origin.x, 0.0);
    EXPECT_EQ(exact.lost, dvec3(0));
    EXPECT_TRUE(exact.stated.empty());
    EXPECT_EQ(exact.statedAt(1), dvec3(400001.5, 0, 0));
}

TEST(MeshOrigin, APositionThatNoFaceNamesMovesNothing) {
    const File stray{"m.obj", "v 0 0 0\nv 400000.5 0 0\nv 400001.5 0 0\nv 400001 1 0\nf 2 3 4\n"};
    const TriangleMesh mesh = sceneOf(stray, true).meshes[0];
    EXPECT_NE(mesh.origin.x, 0.0);
    EXPECT_EQ(mesh.statedMin, dvec3(400000.5, 0, 0));
}

// The mesh's own space is the file's: a transform about the centre, and a parent's, act as they do on a near mesh.
TEST(MeshOrigin, TransformsOfAFarMeshActOnTheFilesNumbers) {
    const TemporaryFolder folder;
    folder.write("m.obj", filesAt(kMap)[0].bytes);
    const Scene scene = loadScene({folder.write("s.toml",
                                                "[[mesh]]\nname = 'm'\nfile = 'm.obj'\n[[object]]\nmesh = 'm'\n"
                                                "transform = [{ rotate_z = 180, about = 'centre' }, { scale = 2, about = 'centre' }, { "
                                                "translate = [-412345.67, -5287654.32, -412.44] }]\n")},
                                  {});
    const TriangleMesh& mesh = scene.meshes[0];
    const dvec3 centre = (mesh.statedMin + mesh.statedMax) * 0.5;
    const glm::dmat4 m = worldFromMesh(scene, scene.objects[0]);
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const dvec3 p = mesh.statedAt(v), want = centre + dvec3(-2, -2, 2) * (p - centre) - kMap;
        EXPECT_LT(glm::length(dvec3(m * glm::dvec4(mesh.positions[v], 1)) - want), 1e-6) << v;
    }
}

TEST(Positions, StayNarrowUntilANumberNeedsMore) {
    Positions p;
    p.push_back({1, 2, 0.5});
    p.push_back({-0.0, 3, 4});
    EXPECT_EQ(p[0], dvec3(1, 2, 0.5));
    p.push_back({0.1, 0, 0});
    ASSERT_EQ(p.size(), 3u);
    EXPECT_EQ(p[0], dvec3(1, 2, 0.5));
    EXPECT_TRUE(std::signbit(p[1].x));
    EXPECT_EQ(p[2].x, 0.1);
    p.push_back({1, 1, 1});
    EXPECT_EQ(p[3], dvec3(1));
    p.set(0, {5, 5, 0.3});
    EXPECT_EQ(p[0], dvec3(5, 5, 0.3));
    EXPECT_FALSE(p == Positions(std::vector<vec3>(4)));
    p.release();
    EXPECT_TRUE(p.empty());
    EXPECT_TRUE(p == Positions());
}

TEST(Parsing, BinarySixtyFourKeepsWhatFloat32Loses) {
    const TemporaryFolder folder;
    const auto read = [&](const std::string& x) {
        return readObj(folder.write("m.obj", "v " + x + " 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), {}).positions[0].x;
    };
    EXPECT_EQ(read("5287654.3217"), 5287654.3217);
    EXPECT_EQ(read("1e30"), 1e30);
    EXPECT_EQ(read("1e-400"), std::numeric_limits<double>::denorm_min()) << "a number, for finishMesh to count";
    EXPECT_THROW(read("1e31"), Error);
    EXPECT_THROW(read("1e400"), Error);
    EXPECT_THROW(read("nan"), Error);
}

TEST(MeshOrigin, AMeshTooSmallForFloat32IsRefused) {
    EXPECT_THROW(sceneOf({"m.obj", "v 0 0 0\nv 1e-38 0 0\nv 0 1e-38 0\nf 1 2 3\n"}, true), Error);
    EXPECT_THROW(sceneOf({"m.obj", "v 0 0 0\nv 1e-60 0 0\nv 0 1e-60 0\nf 1 2 3\n"}, true), Error);
}

}  // namespace
}  // namespace plumb
