// SPDX-License-Identifier: MIT
#include "pipeline/scene/add_mesh.h"

#include "host/error.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace plumb {

// Least extent of a mesh. A smaller one would be lost, because the transform snaps tiny values to zero.
static constexpr double kLeastExtent = 0x1p-100;

static uint32_t append(Scene& scene, TriangleMesh mesh, const std::string& location) {
    const glm::dvec3 size = mesh.statedMax - mesh.statedMin;  // before float32 rounded small coordinates to 0
    const double extent = std::max({size.x, size.y, size.z});
    if (extent > 0 && extent < kLeastExtent)
        throw inputError(location, fmt::format("the mesh is {:g} across; the smallest that is drawn is {:g}", extent, kLeastExtent));
    if (mesh.location.empty()) mesh.location = location;
    scene.meshes.push_back(std::move(mesh));
    return uint32_t(scene.meshes.size() - 1);
}

void warnOfRepairs(Scene& scene, size_t first, const std::string& location) {
    const std::tuple<uint32_t TriangleMesh::*, const char*, const char*> repairs[] = {
        // Words for one, and for several.
        {&TriangleMesh::degenerateFaces, "face has no area", "faces have no area"},
        {&TriangleMesh::repairedNormals, "corner normal is zero or opposite to its face: the face's is used",
         "corner normals are zero or opposite to their face: the face's is used"},
        {&TriangleMesh::flushedDenormals, "denormal number is set to 0", "denormal numbers are set to 0"},
        {&TriangleMesh::uncutFaces, "concave face has too many corners to triangulate: it is not drawn",
         "concave faces have too many corners to triangulate: they are not drawn"},
        {&TriangleMesh::selfCrossingFaces, "face crosses itself: it is cut as a fan", "faces cross themselves: they are cut as fans"},
    };
    for (const auto& [member, one, several] : repairs) {
        uint64_t count = 0;
        for (size_t i = first; i < scene.meshes.size(); ++i) count += scene.meshes[i].*member;
        if (count > 0) scene.warnings.push_back(fmt::format("{}: {} {}", location, count, count == 1 ? one : several));
    }
}

uint32_t addFinished(Scene& scene, TriangleMesh mesh, const std::string& location) {
    const uint32_t index = append(scene, std::move(mesh), location);
    warnOfRepairs(scene, index, location);
    return index;
}

// Finishes a mesh whose materials the scene has already. finishMesh() appends the materials of a mesh to the list it is given. So it is
// given a list of its own, `used`, and the scene's numbers are put back afterwards.
uint32_t addMesh(Scene& scene, PolygonMesh mesh, const std::string& location, const LoadOptions& options) {
    PLUMB_ASSERT(mesh.materials.empty());
    std::vector<uint32_t> used;
    std::unordered_map<uint32_t, uint32_t> localOf;
    for (uint32_t& material : mesh.faceMaterial) {
        const uint32_t inScene = material == kNone ? 0 : material;
        PLUMB_ASSERT(inScene < scene.materials.size());
        const auto [found, isNew] = localOf.try_emplace(inScene, uint32_t(used.size()));
        if (isNew) {
            used.push_back(inScene);
            mesh.materials.push_back(scene.materials[inScene]);
        }
        material = found->second;
    }
    if (mesh.location.empty()) mesh.location = location;
    std::vector<Material> numbered;
    TriangleMesh finished = finishMesh(std::move(mesh), numbered, kNone, options);
    PLUMB_ASSERT(numbered.size() == used.size());
    for (uint32_t& material : finished.vertexMaterial) material = used.at(material);
    for (uint32_t& material : finished.faceMaterial) material = used.at(material);
    return append(scene, std::move(finished), location);
}

}  // namespace plumb
