// SPDX-License-Identifier: MIT
// From files to a Scene. Every refusal is Error(input) with location ("file:line:column", "file: byte N", "file: /pointer").
#pragma once

#include "pipeline/scene/scene.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace plumb {

struct LoadOptions {
    bool allowOutside = false;  // references may leave the folder of the file that names them
    bool strict = false;        // ignored features and missing material libraries are refused
    bool keepMaterials = true;  // false: the caller replaces them, so material libraries are not looked for
    double creaseDegrees = 60;  // missing normals: the edge of two faces that meet at a smaller angle is smooth
    std::string camera;         // number (from 0) or name of a glTF's camera; empty: the first
    bool keepNumbers = true;    // meshes keep the file's binary64 positions where float32 rounds them: for truthOf
    // format of all inputs, whatever their names: obj, ply, stl, off, gltf, glb or toml; empty: by extension, else by content
    std::string format;
    // called often, may throw; share 0..1 of all inputs, and the stage: read, parse, finish
    std::function<void(double, const char*)> onProgress;
    double from = 0, to = 1;  // part of all inputs that the current file takes in onProgress
    // Inputs that can be read only once (standard input, FIFOs), by their paths; kept for as long as their bytes are needed.
    std::shared_ptr<std::map<std::string, std::string>> once = std::make_shared<std::map<std::string, std::string>>();
};

// Readers, one a format (files of the same name). The bytes are bounded: regular files only, size checked first.
PolygonMesh readObj(const std::filesystem::path&, const LoadOptions&);  // + MTL
PolygonMesh readPly(const std::filesystem::path&, const LoadOptions&);  // ascii, binary little and big endian
PolygonMesh readStl(const std::filesystem::path&, const LoadOptions&);  // ascii, binary
PolygonMesh readOff(const std::filesystem::path&, const LoadOptions&);
Scene readGltf(const std::filesystem::path&, const LoadOptions&);       // .gltf and .glb: whole scenes
Scene readSceneToml(const std::filesystem::path&, const LoadOptions&);  // docs/scene-format.md

// Finishes a mesh: triangulates (ear clipping for concave faces, fan for convex), and builds missing normals per polygon corner with the
// crease angle. It makes (position, normal, material) vertices unique, lists edges once, flushes denormals and counts repairs. A mesh far
// from 0 first gets an origin of its own, in binary64; everything else follows from the remaining coordinates (mesh_origin.h). Materials
// are appended to `materials`; kNone becomes material `fallback`.
TriangleMesh finishMesh(PolygonMesh, std::vector<Material>& materials, uint32_t fallback, const LoadOptions&);

// Adds a mesh file that a scene names, by extension or else by content.
uint32_t addMeshFile(Scene&, const std::filesystem::path&, const LoadOptions&);  // returns index into scene.meshes

// Loads a scene file, a glTF, or bare meshes: several files make one scene of several objects. "-" is standard input.
Scene loadScene(const std::vector<std::filesystem::path>&, const LoadOptions&);

// Camera for a scene that has none. `view`: "front", "iso", "az,el" in degrees, or empty (three-quarter view). The object covers 35 to 80 %
// of the shorter side and touches no border. aspect = width / height.
Camera frameCamera(const Scene&, double aspect, const std::string& view);
std::vector<Light> defaultLights(const Scene&, const Camera&);  // headlight key + fill, directional
// Fills what is missing: camera (framed for `size`), lights when the file states none and is a bare mesh, near.
void completeScene(Scene&, glm::uvec2 size, const std::string& view, bool bareMesh);
// True for a mesh file or a glTF, which may state neither camera nor light. Takes the options of the load, which know the bytes that came
// through a pipe.
bool isBareMesh(const std::filesystem::path&, const LoadOptions& options = {});

}  // namespace plumb
