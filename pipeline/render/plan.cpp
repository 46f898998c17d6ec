// SPDX-License-Identifier: MIT
#include "pipeline/render/plan.h"

#include "host/error.h"

#include <fmt/core.h>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

namespace {

template <class Steps>
auto find(Steps& steps, const std::string& name) {
    return std::find_if(steps.begin(), steps.end(), [&](const PlanStep& s) { return s.name == name; });
}

}  // namespace

const char* nameOf(RunsOn side) {
    switch (side) {
        case RunsOn::device:
            return "device";
        case RunsOn::twin:
            return "twin";
        case RunsOn::host:
            break;
    }
    return "host";
}

std::vector<std::string> Plan::names() const {
    std::vector<std::string> all;
    for (const PlanStep& step : steps) all.push_back(step.name);
    return all;
}

void Plan::add(PlanStep step) {
    if (find(steps, step.name) == steps.end()) steps.push_back(std::move(step));
}

std::vector<std::string> Plan::labels(RunsOn side) const {
    std::vector<std::string> own;
    for (const PlanStep& step : steps)
        if (step.side == side && step.fusedIn.empty()) own.push_back(step.name);
    return own;
}

void Plan::skip(const std::string& name, const std::string& why) {
    if (const auto step = find(steps, name); step != steps.end()) step->idle = why;
}

void Plan::close(const std::vector<PassTime>& times) {
    for (const PassTime& time : times) {
        if (time.dispatches == 0) continue;  // the time of a whole submission
        const auto step = find(steps, time.pass);
        if (step == steps.end() || !step->fusedIn.empty())
            throw renderError(fmt::format("plan: '{}' ran and is no step of the plan", time.pass));
        step->ran = true;
        step->idle.clear();
    }
    for (PlanStep& step : steps) {
        if (!step.fusedIn.empty()) {
            const auto host = find(steps, step.fusedIn);
            if (host == steps.end())
                throw renderError(fmt::format("plan: '{}' is fused in '{}', which is no step", step.name, step.fusedIn));
            step.ran = host->ran;
            step.idle = host->idle;
        }
        if (!step.ran && step.idle.empty())
            throw renderError(fmt::format("plan: the step '{}' neither ran nor had nothing to do", step.name));
    }
}

}  // namespace plumb
