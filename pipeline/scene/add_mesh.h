// SPDX-License-Identifier: MIT
// For scene formats that state their materials once: meshes that name materials of the scene.
#pragma once

#include "pipeline/scene/load.h"

namespace plumb {

// Finishes `mesh`, whose faceMaterial are indices into scene.materials (kNone: material 0) and whose own list of
// materials is empty, and appends it. Returns the index into scene.meshes; no material is added to the scene.
uint32_t addMesh(Scene& scene, PolygonMesh mesh, const LoadOptions& options);

}  // namespace plumb
