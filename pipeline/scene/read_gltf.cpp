// SPDX-License-Identifier: MIT
// Reads glTF 2.0 (.gltf, .glb): whole scenes, right-handed, +Y up. The specification is cited as "glTF n.n".
// Nothing is allocated on a number of the file: accessors are checked against the bytes that are there, and the corners of all meshes
// together against the bytes that were read (Accessors::countCorners).
// What a file asks for and is not drawn goes into Scene::ignored, once a kind; with `strict` it is refused.
#include "pipeline/scene/add_mesh.h"
#include "pipeline/scene/gltf_container.h"
#include "pipeline/scene/gltf_materials.h"
#include "pipeline/scene/gltf_nodes.h"
#include "pipeline/scene/gltf_reading.h"
#include "pipeline/scene/gltf_value.h"
#include "pipeline/scene/gltf_views.h"
#include "pipeline/scene/sha256.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <span>
#include <string>
#include <string_view>

namespace plumb {

static void refuseUnknownVersion(const gltf::Value& file) {
    const gltf::Value version = file.required("asset").required("version");
    if (!version.text().starts_with("2.")) version.refuse(fmt::format("glTF {}; only 2.0 is read", printable(version.text(), 20)));
}

static void refuseRequiredExtensions(const gltf::Value& file) {
    static constexpr std::string_view kRead[] = {"KHR_lights_punctual",   "KHR_materials_unlit",
                                                 "KHR_materials_ior",     "KHR_materials_emissive_strength",
                                                 "KHR_mesh_quantization", "KHR_texture_transform"};
    for (const gltf::Value& name : file.list("extensionsRequired"))
        if (std::find(std::begin(kRead), std::end(kRead), name.text()) == std::end(kRead))
            name.refuse(fmt::format("the file requires the extension '{}', which is not read", printable(name.text(), 64)));
}

Scene readGltf(const std::filesystem::path& path, const LoadOptions& options) {
    const gltf::Container container(path, options);
    Scene scene;
    scene.path = path.string();
    scene.sha256 = sha256Hex(std::as_bytes(std::span(container.bytes())));
    const gltf::Reading reading{options, scene};
    const gltf::Value file = container.root();
    refuseUnknownVersion(file);
    refuseRequiredExtensions(file);
    reading.ignoreExtensions(file, {"KHR_lights_punctual"});
    if (const auto animations = file.find("animations"))
        if (animations->size() > 0) reading.ignore(*animations, "animations");
    gltf::readMaterials(file, reading);
    gltf::readNodes(container, reading);
    if (scene.objects.empty()) {
        std::string ignored;
        for (const std::string& what : scene.ignored) ignored += (ignored.empty() ? " (not drawn: " : ", ") + what;
        file.refuse("nothing to draw: no node of the scene has a mesh of triangles" + ignored + (ignored.empty() ? "" : ")"));
    }
    warnOfRepairs(scene, 0, printablePath(path));
    if (scene.camera) gltf::focusCamera(scene);
    return scene;
}

}  // namespace plumb
