// SPDX-License-Identifier: MIT
// Number format in which the vertices of each object are transformed: the cheapest whose bound holds in this view (docs/requires.md).
#pragma once

#include "pipeline/render/render.h"

#include <cstdint>
#include <vector>

namespace plumb {

// Error of visible parts above which an object is transformed in more than float32, in pixels. Half of it is still below half a pixel.
inline constexpr double kRaisePixels = 0.25;

// Number format in which the vertices of an object are transformed.
struct VertexArithmetic {
    Precision precision = Precision::fp32;
    bool raised = false;     // true when float32 does not do here
    uint32_t with = kNone;   // raised: object of the scene with the same matrix that asks for it; kNone: this one does
    double usualPixels = 0;  // bound of float32; a bound that need not be the least where it is below kRaisePixels
    double pixels = 0;       // bound of `precision`
};

// Formats of all objects of the scene: what the request states, else the cheapest that keeps kRaisePixels, else the best.
std::vector<VertexArithmetic> vertexArithmetic(const Scene& scene, const RenderRequest& request);
std::vector<Precision> precisionsOf(const std::vector<VertexArithmetic>& all);
const char* wordOf(Precision precision);  // "block-scaled integers"
// The line of the plan for an object that is raised.
Plan::Raise raiseOf(const Scene& scene, uint32_t object, const VertexArithmetic& chosen);

}  // namespace plumb
