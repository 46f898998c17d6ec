// SPDX-License-Identifier: MIT
// Common parts of the reports of all benchmarks.
#pragma once

#include "pipeline/bench/statistics.h"
#include "pipeline/cli/options.h"
#include "pipeline/cli/progress.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/report.h"
#include "pipeline/library/renderer.h"

#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

namespace plumb {

inline Json spreadJson(const Spread& s) {
    return {{"median", s.median}, {"p10", s.p10}, {"p90", s.p90}, {"least", s.least}, {"count", s.count}};
}

inline Json benchContextJson(const Renderer& renderer) {
    Json json;
    json["tool"] = toolJson();
    json["host"] = hostJson();
    double load[3] = {0, 0, 0};
    if (::getloadavg(load, 3) == 3) json["host"]["load"] = {load[0], load[1], load[2]};
    json["device"] = deviceJson(renderer);
    return json;
}

// Callback of a running benchmark: moves the bar, and ends the benchmark when interrupted. `progress` must outlive it.
inline std::function<void(double)> tellAndListen(Progress& progress) {
    return [&progress](double done) {
        stopIfInterrupted();
        progress.update(done);
    };
}

Exit benchPlanCommand(const Options& options, Renderer& renderer, std::vector<std::string> rows);
Exit benchTraceCommand(const Options& options, Renderer& renderer, std::vector<std::string> rows);

}  // namespace plumb
