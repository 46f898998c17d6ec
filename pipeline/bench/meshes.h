// SPDX-License-Identifier: MIT
// Generated scenes of the benchmarks: one mesh, one material, one directional light, a camera on the +Z axis.
#pragma once

#include "pipeline/scene/scene.h"

#include <optional>
#include <string>
#include <vector>

namespace plumb {

// Names of the scenes in the order in which they are measured: sphere1e3 ... layers-f2b.
std::vector<std::string> benchSceneNames();
// Scene of a name: "sphereN" and "knotN" with any N from 1e3 to 1e7, and the names above; none for another word.
std::optional<Scene> benchScene(const std::string& name, double aspect);

}  // namespace plumb
