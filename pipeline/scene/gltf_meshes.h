// SPDX-License-Identifier: MIT
// Meshes of a glTF: primitives of triangles, strips and fans. Each is finished when a node first draws it.
#pragma once

#include "pipeline/scene/gltf_accessors.h"
#include "pipeline/scene/gltf_container.h"
#include "pipeline/scene/gltf_materials.h"
#include "pipeline/scene/gltf_reading.h"
#include "pipeline/scene/gltf_value.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace plumb::gltf {

class Meshes {
public:
    Meshes(const Container& container, Materials& materials, const Reading& reading);
    uint32_t inScene(const Value& index);  // index into Scene::meshes; kNone: nothing to draw in it

private:
    const Reading& reading_;
    Materials& materials_;
    std::vector<Value> meshes_;
    Accessors accessors_;
    std::vector<std::optional<uint32_t>> inScene_;
    size_t read_ = 0;
};

}  // namespace plumb::gltf
