// SPDX-License-Identifier: MIT
// Meshes of a scene: from files, or listed.
#include "pipeline/scene/toml_scene.h"

#include "pipeline/scene/add_mesh.h"
#include "pipeline/scene/input.h"
#include "pipeline/scene/shape.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <memory>
#include <set>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>

namespace plumb::scene_file {

namespace {

constexpr uint64_t kMaxCopiedTriangles = uint64_t(1) << 26;  // 5 GiB: a file with more means to fill the memory

void paint(TriangleMesh& mesh, uint32_t material) {
    std::fill(mesh.vertexMaterial.begin(), mesh.vertexMaterial.end(), material);
    std::fill(mesh.faceMaterial.begin(), mesh.faceMaterial.end(), material);
}

}  // namespace

void SceneFile::readMesh(const toml::table& table) {
    allowKeys(table, "[[mesh]]",
              {"name", "file", "vertices", "faces", "material", "face_materials", "crease", "shape", "radius", "length", "segments"});
    const toml::node& nameNode = required(table, "name", "mesh");
    const std::string name = stringOf(nameNode, "mesh.name");
    if (meshes_.contains(name)) refuse(nameNode, fmt::format("mesh.name '{}' is taken", printable(name, 64)));
    LoadOptions options = options_;
    if (const auto* node = table.get("crease")) options.creaseDegrees = numberOf(*node, "mesh.crease", 0, 180);

    uint32_t index;
    if (const auto* fileNode = table.get("file")) {
        for (const char* key : {"vertices", "faces", "face_materials", "shape"})
            if (const auto* other = table.get(key)) refuse(*other, fmt::format("mesh.{} beside mesh.file", key));
        const std::string reference = stringOf(*fileNode, "mesh.file");
        const auto file =
            resolveReference(referenceBase(path_, options_), reference, options.allowOutside, location(*fileNode), "mesh.file");
        std::error_code code;
        if (!std::filesystem::exists(file, code)) refuse(*fileNode, fmt::format("mesh.file '{}' does not exist", printable(reference)));
        const auto* materialNode = table.get("material");
        const uint32_t material = materialNode ? materialNamed(*materialNode, "mesh.material") : kNone;
        const std::tuple key(file.lexically_normal().string(), options.creaseDegrees, material);
        const auto [read, isNew] = meshFiles_.try_emplace(key);
        if (isNew) {
            options.keepMaterials = material == kNone;
            read->second = addMeshFile(scene_, file, options);
            if (material != kNone) paint(scene_.meshes[read->second], material);
        }
        index = read->second;
    } else if (const auto* shapeNode = table.get("shape")) {
        index = readShape(table, *shapeNode, name);
    } else {
        index = readInlineMesh(table, name, options);
    }
    for (const char* key : {"radius", "length", "segments"})
        if (const auto* node = table.get(key); node && !table.get("shape")) refuse(*node, fmt::format("mesh.{} without mesh.shape", key));
    meshes_[name] = index;
    meshNames_.push_back(name);
}

// A mesh that is generated: its vertices lie on the shape and have its normals.
uint32_t SceneFile::readShape(const toml::table& table, const toml::node& shapeNode, const std::string& name) {
    for (const char* key : {"vertices", "faces", "face_materials", "crease"})
        if (const auto* other = table.get(key)) refuse(*other, fmt::format("mesh.{} beside mesh.shape", key));
    GeneratedShape shape;
    shape.kind = choiceOf<ShapeKind>(shapeNode, "mesh.shape",
                                     {{"sphere", ShapeKind::sphere}, {"cylinder", ShapeKind::cylinder}, {"teapot", ShapeKind::teapot}});
    const auto length = [&](const char* key, double& value, bool has) {
        const auto* node = table.get(key);
        if (!node) return;
        const std::string field = std::string("mesh.") + key;
        if (!has) refuse(*node, fmt::format("{} beside shape = \"{}\", which has none", field, nameOf(shape.kind)));
        value = numberOf(*node, field);
        if (!(value > 0)) refuse(*node, fmt::format("{} is {:g}, not above 0", field, value));
        if (value > kMaxCoordinate) refuse(*node, fmt::format("{} is {:g}, above 2^100", field, value));
    };
    length("radius", shape.radius, shape.kind != ShapeKind::teapot);
    length("length", shape.length, shape.kind == ShapeKind::cylinder);
    if (const auto* node = table.get("segments")) {
        const SegmentRange range = segmentRangeOf(shape.kind);
        const int64_t count = integerOf(*node, "mesh.segments", range.least, range.most);
        if (count % range.step != 0)
            refuse(*node, fmt::format("mesh.segments is {}; a {} has a multiple of {}", count, nameOf(shape.kind), range.step));
        shape.segments = uint32_t(count);
    }
    PolygonMesh mesh = polygonsOf(shape);
    mesh.name = name;
    mesh.location = location(shapeNode);
    const auto* materialNode = table.get("material");
    mesh.faceMaterial.assign(mesh.faceFirst.size() - 1, materialNode ? materialNamed(*materialNode, "mesh.material") : 0);
    const uint32_t index = addMesh(scene_, std::move(mesh), location(table), options_);
    warnOfRepairs(scene_, index, location(table));
    scene_.meshes[index].shape = std::make_shared<GeneratedShape>(shape);
    return index;
}

uint32_t SceneFile::readInlineMesh(const toml::table& table, const std::string& name, const LoadOptions& options) {
    PolygonMesh mesh;
    mesh.name = name;
    if (!table.get("vertices")) refuse(table, fmt::format("mesh '{}' has neither 'file' nor 'shape' nor 'vertices'", printable(name, 64)));
    const toml::array& vertices = arrayOf(*table.get("vertices"), "mesh.vertices");
    mesh.positions.reserve(vertices.size());
    for (size_t i = 0; i < vertices.size(); ++i) {
        const std::string field = fmt::format("mesh.vertices[{}]", i);
        const toml::array* point = vertices[i].as_array();
        if (point != nullptr && point->size() == 2)  // a point of the plane
            mesh.positions.push_back({numberOf((*point)[0], field + "[0]", -kMaxCoordinate, kMaxCoordinate),
                                      numberOf((*point)[1], field + "[1]", -kMaxCoordinate, kMaxCoordinate), 0.0});
        else
            mesh.positions.push_back(vectorOf(vertices[i], field));
    }

    const toml::node& facesNode = required(table, "faces", "mesh");
    const toml::array& faces = arrayOf(facesNode, "mesh.faces");
    if (faces.empty()) refuse(facesNode, "mesh.faces is empty");
    mesh.location = location(facesNode);
    mesh.faceFirst.push_back(0);
    for (size_t f = 0; f < faces.size(); ++f) {
        const std::string field = fmt::format("mesh.faces[{}]", f);
        const toml::array& face = arrayOf(faces[f], field);
        if (face.size() < 3) refuse(faces[f], fmt::format("{} has {} vertices; a polygon has at least 3", field, face.size()));
        std::set<int64_t> seen;
        for (size_t corner = 0; corner < face.size(); ++corner) {
            const std::string cornerField = fmt::format("{}[{}]", field, corner);
            if (vertices.empty()) refuse(face[corner], cornerField + " names a vertex of none");
            const int64_t vertex = integerOf(face[corner], cornerField, 0, int64_t(vertices.size()) - 1);
            if (!seen.insert(vertex).second) refuse(face[corner], fmt::format("{} names vertex {} twice", field, vertex));
            mesh.corners.push_back({uint32_t(vertex)});
        }
        mesh.faceFirst.push_back(uint32_t(mesh.corners.size()));
    }

    const auto* materialNode = table.get("material");
    const auto* listNode = table.get("face_materials");
    if (materialNode && listNode) refuse(*listNode, "mesh.face_materials beside mesh.material");
    if (listNode) {
        const toml::array& list = arrayOf(*listNode, "mesh.face_materials");
        if (list.size() != faces.size())
            refuse(*listNode, fmt::format("mesh.face_materials has {} names for {} faces", list.size(), faces.size()));
        for (size_t f = 0; f < list.size(); ++f)
            mesh.faceMaterial.push_back(materialNamed(list[f], fmt::format("mesh.face_materials[{}]", f)));
    } else {
        mesh.faceMaterial.assign(faces.size(), materialNode ? materialNamed(*materialNode, "mesh.material") : 0);
    }
    const uint32_t index = addMesh(scene_, std::move(mesh), location(table), options);
    warnOfRepairs(scene_, index, location(table));
    return index;
}

// Mesh with another material. A TriangleMesh has its materials in it, so an object that replaces them draws a copy; one copy for each
// (mesh, material).
uint32_t SceneFile::meshWithMaterial(uint32_t mesh, uint32_t material, const toml::table& location) {
    const auto [found, isNew] = recoloured_.try_emplace({mesh, material}, uint32_t(scene_.meshes.size()));
    if (isNew) {
        copiedTriangles_ += scene_.meshes[mesh].triangles.size();
        if (copiedTriangles_ > kMaxCopiedTriangles)
            refuse(location, fmt::format("object.material copies more than {} triangles in all", kMaxCopiedTriangles));
        TriangleMesh copy = scene_.meshes[mesh];
        paint(copy, material);
        scene_.meshes.push_back(std::move(copy));
    }
    return found->second;
}

}  // namespace plumb::scene_file
