// SPDX-License-Identifier: MIT
// Comparison of rays on the device with other tracers of the same rays, interleaved in one process: the same algorithm in plain C++, and
// Embree where the build found it. No upload is within a time, and both sides end with their result in memory of the host.
#pragma once

#include "pipeline/bench/statistics.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace plumb {

struct TraceRow {
    std::string name;      // "spheres4", "mesh1e5 embree", "mesh1e5 embree-robust"
    std::string theirs;    // name of the other side: "C++, 2 threads"
    uint64_t objects = 0;  // spheres, or triangles
    uint32_t width = 0, height = 0;
    uint64_t rays = 0, shadowRays = 0;  // rays of one picture of the device
    Spread oursMs, theirsMs;
    Spread ratio;  // theirs / ours of each pair; above 1 ours is faster
    double ratioOfLeast = 0;
    uint64_t differ = 0;           // pixels that disagree: more than 4 levels of a channel, or another triangle
    double allowed = 0;            // share of pixels that may disagree
    std::string failure;           // empty: they agree
    double longestDispatchMs = 0;  // estimate: time of a picture / its dispatches
};
// Share of pixels that may disagree. The arithmetic of the sides differs: at a silhouette, the edge of a square or of a shadow they see
// different things. No bound is proved; a picture of something else differs nearly everywhere.
inline constexpr double kTraceShare = 0.01;

struct TraceBenchOptions {
    uint32_t width = 1920, height = 1080;
    uint32_t pairs = 50, threads = 0;  // threads of the other side; 0: all
    double watchdogMs = 60000;
    std::function<void(double)> onProgress;  // 0..1; may throw
};

std::vector<std::string> traceBenchNames();  // spheres4, spheres20, mesh1e5, mesh1e6
// Compares one scene of the list above; another name throws Error(usage). Spheres: one row. Meshes: a row for each way of Embree's; none,
// and `absent` says why, when the build had no Embree.
std::vector<TraceRow> benchTrace(Device& device, const std::string& name, const TraceBenchOptions& options,
                                 std::vector<std::string>& absent);

}  // namespace plumb
