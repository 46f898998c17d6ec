// SPDX-License-Identifier: MIT
// From files to a Scene. Every refusal is Error(input) with place ("file:line:column", "file: byte N", "file: /pointer").
#pragma once

#include "pipeline/scene/scene.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb {

struct LoadOptions {
    bool allowOutside = false;        // references may leave the folder of the file that names them
    bool strict = false;              // ignored features and missing material libraries are refused
    bool keepMaterials = true;        // false: the caller replaces them, so material libraries are not looked for
    double creaseDegrees = 60;        // missing normals: faces meeting at less are smooth
    double progressMinimumMs = 0;
    std::function<void(double)> onProgress; // 0..1
};

// One reader a format (files of the same name). The bytes are bounded: regular files only, size checked first.
PolygonMesh readObj(const std::filesystem::path&, const LoadOptions&);   // + MTL
PolygonMesh readPly(const std::filesystem::path&, const LoadOptions&);   // ascii, binary little and big endian
PolygonMesh readStl(const std::filesystem::path&, const LoadOptions&);   // ascii, binary
PolygonMesh readOff(const std::filesystem::path&, const LoadOptions&);
Scene readGltf(const std::filesystem::path&, const LoadOptions&);        // .gltf and .glb: whole scenes
Scene readSceneToml(const std::filesystem::path&, const LoadOptions&);   // docs/scene-format.md

// Triangulates (ear clipping for concave faces, fan for convex), builds missing normals per polygon corner with the
// crease angle, makes (position, normal, material) vertices unique, lists edges once, flushes denormals, counts repairs.
// Materials are appended to `materials`; kNone becomes material `fallback`.
TriangleMesh finishMesh(const PolygonMesh&, std::vector<Material>& materials, uint32_t fallback, const LoadOptions&);

// A mesh file as an object of the scene (by extension). Used by scene files and by loadScene.
uint32_t addMeshFile(Scene&, const std::filesystem::path&, const LoadOptions&);  // returns index into scene.meshes

// By extension: a scene file, a glTF, or a bare mesh; several files make one scene of several objects.
Scene loadScene(const std::vector<std::filesystem::path>&, const LoadOptions&);

// Camera and lights for a scene that has none. `view`: "front", "iso", "az,el" in degrees, or empty (three-quarter
// view). The object covers 35 to 80 % of the shorter side and touches no border. aspect = width / height.
Camera frameCamera(const Scene&, double aspect, const std::string& view);
std::vector<Light> defaultLights(const Scene&, const Camera&);  // headlight key + fill, directional
// Fills what is missing: camera (framed for `size`), lights when the file states none and is a bare mesh, near.
void completeScene(Scene&, glm::uvec2 size, const std::string& view, bool bareMesh);
bool isBareMesh(const std::filesystem::path&);   // by extension; glTF too, which may state neither camera nor light

}  // namespace plumb
