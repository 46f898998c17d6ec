// SPDX-License-Identifier: MIT
#include "pipeline/stress/stress.h"

#include "host/error.h"
#include "pipeline/render/technique.h"
#include "pipeline/stress/search.h"

#include <fmt/core.h>
#include <cmath>
#include <cstddef>
#include <utility>

namespace plumb::stress {

ErrorBudget budgetOr(const ErrorBudget& stated) {
    ErrorBudget budget = stated;
    if (budget.empty()) budget.p99 = kDefaultP99;
    if (!budget.wrong) budget.wrong = stated.empty() ? kDefaultWrong : stated.wrongLimit().value_or(kDefaultWrong);
    return budget;
}

uint64_t leastPixels(const ErrorBudget& budget) {
    const double limit = budget.wrongLimit().value_or(1);
    return limit > 0 ? uint64_t(std::ceil(1 / limit)) : 1;
}

const char* nameOf(Outcome outcome) {
    static constexpr const char* kNames[] = {"within", "beyond", "few", "refused", "open"};
    return kNames[size_t(outcome)];
}

const char* nameOf(End end) {
    static constexpr const char* kNames[] = {"breaks", "holds", "passed", "other", "cut"};
    return kNames[size_t(end)];
}

StressReport findMargins(const Picture& picture, const StressPlan& plan) {
    const Technique& technique = techniqueOf(picture.scene, picture.request);
    if (!technique.showsSurfaces()) throw usageError("--shading: a wire frame has no truth that its error could be taken against");
    refuse(picture.scene, picture.request);
    StressReport report;
    report.budget = plan.budget;
    Evaluator evaluator(picture, plan);
    report.itself = evaluator.itself(false);
    const Tried& itself = report.itself;
    if (itself.outcome == Outcome::refused) throw Error(Exit::input, itself.why);
    if (itself.outcome == Outcome::few)
        throw usageError(fmt::format(
            "the picture shows {} pixels of the scene, and {} are the fewest that tell whether {} are kept: give a larger --size",
            itself.figures.pixels, leastPixels(plan.budget), wordsOf(plan.budget)));
    if (itself.outcome == Outcome::open)
        throw usageError("the truth's own bound leaves too many pixels of this picture open: nothing can be told");
    const bool chooses =
        plan.float32 && technique.vertices == Technique::Vertices::transformPass && picture.request.trade.precision == Precision::fp32;
    const auto rows = double(plan.axes.size());
    for (size_t i = 0; i < plan.axes.size(); ++i) {
        const auto step = [&](double share) {
            if (plan.onProgress) plan.onProgress((double(i) + share) / rows);
        };
        AxisMargin axis;
        axis.axis = plan.axes[i];
        axis.absent = axis.axis->absent(picture);
        if (axis.absent.empty()) {
            axis.present = axis.axis->present(picture);
            axis.margin = sweep(evaluator, picture, *axis.axis, false, [&](double s) { step(chooses ? s / 2 : s); });
            if (chooses) axis.float32 = sweep(evaluator, picture, *axis.axis, true, [&](double s) { step((1 + s) / 2); });
        }
        report.axes.push_back(std::move(axis));
    }
    report.pictures = evaluator.pictures();
    report.totalMs = evaluator.elapsedMs();
    return report;
}

}  // namespace plumb::stress
