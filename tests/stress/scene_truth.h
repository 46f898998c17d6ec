// SPDX-License-Identifier: MIT
// A drawn picture against the truth, pixel by pixel, away from edges: no depth and no colour is further off than float32 and the snapping of vertices to
// 1/256 px can make it. Phong by the exact fill with the default choices, or rays; one sample a pixel.
#pragma once

#include "pipeline/render/render.h"

#include <cstdint>
#include <string>

namespace plumb::test {

struct TruthReport {
    uint64_t pixels = 0;  // judged
    // Beside an edge, or where the bound leaves open which surface is seen or whether light falls on it; of rays, what any ray of the pixel meets.
    uint64_t left = 0;
    double worst = 0;   // largest error in shares of its bound
    std::string fault;  // the first pixel beyond its bound, or empty
};

// `frame` has every plane. A scene with a triangle that is clipped is not judged.
TruthReport holdAgainstTruth(const Scene& scene, const RenderRequest& request, const Frame& frame);
// Traced pictures, by one ray through the middle of each pixel, without noise.
TruthReport holdRaysAgainstTruth(const Scene& scene, const RenderRequest& request, const Frame& frame);

}  // namespace plumb::test
