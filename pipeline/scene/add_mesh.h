// SPDX-License-Identifier: MIT
// Meshes on their way into a scene.
#pragma once

#include "pipeline/scene/load.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace plumb {

// Appends a finished mesh; returns its index. A mesh too small to draw is refused at `location`. Repairs of finishMesh() become warnings.
uint32_t addFinished(Scene& scene, TriangleMesh mesh, const std::string& location);

// Finishes and appends a mesh of a format that states its materials once. mesh.faceMaterial are indices into scene.materials (kNone:
// material 0); its own list of materials is empty. Adds no material to the scene, and no warning: a file of many meshes warns once.
uint32_t addMesh(Scene& scene, PolygonMesh mesh, const std::string& location, const LoadOptions& options);

// Warns of the repairs of finishMesh() in the meshes from `first` on: one warning a kind, with their sum and `location`.
void warnOfRepairs(Scene& scene, size_t first, const std::string& location);

}  // namespace plumb
