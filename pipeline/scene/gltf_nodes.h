// SPDX-License-Identifier: MIT
// Nodes of a glTF: the hierarchy becomes objects, lights and a camera.
#pragma once

#include "pipeline/scene/gltf_container.h"
#include "pipeline/scene/gltf_materials.h"
#include "pipeline/scene/gltf_reading.h"

namespace plumb::gltf {

// Reads what the nodes of the default scene hold, meshes included.
void readNodes(const Container& container, Materials& materials, const Reading& reading);

}  // namespace plumb::gltf
