// SPDX-License-Identifier: MIT
// Check of a finished picture against the truth: of all pixels, or of a random sample of them.
#pragma once

#include "pipeline/choices/budget.h"
#include "pipeline/truth/frame_error.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace plumb {

// Error figures that a budget is about, in its units.
struct BudgetFigures {
    double max = 0, p99 = 0, rms = 0, wrong = 0;
    uint32_t x = 0, y = 0;     // pixel of max
    uint64_t pixels = 0;       // that show something, of those that were checked
    uint64_t wrongPixels = 0;  // of another face
    uint64_t undecided = 0;    // pixels that max leaves out
};
BudgetFigures figuresOf(const FrameError& error);
// Largest figure as a share of its limit: at most 1 where the budget is kept. NaN and infinity keep none.
double excessOf(const BudgetFigures& figures, const ErrorBudget& budget);
inline bool keeps(const BudgetFigures& figures, const ErrorBudget& budget) { return excessOf(figures, budget) <= 1; }

// Pixels to check: every one, or a random sample.
struct CheckPlan {
    uint64_t sampled = 0;  // 0: every pixel is checked
    uint64_t seed = 1;
};

// Truth of one picture, for as many frames of it as are tried.
class Checker {
public:
    // `request`: size, samples and shading of the picture. Scene must outlive it. `progress`: share of the truth; false cancels.
    Checker(const Scene& scene, const RenderRequest& request, const CheckPlan& plan, std::function<bool(double)> progress = {});
    // Figures of a frame with kPlaneLinear, kPlaneDepth, kPlaneObject and kPlanePrimitive.
    BudgetFigures of(const Frame& frame) const;
    FrameError errorOfFrame(const Frame& frame) const;
    // Pixels that the largest error is taken over, one value a pixel; empty: all of them.
    std::vector<uint8_t> decidedIn(const Frame& frame) const;
    bool everyPixel() const { return wanted_.empty(); }
    uint64_t checkedPixels() const { return checked_; }
    double ms() const { return truth_.timeMs; }
    const Truth& truth() const { return truth_; }

private:
    RenderRequest request_;
    std::vector<uint8_t> wanted_, decided_;
    uint64_t checked_ = 0;
    Truth truth_;
};

// Planes that a check needs.
inline constexpr uint32_t kCheckedPlanes = kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive;

// Upper bound of a share of which `found` of `sampled` were met, with 95 % confidence: Clopper and Pearson's, 3/n for none (the rule of three).
double shareBelow(uint64_t found, uint64_t sampled);
// Lower bound of it with the same confidence; 0 for none.
double shareAbove(uint64_t found, uint64_t sampled);

}  // namespace plumb
