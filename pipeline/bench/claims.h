// SPDX-License-Identifier: MIT
// Performance claims P1 to P4 and P6 to P9 of the lecture notes as tables: counts, and times on a device here. The ways of a table take
// turns.
#pragma once

#include "pipeline/bench/statistics.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

struct ClaimWay {
    std::string name;
    std::vector<std::pair<std::string, uint64_t>> counts;
    Spread ms;
    Spread ratio;  // this way / the first way, of each round; 1 for the first
};

struct ClaimTable {
    std::string claim;     // "P6"
    std::string says;      // the claim, in one sentence
    std::string measured;  // what was measured and how, in one sentence
    std::vector<ClaimWay> ways;
    std::string failure;  // a count that contradicts the claim; empty: none. Times are reported, never judged
};

struct ClaimOptions {
    uint32_t width = 1920, height = 1080;
    uint32_t rounds = 50;  // at least 3
    double watchdogMs = 60000;
    std::function<void(double)> onProgress;  // 0..1; may throw
};

// Runs the ways of a table in turn, a different one first each round, and fills in their times and ratios.
void takeTurns(ClaimTable& table, const std::vector<std::function<void()>>& works, const ClaimOptions& options);

// Tables of P1 to P4, on points of their own.
std::vector<ClaimTable> benchTransformClaims(Device& device, const ClaimOptions& options);
// Tables of P6 to P9. `scene` is complete (camera, lights) and holds one closed convex mesh, which P8 is about.
std::vector<ClaimTable> benchClaims(Device& device, const Scene& scene, const ClaimOptions& options);

}  // namespace plumb
