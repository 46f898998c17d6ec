// SPDX-License-Identifier: MIT
// Reader of scene.toml (docs/scene-format.md). World space is binary64; matrices are to-From, column vectors.
// Left-handed scenes keep their polygons as listed (clockwise seen from outside): the cross product (P1-P0)x(P2-P0)
// points outward there just as for counter-clockwise lists in a right-handed world, so finishMesh serves both.
// Internal to the reader: read_scene_toml.cpp walks the file, a unit toml_*.cpp reads each of its parts.
#pragma once

#include "pipeline/scene/toml_values.h"
#include "pipeline/transform/steps.h"

#include <fmt/format.h>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace plumb::scene_file {

class SceneFile : private TomlValues {
public:
    SceneFile(const std::filesystem::path& path, const LoadOptions& options) : TomlValues(path), options_(options) {}
    Scene read();

private:
    // Readers of the parts of the file.
    void readSettings(const toml::table& root);
    void readRays(const toml::table& root);
    void readCamera(const toml::table& table);
    void readMaterial(const toml::table& table);
    void readWeights(const toml::table& table, Material& material) const;
    void readSphere(const toml::table& table);
    void readPlane(const toml::table& table);
    void readLight(const toml::table& table);
    void readArea(const toml::table& table, const Light& light);
    void readMesh(const toml::table& table);
    uint32_t readShape(const toml::table& table, const toml::node& shapeNode, const std::string& name);
    uint32_t readInlineMesh(const toml::table& table, const std::string& name, const LoadOptions& options);
    void readObject(const toml::table& table, int parent, int depth);
    struct Placement {
        glm::dmat4 matrix{1.0};
        std::vector<Step3> steps;  // elementary, in order of application
    };
    Placement readTransforms(const toml::node& node, const std::string& field, uint32_t mesh) const;
    Placement readTransform(const toml::table& table, const std::string& field, uint32_t mesh, const glm::dmat4& before) const;
    Placement readRotate(const toml::node& node, const std::string& field) const;
    glm::dvec3 centreOf(const toml::node& about, const std::string& field, uint32_t mesh, const glm::dmat4& before) const;
    uint32_t materialNamed(const toml::node& node, const std::string& field) const;
    static std::string tooDeep() { return fmt::format("objects are nested deeper than {}", kMaxDepth); }
    void linkParents();
    void placeObjects();

    struct Node {
        std::string name;
        const toml::table* table;  // for messages; lives as long as read()
        const toml::node* parentNamed = nullptr;
        int parent = -1;
        uint32_t mesh = kNone;  // index into scene_.meshes; kNone: a group
        uint32_t material = kNone;
        Placement parentFromNode;
        glm::dmat4 worldFromNode{1.0};
        int depth = 0;
        bool placed = false;
        bool implied = false;  // one object for each mesh, in a file that states no object
    };
    uint32_t meshWithMaterial(uint32_t mesh, uint32_t material, const toml::table& location);

    LoadOptions options_;
    Scene scene_;
    std::map<std::string, uint32_t, std::less<>> materials_;  // "default" is material 0; a file may restate it once
    bool defaultStated_ = false;
    std::map<std::string, uint32_t, std::less<>> meshes_;                      // indices into scene_.meshes
    std::vector<std::string> meshNames_;                                       // in file order
    std::map<std::tuple<std::string, double, uint32_t>, uint32_t> meshFiles_;  // (file, crease, material): read once
    std::vector<Node> nodes_;
    std::map<std::string, int, std::less<>> nodeNames_;
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> recoloured_;  // copy of a mesh by (mesh, material)
    uint64_t copiedTriangles_ = 0;
};

}  // namespace plumb::scene_file
