// SPDX-License-Identifier: MIT
// Margins of a scene: how far each extreme can be driven before the picture's error against its truth passes a budget.
#pragma once

#include "pipeline/choices/budget.h"
#include "pipeline/planner/check.h"
#include "pipeline/stress/axes.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace plumb::stress {

// Budget where nobody states one: the limits that are not set get these values. A limit of wrong faces is always there.
inline constexpr double kDefaultP99 = 1, kDefaultWrong = 0.005;
ErrorBudget budgetOr(const ErrorBudget& stated);
// Pixels below which a picture says nothing of a budget: one wrong face among them would already pass its share.
uint64_t leastPixels(const ErrorBudget& budget);

// What came of a picture.
enum class Outcome {
    within,   // the error keeps the budget
    beyond,   // it does not
    few,      // fewer pixels show something than can tell
    refused,  // no picture is drawn: `why` is the refusal
    open      // the truth's own bound says too little
};
const char* nameOf(Outcome outcome);

struct Tried {
    double value = 0;
    Outcome outcome = Outcome::within;
    BudgetFigures figures;  // of within, beyond and open
    bool raised = false;    // the plan takes more than float32 for some object
    std::string why;        // of beyond, where no figure tells: "linear is inf"; of refused and open
};

// How an axis ends.
enum class End {
    breaks,  // beyond from `margin` on
    holds,   // within up to `margin`, beyond which nothing can be told: `why`
    passed,  // the scene itself is beyond: within only on the mild side of `margin`
    other,   // the scene itself is beyond, and this axis brings it no nearer
    cut      // no time was left
};
const char* nameOf(End end);

// Margin of an axis in one arithmetic. Pictures were drawn at half of `margin` (within) and at two and four times it (beyond), as far as the
// axis reaches; of an axis that falls, at twice and at a half and a quarter.
struct Margin {
    End end = End::cut;
    double margin = 0;            // within on its mild side
    double beyond = 0;            // of breaks and passed: the nearest value that was drawn on the other side
    std::string why;              // of holds: what ends the axis
    std::vector<double> islands;  // values on the mild side of the margin at which the error passes the budget all the same
    std::vector<Tried> tried;     // every picture of the axis, in the order in which they were drawn
};

struct AxisMargin {
    const AxisRow* axis = nullptr;
    std::string absent;             // reason why the axis does not apply; else the next fields hold
    std::optional<double> present;  // value in the scene as it is
    Margin margin;                  // of pictures as they are planned
    std::optional<Margin> float32;  // of float32 alone; none for a picture that has no such choice
};

struct StressReport {
    ErrorBudget budget;
    Tried itself;  // the scene as it is
    std::vector<AxisMargin> axes;
    uint64_t pictures = 0;  // that were drawn
    double totalMs = 0;
    bool beyond() const { return itself.outcome == Outcome::beyond; }
};

struct StressPlan {
    std::vector<const AxisRow*> axes;
    ErrorBudget budget;       // budgetOr()
    double limitMs = 120000;  // axes that it leaves no time for are cut
    bool float32 = true;      // also with float32 alone
    std::function<RenderResult(const Scene&, const RenderRequest&)> draw;
    std::function<void(double)> onProgress;  // 0..1; may throw
};

// Finds the margins. Throws Error(usage) for a picture that has no truth, or that shows fewer than leastPixels() pixels.
StressReport findMargins(const Picture& picture, const StressPlan& plan);

}  // namespace plumb::stress
