// SPDX-License-Identifier: MIT
// Comparison of the passes with the device's own graphics pipeline: the same scene, camera, size and Phong shading, interleaved in one
// process.
// Both sides keep the scene on the device and end when the picture lies in memory of the host.
#pragma once

#include "pipeline/bench/statistics.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace plumb {

// Agreement of the two pictures. Coverage must agree but for pixels whose centre lies within kSnapPixels of a projected edge: both sides
// round corners to 1/256 pixel, each by at most half of it in x and in y.
struct Agreement {
    uint64_t pixels = 0, covered = 0;
    uint64_t coverageDiffers = 0;  // drawn by one side only
    uint64_t unexplained = 0;      // such pixels further than kSnapPixels from every edge
    double furthestPixels = 0;     // largest distance of such a pixel from the nearest edge
    int colourMost = 0;            // levels, over pixels that both drew
    uint64_t colourOver4 = 0;      // pixels with a channel that differs by more than 4 levels
    std::string failure;           // empty: they agree
};
inline constexpr double kSnapPixels = 1.0 / 256;
// Share of pixels whose colours may differ. Colours come from different arithmetic (native pow and root on one side), and at a silhouette
// or a crossing of surfaces from different triangles: no bound is proved. A picture of something else differs nearly everywhere; this share
// is far from both.
inline constexpr double kColourShare = 0.01;

struct RasterRow {
    std::string name;
    uint64_t triangles = 0;
    uint32_t width = 0, height = 0;
    bool resident = false;  // the passes drew in place: nothing uploaded in the loop
    Spread graphicsMs, computeMs;
    Spread ratio;  // graphics / compute of each pair; above 1 the passes win
    double ratioOfLeast = 0;
    RenderCounters counters;
    std::vector<PassTime> passes;  // medians of a few pictures drawn pass by pass
    Agreement agreement;
};

struct RasterOptions {
    uint32_t width = 1920, height = 1080;
    uint32_t pairs = 50;
    double watchdogMs = 60000;
    std::function<void(double)> onProgress;  // 0..1; may throw
};

// Compares one scene, complete with camera and lights. Throws Error(device) when the device has no graphics pipeline, Error(input) for a
// scene that the baseline cannot draw (more than 4 lights).
RasterRow benchRaster(Device& device, const Scene& scene, const std::string& name, const RasterOptions& options);

// Times of the passes alone, for how their cost grows: `pairs` pictures of one scene, one after another. Any number of lights.
struct PassesRow {
    std::string name;
    uint64_t triangles = 0, lights = 0;
    uint32_t width = 0, height = 0;
    bool resident = false;
    Spread ms;
    RenderCounters counters;
    std::vector<PassTime> passes;
};
PassesRow benchPasses(Device& device, const Scene& scene, const std::string& name, const RasterOptions& options);

}  // namespace plumb
