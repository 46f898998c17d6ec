// SPDX-License-Identifier: MIT
// Cameras of a glTF and the lights of KHR_lights_punctual, at the nodes that hold them.
#pragma once

#include "pipeline/scene/gltf_reading.h"
#include "pipeline/scene/gltf_value.h"

#include <glm/glm.hpp>
#include <vector>

namespace plumb::gltf {

// `index`, of `node`, names one of `cameras`. The first perspective camera becomes the scene's, or the one that LoadOptions::camera names.
void readCamera(const Value& index, const Value& node, const std::vector<Value>& cameras, const glm::dmat4& worldFromNode,
                const Reading& reading);
// `index` names one of `lights`, which is appended to the scene's.
void readLight(const Value& index, const std::vector<Value>& lights, const glm::dmat4& worldFromNode, const Reading& reading);
// Sets the distance from the scene's camera to the middle of what is drawn.
void focusCamera(Scene& scene);

}  // namespace plumb::gltf
