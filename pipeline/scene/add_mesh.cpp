// SPDX-License-Identifier: MIT
#include "pipeline/scene/add_mesh.h"

#include "host/error.h"

#include <unordered_map>

namespace plumb {

// finishMesh appends the materials of a mesh to those it is given. The scene has these already, so it is given a list
// of its own, `used`, and the scene's numbers are put back afterwards.
uint32_t addMesh(Scene& scene, PolygonMesh mesh, const LoadOptions& options) {
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
    std::vector<Material> numbered;
    TriangleMesh finished = finishMesh(mesh, numbered, 0, options);
    PLUMB_ASSERT(numbered.size() == used.size());
    for (uint32_t& material : finished.vertexMaterial) material = used.at(material);
    for (uint32_t& material : finished.faceMaterial) material = used.at(material);
    scene.meshes.push_back(std::move(finished));
    return uint32_t(scene.meshes.size() - 1);
}

}  // namespace plumb
