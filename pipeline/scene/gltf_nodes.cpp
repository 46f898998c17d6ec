// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_nodes.h"

#include "pipeline/scene/affine.h"
#include "pipeline/scene/flattened.h"
#include "pipeline/scene/gltf_meshes.h"
#include "pipeline/scene/gltf_value.h"
#include "pipeline/scene/gltf_views.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

namespace plumb::gltf {
namespace {

using glm::dmat4;
using glm::dvec4;

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
    if (const auto value = node.find("rotation")) {
        q = value->numbers<4>(-2, 2);
        const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        // Writers round quaternions to float or to a few decimals; anything further is not a rotation.
        if (!(std::abs(length - 1) < 0.1)) value->refuse(fmt::format("is a quaternion of length {:g}, not 1", length));
        for (double& component : q) component /= length;
    }
    const auto [x, y, z, w] = q;
    dmat4 m(1.0);
    m[0] = dvec4(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0) * s[0];
    m[1] = dvec4(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0) * s[1];
    m[2] = dvec4(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0) * s[2];
    m[3] = dvec4(t[0], t[1], t[2], 1);
    return m;
}

class Nodes {
public:
    Nodes(const Container& container, Materials& materials, const Reading& reading)
        : reading_(reading),
          root_(container.root()),
          nodes_(root_.list("nodes")),
          cameras_(root_.list("cameras")),
          meshes_(container, materials, reading),
          visited_(nodes_.size()) {
        if (const auto extensions = root_.find("extensions"))
            if (const auto punctual = extensions->find("KHR_lights_punctual")) lights_ = punctual->list("lights");
    }

    void read() {
        const std::vector<Value> scenes = root_.list("scenes");
        const auto sceneValue = root_.find("scene");
        const size_t chosen = sceneValue ? sceneValue->index(scenes.size(), "scenes") : 0;
        if (!scenes.empty()) {
            if (scenes.size() > 1) reading_.ignore(scenes[chosen == 0 ? 1 : 0], "scenes but the default one");
            for (const Value& node : scenes[chosen].list("nodes")) readTree(node.index(nodes_.size(), "nodes"));
            return;
        }
        // Without scenes, what no node has as a child is a root.
        std::vector<bool> isChild(nodes_.size());
        for (const Value& node : nodes_)
            for (const Value& child : node.list("children")) isChild[child.index(nodes_.size(), "nodes")] = true;
        for (size_t i = 0; i < nodes_.size(); ++i)
            if (!isChild[i]) readTree(i);
    }

private:
    struct Reached {
        size_t node;
        dmat4 worldFromParent;
    };

    // Reads a node and all below it, each before its children. A tree may have any depth.
    void readTree(size_t root) {
        std::vector<Reached> reached{{root, dmat4(1.0)}};
        while (!reached.empty()) {
            const Reached next = reached.back();
            reached.pop_back();
            const dmat4 worldFromNode = readNode(next.node, next.worldFromParent);
            const std::vector<Value> children = nodes_[next.node].list("children");
            for (size_t i = children.size(); i-- > 0;) reached.push_back({children[i].index(nodes_.size(), "nodes"), worldFromNode});
        }
    }

    dmat4 readNode(size_t i, const dmat4& worldFromParent) {
        const Value& node = nodes_[i];
        if (visited_[i]) node.refuse("is reached twice: a cycle, or a node with two parents");
        visited_[i] = true;
        const dmat4 worldFromNode = worldFromParent * parentFromNode(node);
        if (!entriesUsable(worldFromNode)) node.refuse("the world matrix has entries above 2^100");
        if (const auto skin = node.find("skin")) reading_.ignore(*skin, "skins");
        if (const auto index = node.find("mesh")) addObject(node, *index, worldFromNode);
        if (const auto index = node.find("camera")) readCamera(*index, cameras_, worldFromNode, reading_);
        reading_.ignoreExtensions(node, {"KHR_lights_punctual"});
        if (const auto extensions = node.find("extensions"))
            if (const auto punctual = extensions->find("KHR_lights_punctual"))
                readLight(punctual->required("light"), lights_, worldFromNode, reading_);
        return worldFromNode;
    }

    void addObject(const Value& node, const Value& meshIndex, const dmat4& worldFromNode) {
        Scene& scene = reading_.scene;
        const uint32_t mesh = meshes_.inScene(meshIndex);
        if (mesh == kNone) return;
        if (!hasInverse(worldFromNode) && leavesNoArea(scene.meshes[mesh], worldFromNode))
            return reading_.ignore(node, "meshes flattened by a scale of 0");
        Object object;
        object.name = scene.meshes[mesh].name;
        if (const auto name = node.find("name")) object.name = name->text();
        object.mesh = mesh;
        object.place = node.place();
        object.worldFromObject = worldFromNode;
        scene.objects.push_back(std::move(object));
    }

    const Reading& reading_;
    Value root_;
    std::vector<Value> nodes_, cameras_, lights_;
    Meshes meshes_;
    std::vector<bool> visited_;
};

}  // namespace

void readNodes(const Container& container, Materials& materials, const Reading& reading) { Nodes(container, materials, reading).read(); }

}  // namespace plumb::gltf
