// SPDX-License-Identifier: MIT
// Bound of how far arithmetic may move a vertex on the screen, computed before anything is drawn.
// The vertex's right position follows from the file, the object's matrix and the camera. Snapping to 1/256 px comes on top
// (docs/derivations.md, Vertices).
#pragma once

#include "pipeline/render/render.h"

#include <cstdint>
#include <string>
#include <vector>

namespace plumb {

// Error of visible parts above which a warning is given.
inline constexpr double kToldPixels = 0.5;

struct VertexError {
    uint32_t object = 0;  // index in the scene
    // Error in pixels, the larger of x and y, over the parts of the object's triangles in the view. +infinity: the bound reaches depth 0.
    double pixels = 0;
};

// Errors of the objects that exceed kToldPixels; the others are left out.
std::vector<VertexError> vertexErrors(const Scene& scene, const RenderRequest& request);
// Error of one object, also below kToldPixels; for tests.
VertexError vertexErrorOf(const Scene& scene, const RenderRequest& request, uint32_t object);
// Bound of one object in a format. Where all of it stays within `enough`, a bound that need not be the least.
double vertexPixels(const Scene& scene, const RenderRequest& request, uint32_t object, Precision precision, double enough);
std::string quotedObject(const Scene& scene, uint32_t object);  // "'terrain'", or "object 3" without a name
std::string upTo(double pixels);                                // "up to 3.1 px", or "any distance"
// Warning for people.
std::string sentenceOf(const Scene& scene, const VertexError& error);

}  // namespace plumb
