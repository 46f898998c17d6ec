// SPDX-License-Identifier: MIT
// Meshes on their way into a scene.
#pragma once

#include "pipeline/scene/load.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace plumb {

// Appends a finished mesh; returns its index. A mesh too small to draw is refused at `place`; what finishMesh repaired
// becomes warnings.
uint32_t addFinished(Scene& scene, TriangleMesh mesh, const std::string& place);

// For formats that state their materials once: finishes `mesh`, whose faceMaterial are indices into scene.materials
// (kNone: material 0) and whose own list of materials is empty, and appends it. No material is added to the scene,
// and no warning: a file of many meshes warns once.
uint32_t addMesh(Scene& scene, PolygonMesh mesh, const std::string& place, const LoadOptions& options);

// What finishMesh repaired in the meshes from `first` on becomes warnings: one a kind, with their sum and `place`.
void warnOfRepairs(Scene& scene, size_t first, const std::string& place);

}  // namespace plumb
