// SPDX-License-Identifier: MIT
// Meshes on their way into a scene.
#pragma once

#include "pipeline/scene/load.h"

namespace plumb {

// Appends a finished mesh; returns its index. What finishMesh repaired becomes counted warnings that begin with
// `place`; a mesh too small to draw is refused there.
uint32_t addFinished(Scene& scene, TriangleMesh mesh, const std::string& place);

// For formats that state their materials once: finishes `mesh`, whose faceMaterial are indices into scene.materials
// (kNone: material 0) and whose own list of materials is empty, and appends it. No material is added to the scene.
uint32_t addMesh(Scene& scene, PolygonMesh mesh, const std::string& place, const LoadOptions& options);

}  // namespace plumb
