// SPDX-License-Identifier: MIT
// Meshes of a glTF: primitives of triangles, strips and fans. Each is finished when a node first draws it.
#pragma once

#include "pipeline/scene/gltf_accessors.h"
#include "pipeline/scene/gltf_container.h"
#include "pipeline/scene/gltf_materials.h"
#include "pipeline/scene/gltf_reading.h"
#include "pipeline/scene/gltf_rest.h"
#include "pipeline/scene/gltf_value.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace plumb::gltf {

class Meshes {
public:
    Meshes(const Container& container, Materials& materials, Accessors& accessors, const Reading& reading);
    // Index into Scene::meshes of mesh `index` at rest; kNone: nothing to draw in it. Nodes that say nothing about its shape share one.
    uint32_t inScene(const Value& index, const Rest& rest);
    std::vector<double> weightsOf(const Value& index) const;  // of its morph targets, as the mesh states them

private:
    const Reading& reading_;
    Materials& materials_;
    std::vector<Value> meshes_;
    Accessors& accessors_;
    struct Shared {
        std::vector<double> weights;
        uint32_t inScene;
    };
    std::vector<std::optional<Shared>> shared_;  // by mesh
    size_t read_ = 0;
};

}  // namespace plumb::gltf
