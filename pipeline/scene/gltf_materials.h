// SPDX-License-Identifier: MIT
// Materials of a glTF: metallic-roughness becomes Phong.
#pragma once

#include "pipeline/scene/gltf_reading.h"
#include "pipeline/scene/gltf_value.h"

namespace plumb::gltf {

// Appends the default material and those of the file to the scene.
void readMaterials(const Value& root, const Reading& reading);

}  // namespace plumb::gltf
