// SPDX-License-Identifier: MIT
// Planner: the cheapest choices that keep an error budget, or the most accurate that a time allows (docs/budgets.md). What a probe promises is
// checked on the finished picture; the check decides.
#pragma once

#include "pipeline/choices/budget.h"
#include "pipeline/planner/candidates.h"
#include "pipeline/planner/check.h"
#include "pipeline/planner/probe.h"
#include "pipeline/planner/work.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace plumb {

struct PlannerRequest {
    RenderRequest base;  // what is asked for; its choices that are not pinned may change
    Pinned pinned;
    ErrorBudget error;
    std::optional<double> timeMs;  // most that the picture may take
    UnitCosts costs = nominalCosts();
    double twinRay = 0;             // processor nanoseconds of the twin for a ray of the calibration; 0: rays cost the same in every scene
    double checkShare = 10;         // the truth may cost so many times the picture before a sample of its pixels is checked
    std::optional<double> checkMs;  // overrides checkShare
    const Checker* checker = nullptr;  // truth of `base`, for several budgets of one picture; null: it is made where it is needed
    uint64_t probePixels = 160 * 120;
    double probedRays = 4e6;    // followed by all probes of a traced picture
    double estimateFactor = 1;  // by which estimates of errors are multiplied; 1 but for tests
    // Called now and then with a share of the planning and checking; false cancels with Error(interrupted).
    std::function<bool(double)> onProgress;
};

// A choice that was weighed.
struct Weighed {
    std::string words;
    Work work;
    double costMs = 0;                  // predicted
    std::optional<Estimate> error;      // by the probe
    std::optional<ProvedErrors> bound;  // of a choice that was probed, where no picture was drawn
    std::optional<BudgetFigures> got;   // of the finished picture; none: it was not drawn
    std::optional<double> tookMs;       // with a time budget; none: it was not drawn
    bool kept = false;                  // true: what was drawn keeps the budget
};

struct PlannedPicture {
    Candidate chosen;
    std::vector<Weighed> weighed;                 // every choice, by rising cost; one for which nothing was probed has no error
    size_t index = 0;                             // of `chosen` in `weighed`
    std::vector<std::string> why;                 // sentences: what was dropped or raised, and why
    std::vector<RenderCounters::RayCounts> rays;  // predicted for `chosen`
    uint32_t shrink = 1;                          // of the probe
    double planMs = 0;
};

struct CheckedPicture {
    PlannedPicture plan;
    RenderResult result;  // of `plan.chosen`, with the planes that were asked for
    BudgetFigures got;
    bool certified = false;  // every pixel was checked
    uint64_t checkedPixels = 0;
    std::vector<Weighed> tried;  // pictures that were drawn, in their order; the last is the chosen one
    double truthMs = 0, triedMs = 0;
};

// Draws a picture of the scene, on whatever draws it.
using DrawPicture = std::function<RenderResult(const Scene&, const RenderRequest&)>;

// Chooses, and draws nothing but probes. Throws Error(budget), one sentence with the best that there is, where no choice keeps the budget by
// the probes; Error(usage) for a request that has no truth.
PlannedPicture planPicture(const Scene& scene, const PlannerRequest& request);

// Chooses, draws, and checks the picture against the truth; one that does not keep the budget is drawn again by the next choice. Needs an error
// budget. The checked picture is the result, and its time is that of a picture with the planes of the check; with a time budget, the picture is
// drawn once more as it was asked for. Throws Error(budget) where no choice keeps it, after all that could have were drawn.
CheckedPicture drawWithinError(const Scene& scene, const PlannerRequest& request, const DrawPicture& draw);

// Chooses, and draws the most accurate picture within the time. One that took longer is drawn once more, since the first may have made
// kernels; then the prediction is corrected by what it took, and the next choice is drawn. Needs a time and no error budget. Throws
// Error(budget) where no choice is done in time.
CheckedPicture drawWithinTime(const Scene& scene, const PlannerRequest& request, const DrawPicture& draw);

// Predicted work and time of `base` as it is, without any budget.
PlannedPicture predictPicture(const Scene& scene, const PlannerRequest& request);

}  // namespace plumb
