// SPDX-License-Identifier: MIT
// Bound of how far float32 may move a vertex from its position by the file, the object's matrix and the camera, computed before anything is
// drawn. Snapping to 1/256 px comes on top (docs/accuracy.md).
#pragma once

#include "pipeline/render/render.h"

#include <cstdint>
#include <string>
#include <vector>

namespace plumb {

// Error of visible parts above which a warning is given.
inline constexpr double kToldPixels = 0.5;

struct VertexError {
    uint32_t object = 0;  // of the scene
    double pixels =
        0;  // the larger of x and y, over the parts of the object's triangles in the view; +infinity: a depth of 0 is within the bound
    double inBinary64 = 0;  // error with --trade transform=fp64; equal to `pixels` where the request cannot choose it
};

// Errors of the objects that exceed kToldPixels; the others are left out.
std::vector<VertexError> vertexErrors(const Scene& scene, const RenderRequest& request);
// Error of one object, also below kToldPixels; for tests.
VertexError vertexErrorOf(const Scene& scene, const RenderRequest& request, uint32_t object);
// Error as one sentence for the user.
std::string sentenceOf(const Scene& scene, const VertexError& error);

}  // namespace plumb
