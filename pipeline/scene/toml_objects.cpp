// SPDX-License-Identifier: MIT
// Objects of a scene and their hierarchy.
#include "pipeline/scene/toml_scene.h"

#include "pipeline/scene/affine.h"
#include "pipeline/scene/flattened.h"
#include "pipeline/scene/text.h"

#include <fmt/format.h>
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb::scene_file {

void SceneFile::readObject(const toml::table& table, int parent, int depth) {
    allowKeys(table, parent < 0 ? "[[object]]" : "[[object.child]]", {"name", "mesh", "material", "transform", "parent", "child"});
    if (depth > kMaxDepth) refuse(table, tooDeep());
    Node node;
    node.table = &table;
    node.parent = parent;
    if (const auto* meshNode = table.get("mesh")) {
        const std::string mesh = stringOf(*meshNode, "object.mesh");
        const auto found = meshes_.find(mesh);
        if (found == meshes_.end())
            refuse(*meshNode, fmt::format("object.mesh names the unknown mesh '{}'{}", printable(mesh, 64), suggestion(mesh, meshNames_)));
        node.mesh = found->second;
        node.name = mesh;
    }
    if (const auto* nameNode = table.get("name")) {
        node.name = stringOf(*nameNode, "object.name");
        if (!nodeNames_.emplace(node.name, int(nodes_.size())).second)
            refuse(*nameNode, fmt::format("object.name '{}' is taken", printable(node.name, 64)));
    }
    if (const auto* materialNode = table.get("material")) {
        if (node.mesh == kNone) refuse(*materialNode, "object.material without object.mesh");
        node.material = materialNamed(*materialNode, "object.material");
    }
    if (const auto* transform = table.get("transform")) node.parentFromNode = readTransforms(*transform, "object.transform", node.mesh);
    if (const auto* parentNode = table.get("parent")) {
        if (parent >= 0) refuse(*parentNode, "object.parent of a nested child: it has a parent already");
        node.parentNamed = parentNode;
    }
    const int self = int(nodes_.size());
    nodes_.push_back(std::move(node));
    eachTable(table, "child", "object.child", [&](const toml::table& child) { readObject(child, self, depth + 1); });
}

void SceneFile::linkParents() {
    for (Node& node : nodes_) {
        if (!node.parentNamed) continue;
        const std::string name = stringOf(*node.parentNamed, "object.parent");
        const auto found = nodeNames_.find(name);
        if (found == nodeNames_.end()) {
            std::vector<std::string_view> known;
            for (const auto& [key, index] : nodeNames_) {
                (void)index;
                known.push_back(key);
            }
            refuse(*node.parentNamed,
                   fmt::format("object.parent names the unknown object '{}'{}", printable(name, 64), suggestion(name, known)));
        }
        node.parent = found->second;
    }
}

// Computes world matrices from the roots down, each node once, and adds the objects in file order.
void SceneFile::placeObjects() {
    for (size_t start = 0; start < nodes_.size(); ++start) {
        std::vector<int> chain;  // from `start` up to the first placed ancestor
        for (int n = int(start); n >= 0 && !nodes_[size_t(n)].placed; n = nodes_[size_t(n)].parent) {
            const auto again = std::find(chain.begin(), chain.end(), n);
            if (again != chain.end()) {
                std::string cycle;
                for (auto member = again; member != chain.end(); ++member) cycle += printable(nodes_[size_t(*member)].name, 40) + " -> ";
                const Node& first = nodes_[size_t(n)];
                refuse(first.parentNamed ? *first.parentNamed : *first.table,
                       fmt::format("object.parent: {}{} is a cycle", printable(cycle, 400), printable(first.name, 40)));
            }
            chain.push_back(n);
            if (int(chain.size()) > kMaxDepth) refuse(*nodes_[start].table, tooDeep());
        }
        for (auto n = chain.rbegin(); n != chain.rend(); ++n) {
            Node& node = nodes_[size_t(*n)];
            node.worldFromNode =
                node.parent < 0 ? node.parentFromNode.matrix : nodes_[size_t(node.parent)].worldFromNode * node.parentFromNode.matrix;
            if (!entriesUsable(node.worldFromNode)) refuse(*node.table, "object.transform: the world matrix has entries above 2^100");
            node.depth = node.parent < 0 ? 1 : nodes_[size_t(node.parent)].depth + 1;
            if (node.depth > kMaxDepth) refuse(*node.table, tooDeep());
            node.placed = true;
        }
    }
    for (const Node& node : nodes_) {
        if (node.mesh == kNone) continue;
        Object object;
        object.name = node.name;
        object.location = node.implied ? scene_.meshes[node.mesh].location : location(*node.table);
        object.mesh = node.material == kNone ? node.mesh : meshWithMaterial(node.mesh, node.material, *node.table);
        object.worldFromObject = node.worldFromNode;
        for (const Node* n = &node;; n = &nodes_[size_t(n->parent)]) {  // its own steps act first, then its parent's
            object.chain.insert(object.chain.end(), n->parentFromNode.steps.begin(), n->parentFromNode.steps.end());
            if (n->parent < 0) break;
        }
        if (!hasInverse(object.worldFromObject) && leavesNoArea(scene_.meshes[object.mesh], object.worldFromObject))
            scene_.warnings.push_back(
                fmt::format("object '{}' is flattened to a line or a point: no surface is left of it", printable(object.name, 64)));
        scene_.objects.push_back(std::move(object));
    }
}

}  // namespace plumb::scene_file
