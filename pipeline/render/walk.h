// SPDX-License-Identifier: MIT
// Walk over the steps of a plan on the host. The plan says which run, and in which order.
#pragma once

#include "pipeline/render/plan.h"
#include "pipeline/render/stopwatch.h"

#include <functional>
#include <span>
#include <string_view>
#include <vector>

namespace plumb {

struct StepBody {
    std::string_view name;
    std::function<void()> run;
};

// Runs those of `bodies` that are steps of the plan, in the plan's order, each timed by its name. Steps that are fused in another are passed
// by, and steps without a body, which belong to another phase. Plan::close() refuses a picture in which one was forgotten.
inline void walk(const Plan& plan, std::vector<PassTime>& times, std::span<const StepBody> bodies) {
    for (const PlanStep& step : plan.steps) {
        if (!step.fusedIn.empty()) continue;
        for (const StepBody& body : bodies) {
            if (body.name != step.name) continue;
            const Stopwatch watch(&times, step.name.c_str());
            body.run();
        }
    }
}

}  // namespace plumb
