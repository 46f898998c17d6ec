// SPDX-License-Identifier: MIT
// Pixels whose face the truth decides even when every vertex may stand a little aside. A rasteriser snaps vertices to a grid, and at an edge
// that may change the face of a sample and with it the whole colour.
#pragma once

#include "pipeline/render/render.h"

#include <cstdint>
#include <vector>

namespace plumb {

// Error of a vertex that is snapped to 1/256 of a sample: 1/512, and eight roundings of a float32 coordinate as large as the picture. In
// samples.
double snapOf(const RenderRequest& request);

// 1 a pixel in which every sample shows the same face wherever its vertices stand within `aside` samples of their places, along each axis of
// the screen; 0 elsewhere. For raster pictures of --fill exact. A traced picture snaps nothing: 1 everywhere.
//   A sample P is inside a triangle with moved vertices only if each edge function is >= -m, m = aside (|a| + |b|), and surely inside if each
// is > m. The moved triangle shows at P what the true one has at most `aside` away, so 1/w is off by at most aside (|sa| + |sb|). The face is
// decided where one triangle is surely hit and surely nearer than all others that may be hit, or where none may be.
std::vector<uint8_t> decidedPixels(const Scene& scene, const RenderRequest& request, double aside);

}  // namespace plumb
