// SPDX-License-Identifier: MIT
// How far float32 may move a vertex of a picture from where the file, the object's matrix and the camera put it: a bound, before anything is drawn.
// Snapping to 1/256 px comes on top (docs/accuracy.md).
#pragma once

#include "pipeline/render/render.h"

#include <cstdint>
#include <string>
#include <vector>

namespace plumb {

// Visible parts that may be off by more than this are worth a warning.
inline constexpr double kToldPixels = 0.5;

struct VertexError {
    uint32_t object = 0;  // of the scene
    double pixels =
        0;  // in x or y, the larger, over all that the view holds of the object's triangles; +infinity: a depth of 0 is within the bound
    double inBinary64 = 0;  // the same with --trade transform=fp64; equal to `pixels` where the request has no such choice
};

// Errors of the objects that exceed kToldPixels; the others are left out.
std::vector<VertexError> vertexErrors(const Scene& scene, const RenderRequest& request);
// The bound of one object, without a limit below which it is not told; for tests.
VertexError vertexErrorOf(const Scene& scene, const RenderRequest& request, uint32_t object);
// One sentence of it, for whoever looks at the picture.
std::string sentenceOf(const Scene& scene, const VertexError& error);

}  // namespace plumb
