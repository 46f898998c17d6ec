// SPDX-License-Identifier: MIT
#include "pipeline/planner/planner.h"

#include "host/error.h"
#include "pipeline/render/technique.h"

#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <utility>

namespace plumb {
namespace {

// A picture whose estimate does not keep the budget is tried only where it costs less than this share of the next whose does.
constexpr double kWorthTrying = 0.95;
// Samples of the truth that pictures of different numbers of samples are compared with.
constexpr uint32_t kMostSamples = 16;
// Errors that agree to as much are equal: it moves no byte.
constexpr double kSameError = 0.001;
// Pixels of a checked sample: with none found in them, fewer than 0.1 % of all are beyond, with 95 % confidence.
constexpr uint64_t kLeastSample = 3000;
// Pixels of the pilots that tell how many rays a pixel has.
constexpr uint64_t kFirstPilot = 16, kSecondPilot = 256;

// A corrected estimate may be off by a quarter.
constexpr double kLearnt = 0.75;
// Before a budget is given up, what the probe puts beyond it by up to that factor is drawn.
constexpr double kHopeless = 4;
// Figures of the colour, and what rounding to bytes costs of each.
struct Figure {
    double BudgetFigures::*member;
    double rounding;  // steps
};
constexpr Figure kFigures[] = {{&BudgetFigures::max, 0.5}, {&BudgetFigures::p99, 0.495}, {&BudgetFigures::rms, 0.2887}};

double millisecondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

class Planning {
public:
    Planning(const Scene& scene, const PlannerRequest& request, bool samples)
        : scene_(scene),
          request_(request),
          candidates_(candidatesOf(scene, request.base, request.pinned, samples)),
          probe_(scene, request.base, probePixels(), request.estimateFactor, [this] { return tell(); }) {
        for (const Candidate& candidate : candidates_) weighed_.push_back({candidate.words});
        takeCosts();
    }

    size_t size() const { return candidates_.size(); }
    const Candidate& candidate(size_t i) const { return candidates_[i]; }
    std::vector<Weighed>& weighed() { return weighed_; }
    Probe& probe() { return probe_; }

    // By the probe, corrected by what was learnt of pictures that were drawn. Without `learnt` the lower end is not.
    Estimate estimate(size_t i, uint32_t truthSamples = 0, bool learnt = true) {
        Weighed& w = weighed_[i];
        if (!w.error) w.error = probe_.of(candidates_[i], true, truthSamples).error;
        Estimate e = *w.error;
        if (exact()) return e;
        const bool coarse = candidates_[i].request.trade.coarse;
        for (const Figure& f : kFigures) {
            const std::optional<double>& ratio = ratiosOf(i).of[size_t(&f - kFigures)];
            double &middle = e.middle.*f.member, &low = e.low.*f.member;
            if (coarse) low /= probe_.shrink();  // neighbours of the probe lie so many pixels apart
            if (!ratio || middle <= f.rounding) continue;
            middle = f.rounding + (middle - f.rounding) * *ratio;
            if (learnt) low = std::max(low, kLearnt * middle);
        }
        // Which faces are wrong hangs on snapped vertices, which are others in the probe and the same for every choice.
        e.middle.wrong = e.low.wrong = wrong_.value_or(0);
        return e;
    }
    // Takes the proved bounds of all choices that were probed.
    void prove(uint32_t truthSamples) {
        for (size_t i = 0; i < size(); ++i)
            if (weighed_[i].error) weighed_[i].bound = probe_.provedOf(candidates_[i], truthSamples);
    }
    // True when the probe is the picture.
    bool exact() const { return probe_.shrink() == 1; }
    // True when a picture of the same kind was drawn.
    bool learntOf(size_t i) { return ratiosOf(i).known; }
    // Takes what a drawn picture had of each figure beside its estimate, for estimates of the same kind.
    void learn(size_t i, double wrong) {
        const Weighed& w = weighed_[i];
        Ratios& ratios = ratiosOf(i);
        ratios.known = true;
        wrong_ = wrong;
        for (const Figure& f : kFigures) {
            const double estimated = w.error->middle.*f.member, got = (*w.got).*f.member;
            // An estimate of little more than rounding says nothing of the rest.
            if (estimated > 2 * f.rounding && got > f.rounding)
                ratios.of[size_t(&f - kFigures)] = (got - f.rounding) / (estimated - f.rounding);
        }
    }
    // The next from `from` on whose estimate keeps the budget; size() for none.
    size_t nextPromising(size_t from) {
        while (from < size() && !keeps(estimate(from).middle, request_.error)) ++from;
        return from;
    }
    bool fits(size_t i) const { return !request_.timeMs || weighed_[i].costMs * slower_ <= *request_.timeMs; }
    double predictedMs(size_t i) const { return weighed_[i].tookMs.value_or(weighed_[i].costMs * slower_); }
    // Takes into account that a picture took so many times what was predicted.
    void correct(double slower) { slower_ = std::max(slower_, slower); }

    PlannedPicture chosen(size_t i) {
        PlannedPicture plan;
        plan.chosen = candidates_[i];
        plan.weighed = weighed_;
        plan.index = i;
        plan.shrink = probe_.shrink();
        plan.rays = probe_.of(candidates_[i], false).rays;
        plan.planMs = millisecondsSince(begin_);
        return plan;
    }

private:
    bool tell() const { return !request_.onProgress || request_.onProgress(0); }

    // Pixels of the probes. Rays have few enough that all probes together follow about `probedRays` of them.
    uint64_t probePixels() const {
        if (!isTraced(request_.base)) return request_.probePixels;
        const auto deeper = [](const Candidate& a, const Candidate& b) {
            return std::pair(a.request.maxDepth, -a.request.minWeight) < std::pair(b.request.maxDepth, -b.request.minWeight);
        };
        const Candidate& deepest = *std::max_element(candidates_.begin(), candidates_.end(), deeper);
        double rays = 1;  // of a pixel
        for (const uint64_t pixels : {kFirstPilot, kSecondPilot}) {
            Probe pilot(scene_, request_.base, pixels, 1, [this] { return tell(); });
            const double scale = double(pilot.shrink()) * pilot.shrink();
            rays = std::max(1.0, raysOf(pilot.counted(deepest).counters) * scale / (double(request_.base.width) * request_.base.height));
            if (rays * double(kSecondPilot) > request_.probedRays) break;
        }
        return std::clamp(uint64_t(request_.probedRays / rays / double(candidates_.size())), kFirstPilot, request_.probePixels);
    }

    // Work of every candidate, and their order by cost. A raster picture of each shading follows from the counts of one; rays are counted.
    void takeCosts() {
        const bool traced = isTraced(request_.base);
        const Counted counted = traced ? Counted{} : countedOnce();
        for (size_t i = 0; i < size(); ++i)
            weighed_[i].work =
                traced ? probe_.of(candidates_[i], false).work : workOf(scene_, candidates_[i].request, counted, probe_.shrink());
        // A ray of this scene, beside one of the calibration's: what the twin took for both.
        UnitCosts costs = request_.costs;
        if (request_.twinRay > 0 && probe_.msPerRay() > 0) costs[Unit::ray] *= 1e6 * probe_.msPerRay() / request_.twinRay;
        for (Weighed& w : weighed_) w.costMs = costOf(w.work, costs);
        std::vector<size_t> order(size());
        std::iota(order.begin(), order.end(), size_t(0));
        std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return weighed_[a].costMs < weighed_[b].costMs; });
        std::vector<Candidate> candidates;
        std::vector<Weighed> weighed;
        for (const size_t i : order) candidates.push_back(std::move(candidates_[i])), weighed.push_back(std::move(weighed_[i]));
        candidates_ = std::move(candidates);
        weighed_ = std::move(weighed);
    }
    Counted countedOnce() { return probe_.counted(candidates_.front()); }

    const Scene& scene_;
    const PlannerRequest& request_;
    const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    std::vector<Candidate> candidates_;
    Probe probe_;
    std::vector<Weighed> weighed_;
    double slower_ = 1;
    struct Ratios {
        bool known = false;
        std::optional<double> of[3];  // by kFigures
    };
    std::optional<double> wrong_;  // of a picture that was drawn
    Ratios& ratiosOf(size_t i) {
        const RenderRequest& request = candidates_[i].request;
        return ratios_[{request.shading, request.trade.coarse}];
    }
    std::map<std::pair<Shading, bool>, Ratios> ratios_;  // by shading; shaded at every pixel, or at one in 2 x 2
};

std::string figuresText(const BudgetFigures& f, const ErrorBudget& budget) {
    std::string text;
    const auto add = [&](const std::optional<double>& limit, const std::string& words) {
        if (limit) text += (text.empty() ? "" : ", ") + words;
    };
    add(budget.max, fmt::format("max {:.3f}", f.max));
    add(budget.p99, fmt::format("p99 {:.3f}", f.p99));
    add(budget.rms, fmt::format("rms {:.3f}", f.rms));
    add(budget.wrongLimit(), fmt::format("wrong {:.3f} %", 100 * f.wrong));
    return text;
}

Error unreachable(const ErrorBudget& budget, const std::string& words, const BudgetFigures& best, const char* how) {
    return Error(Exit::budget,
                 fmt::format("no choice keeps {}{}; the best is '{}': {}", wordsOf(budget), how, words, figuresText(best, budget)));
}

// Cheapest by the probes among those within the time.
size_t cheapestWithin(Planning& planning, const PlannerRequest& request) {
    size_t best = planning.size(), i = planning.nextPromising(0);
    if (i < planning.size()) {
        if (planning.fits(i)) return i;
        throw Error(Exit::budget, fmt::format("'{}' keeps {} and takes about {:.3g} ms, beyond --time {:g} ms", planning.candidate(i).words,
                                              wordsOf(request.error), planning.weighed()[i].costMs, *request.timeMs));
    }
    const auto excess = [&](size_t k) { return excessOf(planning.estimate(k).middle, request.error); };
    for (size_t k = 0; k < planning.size(); ++k)
        if (best == planning.size() || excess(k) < excess(best)) best = k;
    if (planning.fits(best) && keeps(planning.estimate(best).low, request.error)) return best;  // it may, and the check tells
    throw unreachable(request.error, planning.candidate(best).words, planning.estimate(best).middle, " in the probe");
}

// Most accurate within the time: the least rms against the truth of most samples; of equal ones the cheapest.
size_t mostAccurateWithin(Planning& planning, const PlannerRequest& request) {
    size_t best = planning.size();
    for (size_t i = 0; i < planning.size(); ++i) {
        if (!planning.fits(i)) break;  // they are in the order of their costs
        if (planning.weighed()[i].tookMs) continue;
        const double rms = planning.estimate(i, kMostSamples).middle.rms;
        if (best == planning.size() || rms < planning.estimate(best, kMostSamples).middle.rms - kSameError) best = i;
    }
    if (best == planning.size())
        throw Error(Exit::budget, fmt::format("no choice is done in {:g} ms; the fastest is '{}': about {:.3g} ms", *request.timeMs,
                                              planning.candidate(0).words, planning.predictedMs(0)));
    return best;
}

// Draws candidates and checks them until one keeps the budget.
class Trying {
public:
    Trying(const Scene& scene, const PlannerRequest& request, const DrawPicture& draw)
        : scene_(scene), request_(request), draw_(draw), planning_(scene, request, false) {}

    CheckedPicture run() {
        for (size_t i = 0; i < planning_.size(); ++i)
            if (promises(i) && attempt(i)) return finish(i);
        // The others that could keep it, the nearest to the budget first.
        std::vector<size_t> left;
        for (size_t i = 0; i < planning_.size(); ++i)
            if (!planning_.weighed()[i].got && planning_.fits(i) && !planning_.exact() && excess(i) <= kHopeless) left.push_back(i);
        std::stable_sort(left.begin(), left.end(), [&](size_t a, size_t b) { return excess(a) < excess(b); });
        for (const size_t i : left)
            if ((!planning_.learntOf(i) || keeps(planning_.estimate(i, 0, false).low, request_.error)) && attempt(i)) return finish(i);
        fail();
    }

private:
    double excess(size_t i) { return excessOf(planning_.estimate(i).middle, request_.error); }

    bool promises(size_t i) {
        if (!planning_.fits(i)) return false;
        const Estimate e = planning_.estimate(i);
        if (keeps(e.middle, request_.error)) return true;
        if (!keeps(e.low, request_.error)) return false;
        const size_t next = planning_.nextPromising(i + 1);
        return next == planning_.size() || planning_.weighed()[i].costMs < kWorthTrying * planning_.weighed()[next].costMs;
    }

    RenderResult drawn(const RenderRequest& request) {
        RenderResult result = draw_(scene_, request);
        out_.triedMs += result.totalMs;
        return result;
    }

    // True when the picture keeps the budget.
    bool attempt(size_t i) {
        RenderRequest full = planning_.candidate(i).request;
        full.planes |= kCheckedPlanes;
        RenderResult result = drawn(full);
        if (checker_ == nullptr) takeChecker(result.totalMs);
        Weighed& w = planning_.weighed()[i];
        w.got = checker_->of(result.frame);
        BudgetFigures sure = *w.got;
        // A sample tells that too many faces are wrong where its lower bound does.
        if (!checker_->everyPixel()) sure.wrong = shareAbove(sure.wrongPixels, sure.pixels);
        w.kept = keeps(sure, request_.error);
        planning_.learn(i, sure.wrong);
        out_.tried.push_back(w);
        if (w.kept) checked_ = std::move(result);
        return w.kept;
    }

    void takeChecker(double pictureMs) {
        checker_ = request_.checker;
        if (checker_ == nullptr) makeChecker(pictureMs);
        out_.truthMs = checker_->ms();
        out_.certified = checker_->everyPixel();
        out_.checkedPixels = checker_->checkedPixels();
    }

    void makeChecker(double pictureMs) {
        const uint64_t pixels = uint64_t(request_.base.width) * request_.base.height;
        const double allowed = request_.checkMs.value_or(request_.checkShare * pictureMs), whole = planning_.probe().truthMs();
        CheckPlan plan;
        if (whole > allowed) plan.sampled = std::max(kLeastSample, uint64_t(double(pixels) * allowed / whole));
        ownChecker_.emplace(scene_, request_.base, plan, request_.onProgress);
        checker_ = &*ownChecker_;
    }

    // The chosen picture with the planes that were asked for. Those of the check cost time, so that a picture with a time budget is drawn as asked.
    CheckedPicture finish(size_t i) {
        const RenderRequest& asked = planning_.candidate(i).request;
        out_.plan = planning_.chosen(i);
        out_.got = *planning_.weighed()[i].got;
        if (request_.timeMs && (kCheckedPlanes & ~asked.planes) != 0) {
            out_.result = drawn(asked);
            if (out_.result.frame.rgba != checked_.frame.rgba)
                throw renderError(fmt::format("'{}' draws other bytes with planes than without", planning_.candidate(i).words));
            return std::move(out_);
        }
        out_.result = std::move(checked_);
        forEachPlane([&](const auto& row, auto plane) {
            if (row.plane != kPlaneColour && (row.plane & asked.planes) == 0) (out_.result.frame.*plane).clear();
        });
        return std::move(out_);
    }

    [[noreturn]] void fail() {
        const Weighed* best = nullptr;
        for (const Weighed& w : out_.tried)
            if (best == nullptr || excessOf(*w.got, request_.error) < excessOf(*best->got, request_.error)) best = &w;
        if (best != nullptr) throw unreachable(request_.error, best->words, *best->got, request_.timeMs ? " in that time" : "");
        cheapestWithin(planning_, request_);  // throws: no estimate keeps the budget
        throw Error(Exit::budget, "no choice keeps the budget in that time");
    }

    const Scene& scene_;
    const PlannerRequest& request_;
    const DrawPicture& draw_;
    Planning planning_;
    const Checker* checker_ = nullptr;  // null: no picture was checked yet
    std::optional<Checker> ownChecker_;
    RenderResult checked_;  // the picture that keeps the budget, with the planes of the check
    CheckedPicture out_;
};

}  // namespace

PlannedPicture planPicture(const Scene& scene, const PlannerRequest& request) {
    const bool error = !request.error.empty();
    refuseBelowRounding(request.error, request.base.encoding);
    if (!error && !request.timeMs) return predictPicture(scene, request);
    Planning planning(scene, request, !error);
    const size_t chosen = error ? cheapestWithin(planning, request) : mostAccurateWithin(planning, request);
    planning.prove(error ? 0 : kMostSamples);
    return planning.chosen(chosen);
}

CheckedPicture drawWithinTime(const Scene& scene, const PlannerRequest& request, const DrawPicture& draw) {
    PLUMB_ASSERT(request.error.empty() && request.timeMs);
    Planning planning(scene, request, true);
    CheckedPicture out;
    for (;;) {
        const size_t i = mostAccurateWithin(planning, request);
        Weighed& w = planning.weighed()[i];
        for (int turn = 0; turn < 2 && (turn == 0 || *w.tookMs > *request.timeMs); ++turn) {
            out.result = draw(scene, planning.candidate(i).request);
            out.triedMs += out.result.totalMs;
            w.tookMs = out.result.totalMs;
        }
        w.kept = *w.tookMs <= *request.timeMs;
        out.tried.push_back(w);
        if (w.kept) {
            out.plan = planning.chosen(i);
            return out;
        }
        planning.correct(*w.tookMs / w.costMs);
    }
}

CheckedPicture drawWithinError(const Scene& scene, const PlannerRequest& request, const DrawPicture& draw) {
    PLUMB_ASSERT(!request.error.empty());
    refuseBelowRounding(request.error, request.base.encoding);
    return Trying(scene, request, draw).run();
}

PlannedPicture predictPicture(const Scene& scene, const PlannerRequest& request) {
    PlannerRequest pinned = request;
    pinned.pinned = {true, true, true, true, {}};
    for (const TradeAxis& axis : kTradeAxes) pinned.pinned.trade.push_back(&axis);
    Planning planning(scene, pinned, false);
    return planning.chosen(0);
}

}  // namespace plumb
