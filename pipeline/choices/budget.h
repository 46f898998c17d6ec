// SPDX-License-Identifier: MIT
// Error budget of a picture: the most that its error may be against the truth, one limit a metric (docs/budgets.md).
#pragma once

#include "pipeline/choices/choice.h"
#include "pipeline/choices/choices.h"

#include <optional>
#include <string>
#include <string_view>

namespace plumb {

struct ErrorBudget {
    // Steps of the sRGB code (1/255 of full scale), a pixel's largest channel; rms over all channels.
    std::optional<double> max, p99, rms;
    // Share of the pixels that show something and may show another face than the truth. Unstated beside `max`: kWrongUnstated.
    std::optional<double> wrong;

    // Share of wrong faces that `max` allows where nobody states it: at an edge, a snapped vertex may cost the whole scale.
    static constexpr double kWrongUnstated = 0.001;

    bool empty() const { return !max && !p99 && !rms && !wrong; }
    std::optional<double> wrongLimit() const { return wrong || !max ? wrong : std::optional(kWrongUnstated); }
};

using BudgetMember = std::optional<double> ErrorBudget::*;
// Metrics, the first where none is named.
inline constexpr Choice<BudgetMember> kErrorMetrics[] = {
    {"max", &ErrorBudget::max, "largest error where the truth decides the face beyond the snap of vertices, in steps of 1/255"},
    {"p99", &ErrorBudget::p99, "error that 99 of 100 pixels keep, in steps of 1/255"},
    {"rms", &ErrorBudget::rms, "root mean square over all channels, in steps of 1/255"},
    {"wrong", &ErrorBudget::wrong, "share of pixels that show another face than the truth"},
};

// Adds "E", "E:METRIC" or several of them by commas: a number of steps, or N/255; for wrong a share or a percentage. Throws Error(usage), one
// line, for a metric that does not exist, a number that is none, and a metric that has a limit already.
void addErrorBudget(ErrorBudget& budget, std::string_view text);

// Throws Error(usage) for a limit below what rounding to bytes costs by itself, with the least that can be asked for.
void refuseBelowRounding(const ErrorBudget& budget, Encoding encoding);

// "max 2, wrong 0.1 %", every limit, also the one that max implies.
std::string wordsOf(const ErrorBudget& budget);

}  // namespace plumb
