// SPDX-License-Identifier: MIT
#include "pipeline/scene/add_mesh.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/plain_floats.h"
#include "pipeline/scene/extension.h"
#include "pipeline/scene/text.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fmt/core.h>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using MeshReader = PolygonMesh (*)(const std::filesystem::path&, const LoadOptions&);
struct MeshFormat {
    std::string_view extension;
    MeshReader read;
};
constexpr std::array<MeshFormat, 4> kMeshFormats{{{".obj", readObj}, {".ply", readPly}, {".stl", readStl}, {".off", readOff}}};

const MeshFormat* meshFormatOf(const std::filesystem::path& path) {
    const auto found = std::find_if(kMeshFormats.begin(), kMeshFormats.end(),
                                    [extension = lowerExtension(path)](const MeshFormat& f) { return f.extension == extension; });
    return found == kMeshFormats.end() ? nullptr : &*found;
}

bool isGltf(const std::filesystem::path& path) {
    const std::string extension = lowerExtension(path);
    return extension == ".gltf" || extension == ".glb";
}

Error unknownFormat(const std::filesystem::path& path, std::string_view known) {
    return inputError(printablePath(path), fmt::format("unknown extension '{}'; read are {}", printable(path.extension().string(), 40), known));
}

void addUnlessThere(std::vector<std::string>& list, const std::vector<std::string>& more) {
    for (const std::string& entry : more)
        if (std::find(list.begin(), list.end(), entry) == list.end()) list.push_back(entry);
}

uint32_t defaultMaterial(Scene& scene) {
    const auto found = std::find_if(scene.materials.begin(), scene.materials.end(), [](const Material& m) { return m.name == "default"; });
    if (found != scene.materials.end()) return uint32_t(found - scene.materials.begin());
    scene.materials.emplace_back();
    return uint32_t(scene.materials.size() - 1);
}

}  // namespace

uint32_t addMeshFile(Scene& scene, const std::filesystem::path& path, const LoadOptions& options) {
    const MeshFormat* format = meshFormatOf(path);
    if (!format) throw unknownFormat(path, ".obj, .ply, .stl, .off");
    PolygonMesh polygons = format->read(path, options);
    polygons.place = printablePath(path);
    if (options.strict && !polygons.ignored.empty())
        throw inputError(printablePath(path), polygons.ignored.front() + " would be ignored (--strict)");
    const bool bare = std::find(polygons.faceMaterial.begin(), polygons.faceMaterial.end(), kNone) != polygons.faceMaterial.end();
    TriangleMesh mesh = finishMesh(polygons, scene.materials, bare ? defaultMaterial(scene) : kNone, options);
    addUnlessThere(scene.ignored, polygons.ignored);
    addUnlessThere(scene.warnings, polygons.warnings);
    return addFinished(scene, std::move(mesh), printablePath(path));
}

bool isBareMesh(const std::filesystem::path& path) { return meshFormatOf(path) || isGltf(path); }

Scene loadScene(const std::vector<std::filesystem::path>& paths, const LoadOptions& options) {
    const PlainFloats plain;
    if (paths.empty()) throw usageError("no scene file is given");
    for (const std::filesystem::path& path : paths) {
        if (meshFormatOf(path)) continue;
        if (!isGltf(path) && lowerExtension(path) != ".toml") throw unknownFormat(path, ".obj, .ply, .stl, .off, .gltf, .glb, .toml");
        if (paths.size() > 1) throw usageError(fmt::format("'{}' is a whole scene; only mesh files can be given together", printablePath(path)));
        return isGltf(path) ? readGltf(path, options) : readSceneToml(path, options);
    }
    Scene scene;
    scene.path = paths.front().string();
    for (const std::filesystem::path& path : paths) {
        Object object;
        object.mesh = addMeshFile(scene, path, options);
        object.name = scene.meshes[object.mesh].name;
        scene.objects.push_back(object);
        if (options.onProgress) options.onProgress(double(scene.objects.size()) / double(paths.size()));
    }
    return scene;
}

}  // namespace plumb
