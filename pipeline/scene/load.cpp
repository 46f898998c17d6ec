// SPDX-License-Identifier: MIT
#include "pipeline/scene/load.h"
#include "pipeline/scene/add_mesh.h"
#include "pipeline/scene/extension.h"
#include "pipeline/scene/input.h"
#include "pipeline/scene/plain_floats.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// Reader of the meshes of `format`; null for a format that is not a mesh alone.
PolygonMesh (*readerOf(FileFormat format))(const std::filesystem::path&, const LoadOptions&) {
    switch (format) {
        case FileFormat::obj:
            return readObj;
        case FileFormat::ply:
            return readPly;
        case FileFormat::stl:
            return readStl;
        case FileFormat::off:
            return readOff;
        case FileFormat::unknown:
        case FileFormat::gltf:
        case FileFormat::toml:
            break;
    }
    return nullptr;
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

static uint32_t addMeshOf(FileFormat format, Scene& scene, const std::filesystem::path& path, const LoadOptions& options) {
    const auto read = readerOf(format);
    PLUMB_ASSERT(read != nullptr);
    PolygonMesh polygons = read(path, options);
    polygons.location = printablePath(path);
    if (options.strict && !polygons.ignored.empty())
        throw inputError(printablePath(path), polygons.ignored.front() + " would be ignored (--strict)");
    const bool bare = std::find(polygons.faceMaterial.begin(), polygons.faceMaterial.end(), kNone) != polygons.faceMaterial.end();
    addUnlessThere(scene.ignored, polygons.ignored);
    addUnlessThere(scene.warnings, polygons.warnings);
    const uint32_t fallback = bare ? defaultMaterial(scene) : kNone;
    TriangleMesh mesh = finishMesh(std::move(polygons), scene.materials, fallback, options);
    return addFinished(scene, std::move(mesh), printablePath(path));
}

uint32_t addMeshFile(Scene& scene, const std::filesystem::path& path, const LoadOptions& options) {
    const FileFormat format = formatOfReference(path, options);
    if (readerOf(format) == nullptr) {
        std::error_code failed;
        if (!std::filesystem::exists(path, failed)) readWholeFile(path);  // refuses, and says why
        throw inputError(printablePath(path),
                         fmt::format("unknown extension '{}'; read are .obj, .ply, .stl, .off", printable(path.extension().string(), 40)));
    }
    return addMeshOf(format, scene, path, options);
}

bool isBareMesh(const std::filesystem::path& path, const LoadOptions& options) {
    FileFormat format = options.format.empty() ? formatOfExtension(path) : FileFormat::unknown;
    if (format == FileFormat::unknown) format = formatOfInput(path, options);
    return readerOf(format) != nullptr || format == FileFormat::gltf;
}

Scene loadScene(const std::vector<std::filesystem::path>& paths, const LoadOptions& options) {
    const PlainFloats plain;
    if (paths.empty()) throw usageError("no scene file is given");
    std::vector<FileFormat> formats;
    for (const std::filesystem::path& path : paths) {
        if (isReadOnce(path)) {
            if (options.once->contains(path.native())) throw usageError(fmt::format("'{}' can be read only once", printablePath(path)));
            rememberOnce(path, options);
        }
        formats.push_back(formatOfInput(path, options));
        if (readerOf(formats.back()) != nullptr) continue;
        if (!options.camera.empty() && formats.back() != FileFormat::gltf) break;
        if (paths.size() > 1)
            throw usageError(fmt::format("'{}' is a whole scene; only mesh files can be given together", printablePath(path)));
        return formats.back() == FileFormat::gltf ? readGltf(path, options) : readSceneToml(path, options);
    }
    if (!options.camera.empty()) throw usageError("--camera names a camera of a glTF, and this is none");
    Scene scene;
    scene.path = paths.front().string();
    LoadOptions own = options;
    for (size_t i = 0; i < paths.size(); ++i) {
        const double share = (options.to - options.from) / double(paths.size());
        own.from = options.from + share * double(i);
        own.to = own.from + share;
        Object object;
        object.mesh = addMeshOf(formats[i], scene, paths[i], own);
        object.name = scene.meshes[object.mesh].name;
        scene.objects.push_back(object);
        if (options.onProgress) options.onProgress(own.to, "finish");
    }
    return scene;
}

}  // namespace plumb
