// SPDX-License-Identifier: MIT
#include "pipeline/scene/sha256.h"
#include "pipeline/scene/toml_scene.h"

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace plumb {
namespace scene_file {
namespace {

// A TOML value takes about 90 bytes of memory and at least two of text; larger meshes belong in a mesh file.
constexpr uint64_t kMaxSceneFileBytes = uint64_t(16) << 20;

}  // namespace

Scene SceneFile::read() {
    const std::string text = readWholeFile(path_, kMaxSceneFileBytes);
    refuseDeepKeys(text);
    toml::table root;
    try {
        root = toml::parse(std::string_view(text));
    } catch (const toml::parse_error& error) {
        throw inputError(place(error.source()), "TOML: " + printable(error.description()));
    }
    allowKeys(root, "the scene",
              {"handedness", "up",       "ambient", "background", "encoding", "shading",        "fill",
               "wire",       "edges",    "viewer",  "size",       "cull",     "max_depth",      "min_weight",
               "sampling",   "jitter",   "seed",    "levels",     "shadows",  "sphere_heights", "z_buffer",
               "camera",     "material", "light",   "mesh",       "object",   "sphere",         "plane"});
    scene_.path = path_.string();
    scene_.sha256 = sha256Hex(std::as_bytes(std::span(text)));
    scene_.materials.push_back(Material{});
    materials_["default"] = 0;
    readSettings(root);
    if (const auto* node = root.get("camera")) readCamera(tableOf(*node, "camera"));
    eachTable(root, "material", "material", [&](const toml::table& table) { readMaterial(table); });
    eachTable(root, "light", "light", [&](const toml::table& table) { readLight(table); });
    eachTable(root, "mesh", "mesh", [&](const toml::table& table) { readMesh(table); });
    eachTable(root, "sphere", "sphere", [&](const toml::table& table) { readSphere(table); });
    eachTable(root, "plane", "plane", [&](const toml::table& table) { readPlane(table); });
    eachTable(root, "object", "object", [&](const toml::table& table) { readObject(table, -1, 1); });
    if (!root.contains("object")) {
        for (const std::string& name : meshNames_) {
            Node node;
            node.name = name;
            node.table = &root;
            node.mesh = meshes_.find(name)->second;
            nodes_.push_back(std::move(node));
        }
    }
    linkParents();
    placeObjects();
    if (scene_.objects.empty() && scene_.spheres.empty() && scene_.planes.empty())
        throw inputError(placeOfLine(path_, 1, 1),
                         "nothing to draw: no [[object]] has a mesh and there is no [[mesh]], [[sphere]] or [[plane]]");
    return std::move(scene_);
}

}  // namespace scene_file

Scene readSceneToml(const std::filesystem::path& path, const LoadOptions& options) {
    return scene_file::SceneFile(path, options).read();
}

}  // namespace plumb
