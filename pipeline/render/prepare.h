// SPDX-License-Identifier: MIT
// Input of the passes for a scene and a request, and the plan that says what was left out and why.
#pragma once

#include "pipeline/passes/fill.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb {

struct DropRow;

// Parts of the trace pass that a picture takes; the plan leaves out those that no ray needs.
struct RayParts {
    bool mirrors = true, passes = true;  // mirrored and refracted rays are sent on
    bool shadows = true;                 // shadow rays meet something
};

struct Prepared {
    DrawList list;
    FillChoices choices;                       // planes, prior, wide and colour are set by the renderers
    uint32_t width = 0, height = 0, side = 1;  // picture; samples a pixel = side * side
    float near = 0;                            // near plane in scene units; the passes' own is list.viewport.near, in [1, 2)
    double unit = 1;                           // the passes' lengths per unit of the scene, a power of two
    uint32_t background = 0;                   // encoded colour of a sample where nothing is drawn
    glm::vec3 backgroundLinear{0};
    uint32_t undrawn = 0;  // encoded pixel of which no sample is drawn, as resolving leaves it
    glm::vec3 undrawnLinear{0};
    glm::vec3 rayOrigin{0}, rayX{0}, rayY{0};  // direction to sample (x, y): rayOrigin + rayX x + rayY y; shading takes those of `list`
    RayParts rays;                             // traced pictures
    bool nothingCrosses = false;               // true when no triangle is cut: the plan has no step for it
    std::vector<const DropRow*> leftOut;       // of each object of the scene, the drop that leaves it out, or null
    Plan plan;
    RenderCounters counters;  // set are objects, vertices and triangles
};

// Prepares a picture by the technique that draws the request (technique.h). Throws Error(usage) for what that does not have, and
// Error(input) for a scene beyond the stated limits. Only the plan's steps depend on the side.
Prepared prepare(const Scene& scene, const RenderRequest& request, RunsOn side = RunsOn::device);

}  // namespace plumb
