// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_nodes.h"

#include "pipeline/scene/affine.h"
#include "pipeline/scene/flattened.h"
#include "pipeline/scene/gltf_accessors.h"
#include "pipeline/scene/gltf_meshes.h"
#include "pipeline/scene/gltf_rest.h"
#include "pipeline/scene/gltf_value.h"
#include "pipeline/scene/gltf_views.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace plumb::gltf {
namespace {

using glm::dmat4;
using glm::dvec4;

// Translation, rotation by the quaternion q and scale, the scale first. `location` is refused where q is no rotation.
dmat4 composed(const Value& location, const std::array<double, 3>& t, std::array<double, 4> q, const std::array<double, 3>& s) {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    // Writers round quaternions to float or to a few decimals; anything further is not a rotation.
    if (!(std::abs(length - 1) < 0.1)) location.refuse(fmt::format("is a quaternion of length {:g}, not 1", length));
    for (double& component : q) component /= length;
    const auto [x, y, z, w] = q;
    dmat4 m(1.0);
    m[0] = dvec4(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0) * s[0];
    m[1] = dvec4(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0) * s[1];
    m[2] = dvec4(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0) * s[2];
    m[3] = dvec4(t[0], t[1], t[2], 1);
    return m;
}

dmat4 parentFromNode(const Value& node) {
    if (const auto matrix = node.find("matrix")) {
        for (const char* key : {"translation", "rotation", "scale"})
            if (const auto other = node.find(key)) other->refuse("beside a matrix");
        const auto entries = matrix->numbers<16>(-kMaxCoordinate, kMaxCoordinate);
        dmat4 m;
        for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = entries[size_t(i)];
        if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1) matrix->refuse("the last row is not 0, 0, 0, 1");
        return m;
    }
    std::array<double, 3> t{0, 0, 0}, s{1, 1, 1};
    std::array<double, 4> q{0, 0, 0, 1};
    if (const auto value = node.find("translation")) t = value->numbers<3>(-kMaxCoordinate, kMaxCoordinate);
    if (const auto value = node.find("scale")) s = value->numbers<3>(-kMaxCoordinate, kMaxCoordinate);
    if (const auto value = node.find("rotation")) q = value->numbers<4>(-2, 2);
    return composed(node.find("rotation").value_or(node), t, q, s);
}

class Nodes {
public:
    Nodes(const Container& container, Materials& materials, const Reading& reading)
        : reading_(reading),
          root_(container.root()),
          nodes_(root_.list("nodes")),
          cameras_(root_.list("cameras")),
          skins_(root_.list("skins")),
          accessors_(container, reading),
          meshes_(container, materials, accessors_, reading),
          world_(nodes_.size()),
          joints_(skins_.size()) {
        if (const auto extensions = root_.find("extensions"))
            if (const auto punctual = extensions->find("KHR_lights_punctual")) lights_ = punctual->list("lights");
    }

    void read() {
        const std::vector<Value> scenes = root_.list("scenes");
        const auto sceneValue = root_.find("scene");
        const size_t chosen = sceneValue ? sceneValue->index(scenes.size(), "scenes") : 0;
        if (scenes.size() > 1) reading_.ignore(scenes[chosen == 0 ? 1 : 0], "scenes but the default one");
        if (!scenes.empty()) {
            for (const Value& node : scenes[chosen].list("nodes")) placeTree(node.index(nodes_.size(), "nodes"));
        } else {
            // Without scenes, what no node has as a child is a root.
            const std::vector<size_t>& parents = parentsOfNodes();
            for (size_t i = 0; i < nodes_.size(); ++i)
                if (parents[i] == kNoNode) placeTree(i);
        }
        for (const size_t i : order_) readNode(nodes_[i], *world_[i]);
    }

private:
    static constexpr size_t kNoNode = size_t(-1);

    struct Reached {
        size_t node, parent;
    };

    // Locations a node and all below it, each before its children. A tree may have any depth.
    void placeTree(size_t root) {
        std::vector<Reached> reached{{root, kNoNode}};
        while (!reached.empty()) {
            const auto [i, parent] = reached.back();
            reached.pop_back();
            const Value& node = nodes_[i];
            if (world_[i]) node.refuse("is reached twice: a cycle, or a node with two parents");
            const dmat4 worldFromNode = (parent == kNoNode ? dmat4(1.0) : *world_[parent]) * parentFromNode(node);
            if (!entriesUsable(worldFromNode)) node.refuse("the world matrix has entries above 2^100");
            world_[i] = worldFromNode;
            order_.push_back(i);
            const std::vector<Value> children = node.list("children");
            for (size_t k = children.size(); k-- > 0;) reached.push_back({children[k].index(nodes_.size(), "nodes"), i});
        }
    }

    // Parent of each node, kNoNode for a root.
    const std::vector<size_t>& parentsOfNodes() {
        if (parents_.empty()) {
            parents_.assign(nodes_.size(), kNoNode);
            for (size_t i = 0; i < nodes_.size(); ++i)
                for (const Value& child : nodes_[i].list("children")) parents_[child.index(nodes_.size(), "nodes")] = i;
        }
        return parents_;
    }

    // Matrix of a node, also of one that the scene does not reach: the joints of a skin may stand outside it.
    const dmat4& worldOf(size_t i) {
        std::vector<size_t> path;
        for (size_t at = i; at != kNoNode && !world_[at]; at = parentsOfNodes()[at]) {
            path.push_back(at);
            if (path.size() > nodes_.size()) nodes_[i].refuse("is below itself");
        }
        for (size_t k = path.size(); k-- > 0;) {
            const size_t parent = parentsOfNodes()[path[k]];
            const dmat4 world = (parent == kNoNode ? dmat4(1.0) : *world_[parent]) * parentFromNode(nodes_[path[k]]);
            if (!entriesUsable(world)) nodes_[path[k]].refuse("the world matrix has entries above 2^100");
            world_[path[k]] = world;
        }
        return *world_[i];
    }

    // Matrices from the mesh of a skin to the world, one a joint (glTF 3.7.3.1).
    const std::vector<dmat4>& jointsOf(const Value& skinIndex) {
        const size_t i = skinIndex.index(skins_.size(), "skins");
        if (joints_[i]) return *joints_[i];
        const Value& skin = skins_[i];
        skin.required("joints");
        const std::vector<Value> joints = skin.list("joints");
        if (joints.empty()) skin.refuse("has no joints");
        std::optional<Accessor> inverse;
        if (const auto stated = skin.find("inverseBindMatrices")) {
            inverse = accessors_.at(*stated);
            if (inverse->components != 16 || inverse->count < joints.size())
                stated->refuse(fmt::format("is not an accessor of MAT4 with {} elements", joints.size()));
        }
        std::vector<dmat4> made;
        for (size_t joint = 0; joint < joints.size(); ++joint) {
            dmat4 jointFromMesh(inverse && !inverse->hasData() ? 0.0 : 1.0);
            if (inverse && inverse->hasData())
                for (int k = 0; k < 16; ++k) jointFromMesh[k / 4][k % 4] = inverse->component(joint, k);
            made.push_back(worldOf(joints[joint].index(nodes_.size(), "nodes")) * jointFromMesh);
            if (!entriesUsable(made.back())) joints[joint].refuse("the matrix of the joint has entries above 2^100");
        }
        return *(joints_[i] = std::move(made));
    }

    void readNode(const Value& node, const dmat4& worldFromNode) {
        if (const auto index = node.find("mesh")) addMeshOf(node, *index, worldFromNode);
        if (const auto index = node.find("camera")) readCamera(*index, node, cameras_, worldFromNode, reading_);
        reading_.ignoreExtensions(node, {"KHR_lights_punctual", "EXT_mesh_gpu_instancing"});
        if (const auto extensions = node.find("extensions"))
            if (const auto punctual = extensions->find("KHR_lights_punctual"))
                readLight(punctual->required("light"), lights_, worldFromNode, reading_);
    }

    void addMeshOf(const Value& node, const Value& meshIndex, const dmat4& worldFromNode) {
        Rest rest;
        rest.weights = node.find("weights") ? weightsIn(node) : meshes_.weightsOf(meshIndex);
        rest.worldFromNode = worldFromNode;
        if (const auto skin = node.find("skin")) {
            rest.joints = jointsOf(*skin);
            return addObject(node, meshes_.inScene(meshIndex, rest), dmat4(1.0));
        }
        const uint32_t mesh = meshes_.inScene(meshIndex, rest);
        if (const auto extensions = node.find("extensions"))
            if (const auto instances = extensions->find("EXT_mesh_gpu_instancing"))
                return addInstances(node, *instances, mesh, worldFromNode);
        addObject(node, mesh, worldFromNode);
    }

    // EXT_mesh_gpu_instancing: an object an instance, each with its own translation, rotation and scale below the node's.
    void addInstances(const Value& node, const Value& instances, uint32_t mesh, const dmat4& worldFromNode) {
        // An object takes some hundred bytes for twelve or more of the file.
        constexpr uint64_t kCornersPerInstance = 64;
        const Value attributes = instances.required("attributes");
        std::optional<size_t> count;
        std::array<std::optional<Accessor>, 3> parts;
        constexpr const char* kNames[3] = {"TRANSLATION", "ROTATION", "SCALE"};
        for (size_t part = 0; part < 3; ++part)
            if (const auto index = attributes.find(kNames[part])) {
                const Accessor accessor = accessors_.at(*index);
                if (accessor.components != (part == 1 ? 4 : 3)) index->refuse(fmt::format("{} has the wrong type", kNames[part]));
                if (count && *count != accessor.count)
                    index->refuse(fmt::format("{} has {} elements, another attribute has {}", kNames[part], accessor.count, *count));
                count = accessor.count;
                if (accessor.hasData()) parts[part] = accessor;
            }
        if (!count) return addObject(node, mesh, worldFromNode);
        accessors_.countCorners(kCornersPerInstance * std::min<uint64_t>(*count, UINT32_MAX), node);
        for (size_t i = 0; i < *count; ++i) {
            const auto numbers = [&]<size_t N>(const std::optional<Accessor>& from, std::array<double, N> otherwise) {
                if (from)
                    for (size_t k = 0; k < N; ++k) otherwise[k] = from->component(i, int(k));
                return otherwise;
            };
            const dmat4 nodeFromInstance =
                composed(instances, numbers(parts[0], std::array<double, 3>{0, 0, 0}), numbers(parts[1], std::array<double, 4>{0, 0, 0, 1}),
                         numbers(parts[2], std::array<double, 3>{1, 1, 1}));
            const dmat4 world = worldFromNode * nodeFromInstance;
            if (!entriesUsable(world)) instances.refuse(fmt::format("the matrix of instance {} has entries above 2^100 or NaN", i));
            addObject(node, mesh, world);
        }
    }

    void addObject(const Value& node, uint32_t mesh, const dmat4& worldFromMesh) {
        Scene& scene = reading_.scene;
        if (mesh == kNone) return;
        if (!hasInverse(worldFromMesh) && leavesNoArea(scene.meshes[mesh], worldFromMesh))
            return reading_.ignore(node, "meshes flattened by a scale of 0");
        Object object;
        object.name = scene.meshes[mesh].name;
        if (const auto name = node.find("name")) object.name = name->text();
        object.mesh = mesh;
        object.location = node.location();
        object.worldFromObject = worldFromMesh;
        scene.objects.push_back(std::move(object));
    }

    const Reading& reading_;
    Value root_;
    std::vector<Value> nodes_, cameras_, skins_, lights_;
    Accessors accessors_;
    Meshes meshes_;
    std::vector<std::optional<dmat4>> world_;                // by node: from the node's space
    std::vector<size_t> order_, parents_;                    // nodes of the scene, parents first; and by node
    std::vector<std::optional<std::vector<dmat4>>> joints_;  // by skin
};

}  // namespace

void readNodes(const Container& container, Materials& materials, const Reading& reading) { Nodes(container, materials, reading).read(); }

}  // namespace plumb::gltf
