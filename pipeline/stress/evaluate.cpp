// SPDX-License-Identifier: MIT
#include "pipeline/stress/evaluate.h"

#include "host/error.h"
#include "pipeline/scene/check_scene.h"
#include "pipeline/truth/frame_error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace plumb::stress {
namespace {

// Largest bound of the truth's own error, in steps, at which its colour still tells an error of a step. Pixels beyond it are open.
constexpr double kTellingSteps = 0.25;

// True when the truth's bounds leave more pixels open than the budget lets be wrong: the error is then no fact.
bool isOpen(const Truth& truth, const ErrorBudget& budget) {
    uint64_t open = 0, seen = 0;
    for (size_t at = 0; at < truth.object.size(); ++at) {
        if (truth.object[at] == kNone && truth.alpha[at] == 0) continue;
        ++seen;
        bool tells = truth.decided[at] != 0;
        for (size_t c = 0; c < 3; ++c) {
            const double colour = truth.linear[3 * at + c], bound = truth.bound[3 * at + c];
            tells &= colour - bound >= 1 || srgbCodeError(colour, bound) <= kTellingSteps;  // brighter than 1 is the last code, surely
        }
        open += !tells;
    }
    return double(open) > *budget.wrongLimit() * double(seen);
}

// True when float32 alone draws the same picture: the plan took nothing more.
bool sharedWith(const Tried& planned) { return planned.outcome != Outcome::refused && !planned.raised; }

}  // namespace

Evaluator::Evaluator(const Picture& picture, const StressPlan& plan) : picture_(picture), plan_(plan) {}

double Evaluator::elapsedMs() const { return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_).count(); }

bool Evaluator::late() const { return elapsedMs() > plan_.limitMs; }

const Tried& Evaluator::itself(bool float32) {
    std::optional<Tried>& known = itself_[float32 ? 1 : 0];
    if (known) return *known;
    if (float32 && itself_[0] && sharedWith(*itself_[0])) return *(known = itself_[0]);
    Picture same = picture_;
    same.request.knobs.float32Only = float32;
    return *(known = judge(same));
}

const Tried& Evaluator::at(const AxisRow& axis, double value, bool float32) {
    const std::tuple key(&axis, value, float32);
    if (const auto found = known_.find(key); found != known_.end()) return found->second;
    if (float32)
        if (const auto planned = known_.find({&axis, value, false}); planned != known_.end() && sharedWith(planned->second))
            return known_.emplace(key, planned->second).first->second;
    Picture moved = picture_;
    moved.request.knobs.float32Only = float32;
    axis.move(moved, value);
    Tried tried = judge(moved);
    tried.value = value;
    return known_.emplace(key, std::move(tried)).first->second;
}

Tried Evaluator::judge(const Picture& moved) {
    Tried tried;
    RenderRequest request = moved.request;
    request.planes |= kCheckedPlanes;
    ++pictures_;
    RenderResult result;
    try {
        checkScene(moved.scene);
        result = plan_.draw(moved.scene, request);
    } catch (const Error& error) {
        if (error.exit() != Exit::input && error.exit() != Exit::usage) throw;
        tried.outcome = Outcome::refused;
        tried.why = error.what();
        return tried;
    }
    tried.raised = std::any_of(result.plan.raised.begin(), result.plan.raised.end(),
                               [](const Plan::Raise& raise) { return raise.what == "precision"; });
    const Checker checker(moved.scene, request, {}, request.onProgress);
    try {
        tried.figures = checker.of(result.frame);
    } catch (const Error& error) {
        if (error.exit() != Exit::failed) throw;
        tried.outcome = Outcome::beyond;  // NaN or infinity in a drawn pixel
        tried.why = error.what();
        return tried;
    }
    if (tried.figures.pixels < leastPixels(plan_.budget))
        tried.outcome = Outcome::few;
    else if (isOpen(checker.truth(), plan_.budget))
        tried.outcome = Outcome::open;
    else
        tried.outcome = keeps(tried.figures, plan_.budget) ? Outcome::within : Outcome::beyond;
    return tried;
}

}  // namespace plumb::stress
