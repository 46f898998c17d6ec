// SPDX-License-Identifier: MIT
// A scene from memory is the scene that a file with the same numbers gives, and what cannot be drawn is refused in one sentence.
#include "pipeline/scene/mesh_arrays.h"
#include "host/error.h"
#include "pipeline/scene/check_scene.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/look_at.h"
#include "tests/support/temporary_folder.h"

#include <gtest/gtest.h>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();

// A roof of two triangles that meet at a right angle.
const std::vector<float> kPositions = {-1, 0, 0, 1, 0, 0, 0, 1, 0.5f, 0, 0, 1};
const std::vector<uint32_t> kTriangles = {0, 1, 2, 0, 3, 1};
const std::vector<float> kNormals = {0, 0, 2, 0, 1, 1, 1, 0, 0, 0, -1, 0};

MeshArrays roof() { return {.positions = kPositions, .triangles = kTriangles, .name = "roof"}; }

std::string refusalOf(const std::function<void()>& body) {
    try {
        body();
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::input);
        return error.what();
    }
    return "accepted";
}

void expectSame(const TriangleMesh& a, const TriangleMesh& b) {
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.faceNormal, b.faceNormal);
    EXPECT_EQ(a.faceCentre, b.faceCentre);
    EXPECT_EQ(a.edges, b.edges);
    EXPECT_EQ(a.origin, b.origin);
    ASSERT_EQ(a.triangles.size(), b.triangles.size());
    for (size_t t = 0; t < a.triangles.size(); ++t)
        for (int i = 0; i < 3; ++i) EXPECT_EQ(a.triangles[t].vertex[i], b.triangles[t].vertex[i]) << t;
}

Scene fromObj(const std::string& text, double creaseDegrees) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.path() / "roof.obj";
    std::ofstream(path) << text;
    LoadOptions options;
    options.creaseDegrees = creaseDegrees;
    return loadScene({path}, options);
}

TEST(MeshArrays, GiveTheMeshOfAFileWithTheSameNumbers) {
    const std::string vertices = "v -1 0 0\nv 1 0 0\nv 0 1 0.5\nv 0 0 1\n";
    for (const double crease : {0.0, 60.0, 180.0}) {
        SCOPED_TRACE(crease);
        MeshArrays arrays = roof();
        arrays.creaseDegrees = crease;
        Scene scene;
        EXPECT_EQ(addMesh(scene, arrays), 0u);
        expectSame(scene.meshes[0], fromObj(vertices + "f 1 2 3\nf 1 4 2\n", crease).meshes[0]);
    }
    MeshArrays arrays = roof();
    arrays.normals = kNormals;
    Scene scene;
    addMesh(scene, arrays);
    expectSame(scene.meshes[0],
               fromObj(vertices + "vn 0 0 2\nvn 0 1 1\nvn 1 0 0\nvn 0 -1 0\nf 1//1 2//2 3//3\nf 1//1 4//4 2//2\n", 60).meshes[0]);
}

TEST(MeshArrays, RefuseWhatCannotBeDrawnAndNameIt) {
    std::vector<float> positions = kPositions, normals = kNormals;
    std::vector<uint32_t> triangles = kTriangles;
    const auto refusal = [&](const std::function<void(MeshArrays&)>& change) {
        MeshArrays arrays = roof();
        change(arrays);
        Scene scene;
        return refusalOf([&] { addMesh(scene, arrays); });
    };
    const std::string place = "memory: mesh 'roof': ";
    EXPECT_EQ(refusal([&](MeshArrays& a) { a.positions = a.positions.first(11); }),
              place + "positions has 11 numbers, which is no multiple of 3: a vertex has three");
    EXPECT_EQ(refusal([&](MeshArrays& a) { a.triangles = a.triangles.first(4); }),
              place + "triangles has 4 numbers, which is no multiple of 3: a triangle has three");
    EXPECT_EQ(refusal([&](MeshArrays& a) { a.triangles = {}; }), place + "triangles is empty: the mesh has nothing to draw");
    EXPECT_EQ(refusal([&](MeshArrays& a) { a.positions = {}; }), place + "triangles[0] is 0; there are 0 vertices, and the first is 0");
    triangles[4] = 4;
    EXPECT_EQ(refusal([&](MeshArrays& a) { a.triangles = triangles; }),
              place + "triangles[4] is 4; there are 4 vertices, and the first is 0");
    normals.resize(9);
    EXPECT_EQ(refusal([&](MeshArrays& a) { a.normals = normals; }), place + "normals has 9 numbers; 4 vertices need 12");
    EXPECT_EQ(refusal([&](MeshArrays& a) { a.creaseDegrees = std::nan(""); }), place + "creaseDegrees is nan, outside 0 to 180");
    for (const auto& [value, word] : {std::pair(kNaN, "nan"), std::pair(kInfinity, "inf"), std::pair(-2e30f, "-2e+30")}) {
        positions = kPositions;
        positions[7] = value;
        EXPECT_EQ(refusal([&](MeshArrays& a) { a.positions = positions; }),
                  place + "positions[7], y of vertex 2, is " + word + "; numbers are finite, at most 2^100");
        normals = kNormals;
        normals[11] = value;
        EXPECT_EQ(refusal([&](MeshArrays& a) { a.normals = normals; }),
                  place + "normals[11], z of vertex 3, is " + word + "; numbers are finite, at most 2^100");
    }
    // Counts are judged before anything is read.
    EXPECT_EQ(refusal([&](MeshArrays& a) { a.triangles = std::span(kTriangles.data(), (size_t(3) << 30) + 3); }),
              place + "triangles has 1073741825 of a triangle; at most 1073741824 are drawn");
    Scene scene;
    EXPECT_EQ(refusalOf([&] { addMesh(scene, roof(), 2); }), place + "material is 2; the scene has 0, and the first is 0");
    EXPECT_TRUE(scene.meshes.empty());
}

TEST(MeshArrays, TellOfFacesWithoutArea) {
    Scene scene;
    const std::vector<uint32_t> triangles = {0, 1, 2, 1, 1, 2};
    addMesh(scene, {.positions = kPositions, .triangles = triangles, .name = "roof"});
    EXPECT_EQ(scene.warnings, std::vector<std::string>{"memory: mesh 'roof': 1 face has no area"});
}

TEST(MeshArrays, AnObjectInAnotherMaterialShowsACopyThatIsShared) {
    Scene scene;
    const uint32_t red = addMaterial(scene, {.name = "red"}), green = addMaterial(scene, {.name = "green"});
    const uint32_t mesh = addMesh(scene, roof(), red);
    EXPECT_EQ(addObject(scene, mesh), 0u);
    addObject(scene, mesh, glm::dmat4(1), red);
    EXPECT_EQ(scene.meshes.size(), 1u);
    addObject(scene, mesh, glm::dmat4(2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 5, 6, 7, 1), green);
    addObject(scene, mesh, glm::dmat4(1), green);
    ASSERT_EQ(scene.meshes.size(), 2u);
    EXPECT_EQ(scene.objects[1].mesh, mesh);
    EXPECT_EQ(scene.objects[2].mesh, 1u);
    EXPECT_EQ(scene.objects[3].mesh, 1u);
    EXPECT_EQ(scene.objects[2].worldFromObject[3], glm::dvec4(5, 6, 7, 1));
    EXPECT_EQ(scene.meshes[0].faceMaterial, std::vector<uint32_t>(2, red));
    EXPECT_EQ(scene.meshes[1].faceMaterial, std::vector<uint32_t>(2, green));
    EXPECT_EQ(scene.meshes[1].vertexMaterial, std::vector<uint32_t>(scene.meshes[1].positions.size(), green));
    expectSame(scene.meshes[0], scene.meshes[1]);
}

TEST(MeshArrays, RefuseMatricesAndMaterialsThatMeanNothing) {
    Scene scene;
    addMesh(scene, roof());
    EXPECT_EQ(refusalOf([&] { addObject(scene, 1); }), "memory: object: mesh is 1; the scene has 1, and the first is 0");
    glm::dmat4 m(1);
    m[1][2] = std::nan("");
    EXPECT_EQ(refusalOf([&] { addObject(scene, 0, m); }),
              "memory: object 'roof': worldFromObject has an entry that is no number up to 2^100");
    m = glm::dmat4(1);
    m[0][3] = 5;  // a translation in the wrong place
    EXPECT_EQ(refusalOf([&] { addObject(scene, 0, m); }),
              "memory: object 'roof': the last row of worldFromObject is not 0 0 0 1; matrices are stored column by column");
    EXPECT_EQ(refusalOf([&] { addObject(scene, 0, glm::dmat4(1), 7); }),
              "memory: object 'roof': material is 7; the scene has 1, and the first is 0");
    EXPECT_TRUE(scene.objects.empty());
    EXPECT_EQ(refusalOf([&] {
                  addMaterial(scene, {.name = "a", .diffuse = {0, kNaN, 0}});
              }),
              "memory: material 'a': diffuse is nan, outside 0 to 1");
    EXPECT_EQ(refusalOf([&] { addMaterial(scene, {.name = "a", .shininess = -1}); }),
              "memory: material 'a': shininess is -1, outside 0 to 1000000");
    EXPECT_EQ(refusalOf([&] { addMaterial(scene, {.name = "a", .refractiveIndex = 0}); }),
              "memory: material 'a': refractiveIndex is 0; that of the outside is 1");
    EXPECT_EQ(scene.materials.size(), 1u);
    addObject(scene, 0, glm::dmat4(0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1));
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.warnings[0], "memory: object 'roof': it is flattened to a line or a point: no surface is left of it");
}

TEST(LookAt, IsTheCameraOfASceneFile) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.path() / "a.toml";
    std::ofstream(path) << "[camera]\neye = [3, 2, 5]\nat = [0.5, 0, -1]\nup = [0, 1, 0]\nfov = 30\n"
                           "[[mesh]]\nname = \"m\"\nvertices = [[0,0,0],[1,0,0],[0,1,0]]\nfaces = [[0,1,2]]\n[[object]]\nmesh = \"m\"\n";
    const Camera file = *loadScene({path}, {}).camera, made = lookAt({3, 2, 5}, {0.5, 0, -1}, {0, 1, 0}, 30);
    EXPECT_EQ(made.eye, file.eye);
    EXPECT_EQ(made.fovYDegrees, file.fovYDegrees);
    // Both normalise by other operations: each coordinate is within 4 units in the last place of 1.
    constexpr double kBound = 4 * std::numeric_limits<double>::epsilon();
    for (int i = 0; i < 3; ++i) {
        EXPECT_LE(std::abs(made.right[i] - file.right[i]), kBound);
        EXPECT_LE(std::abs(made.up[i] - file.up[i]), kBound);
        EXPECT_LE(std::abs(made.forward[i] - file.forward[i]), kBound);
    }
    EXPECT_LE(std::abs(made.focusDistance / file.focusDistance - 1), kBound);
}

TEST(LookAt, RefusesWhatHasNoDirection) {
    EXPECT_EQ(refusalOf([] { lookAt({1, 2, 3}, {1, 2, 3}); }), "camera: eye and at are the same point");
    EXPECT_EQ(refusalOf([] { lookAt({1, std::nan(""), 3}, {0, 0, 0}); }), "camera: eye.y is nan; numbers are finite, at most 2^100");
    EXPECT_EQ(refusalOf([] { lookAt({1, 2, 3}, {0, 0, 0}, {0, 0, 0}); }), "camera: up is 0 0 0: it has no direction");
    EXPECT_EQ(refusalOf([] { lookAt({1, 2, 3}, {0, 0, 0}, {0, 1, 0}, 180); }), "camera: fovYDegrees is 180, outside 0.001 to 179");
    const Camera above = lookAt({0, 5, 0}, {0, 0, 0});
    EXPECT_EQ(above.up, glm::dvec3(0, 0, -1));
}

TEST(CheckScene, NamesWhatAReaderWouldHaveRefused) {
    Scene whole;
    addObject(whole, addMesh(whole, roof()));
    whole.camera = lookAt({0, 0, 5}, {0, 0, 0});
    whole.lights.push_back({});
    EXPECT_EQ(refusalOf([&] { checkScene(whole); }), "accepted");
    const auto refusal = [&](const std::function<void(Scene&)>& change) {
        Scene scene = whole;
        change(scene);
        return refusalOf([&] { checkScene(scene); });
    };
    EXPECT_EQ(refusal([](Scene& s) { s.camera.reset(); }),
              "memory: camera: the scene has none: set Scene::camera, by lookAt() or completeScene()");
    EXPECT_EQ(refusal([](Scene& s) { s.camera->up.x = std::nan(""); }),
              "memory: camera: up has a coordinate that is no number up to 2^100");
    EXPECT_EQ(refusal([](Scene& s) { s.camera->fovYDegrees = std::nan(""); }), "memory: camera: fovYDegrees is nan, outside 0 to 180");
    EXPECT_EQ(refusal([](Scene& s) { s.camera->focalPixels = std::nan(""); }), "memory: camera: focalPixels is nan");
    EXPECT_EQ(refusal([](Scene& s) { s.camera->near = std::nan(""); }), "memory: camera: near is nan");
    EXPECT_EQ(refusal([](Scene& s) { s.camera->focusDistance = 0; }), "memory: camera: focusDistance is 0");
    EXPECT_EQ(refusal([](Scene& s) { s.objects[0].mesh = 1; }), "memory: object 'roof': mesh is 1; the scene has 1, and the first is 0");
    EXPECT_EQ(refusal([](Scene& s) { s.objects[0].worldFromObject[2][1] = std::nan(""); }),
              "memory: object 'roof': worldFromObject has an entry that is no number up to 2^100");
    EXPECT_EQ(refusal([](Scene& s) { s.lights[0].direction = glm::dvec3(0); }),
              "memory: light: direction is 0 0 0; it points toward the light");
    EXPECT_EQ(refusal([](Scene& s) { s.lights[0].direction.z = std::nan(""); }),
              "memory: light: direction has a coordinate that is no number up to 2^100");
    EXPECT_EQ(refusal([](Scene& s) { s.lights[0] = {.directional = false, .position = glm::dvec3(std::nan(""))}; }),
              "memory: light: position has a coordinate that is no number up to 2^100");
    EXPECT_EQ(refusal([](Scene& s) { s.lights[0].intensity.y = kNaN; }),
              "memory: light: intensity is nan in channel G; it is 0 or more, at most 2^100");
    EXPECT_EQ(refusal([](Scene& s) { s.spheres.push_back({.material = 3}); }),
              "memory: sphere: material is 3; the scene has 1, and the first is 0");
    EXPECT_EQ(refusal([](Scene& s) { s.planes.push_back({.material = 3}); }),
              "memory: plane: material is 3; the scene has 1, and the first is 0");
}

}  // namespace
}  // namespace plumb
