// SPDX-License-Identifier: MIT
// Ways to draw one scene that a planner chooses among.
#pragma once

#include "pipeline/render/render.h"

#include <string>
#include <vector>

namespace plumb {

// Choices that somebody stated, which stay as they are.
struct Pinned {
    bool shading = false, samples = false, maxDepth = false, minWeight = false;
    std::vector<const TradeAxis*> trade;
    bool binary64 = true;  // false: what draws has no binary64, and no choice of it
};

struct Candidate {
    RenderRequest request;
    std::string words;  // "phong, specular=schlick": what differs from the most accurate
};

// Products of the choices of every axis that can make a picture by `base` cheaper or more accurate, without those that draw the same bytes with
// the same work. The device's own functions (Verdict::bounded) are none: a budget of errors gives no bytes away. Choices of depth and subpixel
// are none: they cost as much as the default and are less accurate. Numbers of samples are choices only with `samples`.
//   Raster: shading, specular, light-vector, interpolation, normals, rate; transform where float32 may move a vertex (vertex_error.h).
//   Rays: depth and cutoff, where a material asks for rays.
// Throws Error(usage) for a picture that has no truth or no such choices: wire frames and --fill notes.
std::vector<Candidate> candidatesOf(const Scene& scene, const RenderRequest& base, const Pinned& pinned, bool samples);

}  // namespace plumb
