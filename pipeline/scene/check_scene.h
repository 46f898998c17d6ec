// SPDX-License-Identifier: MIT
// Judges a scene that no reader made.
#pragma once

#include "pipeline/scene/scene.h"

namespace plumb {

// Throws Error(input), one sentence, for what a reader would have refused: no camera, an index that names nothing, a number that is not
// finite, a light without direction. Contents of meshes are those of addMesh() or a reader and are not read again.
void checkScene(const Scene&);

}  // namespace plumb
