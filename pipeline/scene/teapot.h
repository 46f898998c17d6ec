// SPDX-License-Identifier: MIT
// Newell's teapot: 32 bicubic patches, from scenes/teapot/patches.txt, which the build makes a part of the program. Y up, in the units of the file.
#pragma once

#include "pipeline/scene/mesh.h"

#include <cstdint>

namespace plumb {

// Triangles of all patches, each side cut into `steps` (at least 1). Corners of neighbouring patches are the same to 2^-20 units, so that they meet
// without a crack.
PolygonMesh teapotPolygons(uint32_t steps);
// Bound of the distance between patches and triangles, in units of the file (shape.h).
double teapotDeviation(uint32_t steps);

}  // namespace plumb
