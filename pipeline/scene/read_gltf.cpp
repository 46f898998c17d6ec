// SPDX-License-Identifier: MIT
// Reads glTF 2.0 (.gltf, .glb): whole scenes, right-handed, +Y up. The specification is cited as "glTF n.n".
// Nothing is allocated on a number of the file: accessors are checked against the bytes that are there, and the corners of all meshes
// together against the bytes that were read (Accessors::countCorners).
// What a file asks for and is not drawn goes into Scene::ignored, once a kind; with `strict` it is refused. The rest follows tolerance.h.
#include "pipeline/scene/add_mesh.h"
#include "pipeline/scene/gltf_container.h"
#include "pipeline/scene/gltf_materials.h"
#include "pipeline/scene/gltf_nodes.h"
#include "pipeline/scene/gltf_reading.h"
#include "pipeline/scene/gltf_value.h"
#include "pipeline/scene/gltf_views.h"
#include "pipeline/scene/sha256.h"
#include "pipeline/scene/text.h"
#include "pipeline/scene/tolerance.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <span>
#include <string>
#include <string_view>

namespace plumb {

// glTF 1.0 has objects where 2.0 has arrays, and files of it may state no version.
static void refuseOtherVersions(const gltf::Value& file) {
    const auto meshes = file.find("meshes");
    const auto asset = file.find("asset");
    if ((!asset || !asset->find("version")) && meshes && meshes->isObject()) file.refuse("glTF 1.0; only 2.0 is read");
    const gltf::Value version = file.required("asset").required("version");
    if (version.text() != "2" && !version.text().starts_with("2."))
        version.refuse(fmt::format("glTF {}; only 2.0 is read", printable(version.text(), 20)));
}

// True for an extension that changes materials or textures and leaves every vertex where it is.
static bool concernsSurfaces(std::string_view extension) {
    for (const std::string_view part : {"_materials_", "_texture_"})
        if (extension.find(part) != extension.npos) return true;
    return extension == "KHR_techniques_webgl" || extension == "KHR_xmp" || extension == "KHR_xmp_json_ld";
}

static void readRequiredExtensions(const gltf::Value& file, const gltf::Reading& reading) {
    static constexpr std::string_view kRead[] = {"KHR_lights_punctual",
                                                 "KHR_materials_unlit",
                                                 "KHR_materials_ior",
                                                 "KHR_materials_emissive_strength",
                                                 "KHR_mesh_quantization",
                                                 "KHR_texture_transform",
                                                 "KHR_materials_pbrSpecularGlossiness",
                                                 "EXT_mesh_gpu_instancing"};
    for (const gltf::Value& value : file.list("extensionsRequired")) {
        const std::string& name = value.text();
        if (std::find(std::begin(kRead), std::end(kRead), name) != std::end(kRead)) continue;
        if (!concernsSurfaces(name))
            value.refuse(fmt::format("the file requires the extension '{}', which is not read", printable(name, 64)));
        if (name.find("_texture_") != name.npos) reading.ignore(value, "textures");
        reading.ignore(value, "extension " + printable(name, 64));
    }
}

Scene readGltf(const std::filesystem::path& path, const LoadOptions& options) {
    const gltf::Container container(path, options);
    Scene scene;
    scene.path = path.string();
    scene.sha256 = sha256Hex(std::as_bytes(std::span(container.bytes())));
    Tolerance tolerance(options);
    const gltf::Reading reading{options, scene, tolerance};
    const gltf::Value file = container.root();
    refuseOtherVersions(file);
    readRequiredExtensions(file, reading);
    reading.ignoreExtensions(file, {"KHR_lights_punctual"});
    if (const auto animations = file.find("animations"))
        if (animations->size() > 0) reading.ignore(*animations, "animations");
    gltf::Materials materials(file, reading);
    gltf::readNodes(container, materials, reading);
    if (scene.objects.empty()) {
        std::string ignored;
        for (const std::string& what : scene.ignored) ignored += (ignored.empty() ? " (not drawn: " : ", ") + what;
        tolerance.addTo(scene.warnings);
        file.refuse("nothing to draw: no node of the scene has a mesh of triangles" + ignored + (ignored.empty() ? "" : ")") +
                    (scene.warnings.empty() ? "" : "; " + scene.warnings.front()));
    }
    if (!options.camera.empty() && !scene.camera)
        throw usageError(fmt::format("'{}' has no perspective camera '{}'; it has {}", printablePath(path), printable(options.camera, 64),
                                     reading.cameras));
    materials.passUnread();
    tolerance.addTo(scene.warnings);
    warnOfRepairs(scene, 0, printablePath(path));
    if (scene.camera) gltf::focusCamera(scene);
    return scene;
}

}  // namespace plumb
