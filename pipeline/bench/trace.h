// SPDX-License-Identifier: MIT
// Rays on the device against others that trace the same ones, interleaved in one process: the same algorithm in plain C++, and Embree where the
// build found it. Nothing is uploaded within a time, and both sides end with their result in memory of the host.
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
    std::string theirs;    // "C++, 2 threads"
    uint64_t objects = 0;  // spheres, or triangles
    uint32_t width = 0, height = 0;
    uint64_t rays = 0, feelers = 0;  // of a picture of ours
    Spread oursMs, theirsMs;
    Spread ratio;  // theirs / ours of each pair; above 1 ours is faster
    double ratioOfLeast = 0;
    uint64_t differ = 0;           // pixels that disagree: more than 4 levels of a channel, or another triangle
    double allowed = 0;            // share of them that may
    std::string failure;           // empty: they agree
    double longestDispatchMs = 0;  // about: time of a picture / its dispatches
};
// Their arithmetic is not ours: at a silhouette, the edge of a square or of a shadow the two see different things. No bound is proved; a picture
// of something else differs nearly everywhere.
inline constexpr double kTraceShare = 0.01;

struct TraceBenchOptions {
    uint32_t width = 1920, height = 1080;
    uint32_t pairs = 50, threads = 0;  // of theirs; 0: all
    double watchdogMs = 60000;
    std::function<void(double)> onProgress;  // 0..1; may throw
};

std::vector<std::string> traceBenchNames();  // spheres4, spheres20, mesh1e5, mesh1e6
// Spheres: one row. Meshes: a row for each way of Embree's; none, and `absent` says why, when the build had no Embree.
// Empty `name`s of the list above only; others throw Error(usage).
std::vector<TraceRow> benchTrace(Device& device, const std::string& name, const TraceBenchOptions& options,
                                 std::vector<std::string>& absent);

}  // namespace plumb
