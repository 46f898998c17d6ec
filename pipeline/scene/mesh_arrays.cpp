// SPDX-License-Identifier: MIT
#include "pipeline/scene/mesh_arrays.h"

#include "host/error.h"
#include "pipeline/scene/add_mesh.h"
#include "pipeline/scene/affine.h"
#include "pipeline/scene/flattened.h"
#include "pipeline/scene/plain_floats.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

namespace {

// Largest counts that a mesh may have: the passes index vertices and triangles with 31 bits, finishMesh() corners with 32.
constexpr size_t kMostVertices = 0x7fffffff, kMostTriangles = size_t(1) << 30;
constexpr float kMaxShininess = 1e6f, kMaxRefractiveIndex = 1e6f;

std::string fileOf(const Scene& scene) { return scene.path.empty() ? "memory" : scene.path; }

class ArrayReader {
public:
    ArrayReader(const MeshArrays& arrays, std::string location) : arrays_(arrays), place_(std::move(location)) {}

    PolygonMesh read() const {
        const size_t vertices = threes("positions", arrays_.positions.size(), "vertex", kMostVertices);
        const size_t triangles = threes("triangles", arrays_.triangles.size(), "triangle", kMostTriangles);
        if (triangles == 0) refuse("triangles is empty: the mesh has nothing to draw");
        const bool hasNormals = !arrays_.normals.empty();
        if (hasNormals && arrays_.normals.size() != arrays_.positions.size())
            refuse(fmt::format("normals has {} numbers; {} vertices need {}", arrays_.normals.size(), vertices, arrays_.positions.size()));
        if (!(arrays_.creaseDegrees >= 0 && arrays_.creaseDegrees <= 180))
            refuse(fmt::format("creaseDegrees is {:g}, outside 0 to 180", arrays_.creaseDegrees));
        PolygonMesh mesh;
        mesh.name = arrays_.name;
        mesh.location = place_;
        mesh.positions.reserve(vertices);
        for (size_t v = 0; v < vertices; ++v) mesh.positions.push_back(glm::dvec3(vertex("positions", arrays_.positions, v)));
        for (size_t v = 0; hasNormals && v < vertices; ++v) mesh.normals.push_back(vertex("normals", arrays_.normals, v));
        mesh.corners.reserve(3 * triangles);
        for (size_t i = 0; i < 3 * triangles; ++i) {
            const uint32_t index = arrays_.triangles[i];
            if (index >= vertices)
                refuse(fmt::format("triangles[{}] is {}; there are {} vertices, and the first is 0", i, index, vertices));
            mesh.corners.push_back({index, hasNormals ? index : kNone});
        }
        for (size_t t = 0; t <= triangles; ++t) mesh.faceFirst.push_back(uint32_t(3 * t));
        return mesh;
    }

private:
    [[noreturn]] void refuse(const std::string& why) const { throw inputError(place_, why); }

    size_t threes(const char* array, size_t size, const char* of, size_t most) const {
        if (size % 3 != 0) refuse(fmt::format("{} has {} numbers, which is no multiple of 3: a {} has three", array, size, of));
        if (size / 3 > most) refuse(fmt::format("{} has {} of a {}; at most {} are drawn", array, size / 3, of, most));
        return size / 3;
    }

    glm::vec3 vertex(const char* array, std::span<const float> from, size_t v) const {
        for (size_t i = 3 * v; i < 3 * v + 3; ++i)
            if (!(std::abs(from[i]) <= kMaxCoordinate))
                refuse(
                    fmt::format("{}[{}], {} of vertex {}, is {}; numbers are finite, at most 2^100", array, i, "xyz"[i % 3], v, from[i]));
        return {from[3 * v], from[3 * v + 1], from[3 * v + 2]};
    }

    const MeshArrays& arrays_;
    const std::string place_;
};

void checkMaterial(const Scene& scene, const std::string& location, uint32_t material) {
    if (material < scene.materials.size()) return;
    throw inputError(location, fmt::format("material is {}; the scene has {}, and the first is 0", material, scene.materials.size()));
}

bool shows(const TriangleMesh& mesh, uint32_t material) {
    return std::all_of(mesh.faceMaterial.begin(), mesh.faceMaterial.end(), [&](uint32_t m) { return m == material; });
}

// A mesh like `mesh` with one material: itself, a copy that is there already, or a new copy.
uint32_t meshShowing(Scene& scene, uint32_t mesh, uint32_t material) {
    const auto isSame = [&](const TriangleMesh& other) {
        const TriangleMesh& own = scene.meshes[mesh];
        return shows(other, material) && other.name == own.name && other.origin == own.origin && other.positions == own.positions &&
               other.normals == own.normals &&
               std::equal(other.triangles.begin(), other.triangles.end(), own.triangles.begin(), own.triangles.end(),
                          [](const TriangleMesh::Triangle& a, const TriangleMesh::Triangle& b) {
                              return a.face == b.face && std::equal(a.vertex, a.vertex + 3, b.vertex);
                          });
    };
    if (shows(scene.meshes[mesh], material)) return mesh;
    const auto found = std::find_if(scene.meshes.begin(), scene.meshes.end(), isSame);
    if (found != scene.meshes.end()) return uint32_t(found - scene.meshes.begin());
    TriangleMesh copy = scene.meshes[mesh];
    std::fill(copy.vertexMaterial.begin(), copy.vertexMaterial.end(), material);
    std::fill(copy.faceMaterial.begin(), copy.faceMaterial.end(), material);
    scene.meshes.push_back(std::move(copy));
    return uint32_t(scene.meshes.size() - 1);
}

}  // namespace

uint32_t addMaterial(Scene& scene, const Material& material) {
    const std::string location = locationOfPart("", fileOf(scene), "material", material.name);
    const auto share = [&](const char* field, float value, float most = 1) {
        if (!(value >= 0 && value <= most)) throw inputError(location, fmt::format("{} is {}, outside 0 to {}", field, value, most));
    };
    for (int c = 0; c < 3; ++c) {
        share("ambient", material.ambient[c]);
        share("diffuse", material.diffuse[c]);
        share("specular", material.specular[c]);
        share("emission", material.emission[c]);
    }
    share("shininess", material.shininess, kMaxShininess);
    share("opacity", material.opacity);
    share("refractiveIndex", material.refractiveIndex, kMaxRefractiveIndex);
    if (!(material.refractiveIndex > 0)) throw inputError(location, "refractiveIndex is 0; that of the outside is 1");
    share("reflect", material.reflect);
    share("transmit", material.transmit);
    if (!(material.local < 0)) share("local", material.local);
    scene.materials.push_back(material);
    return uint32_t(scene.materials.size() - 1);
}

uint32_t addMesh(Scene& scene, const MeshArrays& arrays, uint32_t material) {
    const PlainFloats plain;
    const std::string location = locationOfPart("", fileOf(scene), "mesh", arrays.name);
    PolygonMesh mesh = ArrayReader(arrays, location).read();
    if (material == kNone && scene.materials.empty()) scene.materials.emplace_back();
    if (material == kNone) material = 0;
    checkMaterial(scene, location, material);
    mesh.faceMaterial.assign(mesh.faceFirst.size() - 1, material);
    LoadOptions options;
    options.creaseDegrees = arrays.creaseDegrees;
    const uint32_t index = addMesh(scene, std::move(mesh), location, options);
    warnOfRepairs(scene, index, location);
    return index;
}

uint32_t addObject(Scene& scene, uint32_t mesh, const glm::dmat4& worldFromObject, uint32_t material) {
    const PlainFloats plain;
    if (mesh >= scene.meshes.size())
        throw inputError(locationOfPart("", fileOf(scene), "object", ""),
                         fmt::format("mesh is {}; the scene has {}, and the first is 0", mesh, scene.meshes.size()));
    const std::string location = locationOfPart("", fileOf(scene), "object", scene.meshes[mesh].name);
    if (!entriesUsable(worldFromObject)) throw inputError(location, "worldFromObject has an entry that is no number up to 2^100");
    for (int column = 0; column < 4; ++column)
        if (worldFromObject[column][3] != (column == 3 ? 1 : 0))
            throw inputError(location, "the last row of worldFromObject is not 0 0 0 1; matrices are stored column by column");
    if (material != kNone) checkMaterial(scene, location, material);
    Object object;
    object.name = scene.meshes[mesh].name;
    object.mesh = material == kNone ? mesh : meshShowing(scene, mesh, material);
    object.worldFromObject = worldFromObject;
    if (!hasInverse(worldFromObject) && leavesNoArea(scene.meshes[object.mesh], worldFromObject))
        scene.warnings.push_back(fmt::format("{}: it is flattened to a line or a point: no surface is left of it", location));
    scene.objects.push_back(std::move(object));
    return uint32_t(scene.objects.size() - 1);
}

}  // namespace plumb
