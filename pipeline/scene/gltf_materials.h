// SPDX-License-Identifier: MIT
// Materials of a glTF: metallic-roughness and specular-glossiness become Phong.
#pragma once

#include "pipeline/scene/gltf_reading.h"
#include "pipeline/scene/gltf_value.h"

#include <cstdint>
#include <exception>
#include <vector>

namespace plumb::gltf {

class Materials {
public:
    // Appends the default material and those of the file to the scene.
    Materials(const Value& root, const Reading& reading);
    // Index into Scene::materials of the one that `primitive` names. One that cannot be read is refused here.
    uint32_t of(const Value& primitive);
    // Passes over those that cannot be read and that nothing asked for.
    void passUnread() const;

private:
    struct Bad {
        Value at;
        uint32_t index;  // into Scene::materials
        std::exception_ptr refusal;
    };

    const Reading& reading_;
    std::vector<Bad> bad_;
};

}  // namespace plumb::gltf
