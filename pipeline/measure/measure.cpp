// SPDX-License-Identifier: MIT
#include "pipeline/measure/measure.h"

#include "host/error.h"
#include "pipeline/detail/detail.h"
#include "pipeline/measure/rounds.h"
#include "pipeline/measure/row_fronts.h"
#include "pipeline/measure/row_list.h"
#include "pipeline/measure/truths.h"
#include "pipeline/render/bounds/bound.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/sha256.h"

#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace plumb {

namespace {

// Share of the limit that estimates may fill: rounds differ in length.
constexpr double kPlannedShare = 0.9;
// Share of the limit that the truths of the default picture may take; the rest is for rows.
constexpr double kTruthShare = 0.5;

class Measuring {
public:
    Measuring(const Scene& scene, const MeasurePlan& plan)
        : scene_(scene),
          plan_(plan),
          truths_(
              scene, plan.base.request, [this] { return elapsedMs(); }, [this] { tell(told_); }) {}
    Measuring(const Measuring&) = delete;
    Measuring& operator=(const Measuring&) = delete;

    Measurement run() {
        listRuns(out_, plan_);
        estimates_.assign(out_.runs.size(), 0);
        passNames_.resize(out_.runs.size());
        takeErrors();
        takeTimes();
        tellApart();
        finish();
        return std::move(out_);
    }

private:
    double elapsedMs() const {
        return plan_.beforeMs + std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_).count();
    }
    double endMs() const { return plan_.limitMs - plan_.afterMs; }
    double leftMs() const { return endMs() - elapsedMs(); }
    void tell(double fraction) {
        told_ = fraction;
        if (plan_.onProgress) plan_.onProgress(fraction);
    }
    bool active(size_t i) const { return !out_.runs[i].cut; }

    // Rounds below which no interval would be bounded.
    uint32_t leastRounds(size_t runs) const { return std::min(plan_.repetitions, roundsToTell(missOf(plan_.tables * (runs - 1)))); }
    uint32_t truthSamples() const { return plan_.truthSamples != 0 ? plan_.truthSamples : mostSamples(plan_.base); }
    size_t activeRuns() const {
        return size_t(std::count_if(out_.runs.begin(), out_.runs.end(), [](const MeasuredRun& run) { return !run.cut; }));
    }

    // Ends at the limit.
    RenderResult drawWithin(const Setting& setting) {
        Setting limited = setting;
        limited.request.onProgress = [this, inner = setting.request.onProgress](double done) {
            late_ = late_ || leftMs() < 0;
            return !late_ && (!inner || inner(done));
        };
        return plan_.draw(drawnSceneOf(setting), limited);
    }

    // The scene that a setting draws. Truths are those of scene_.
    const Scene& drawnSceneOf(const Setting& setting) {
        const Detail* detail = detailOf(setting);
        return detail == nullptr ? scene_ : detail->scene;
    }

    // Detail of a setting, made once. Null: the scene is drawn as it is.
    const Detail* detailOf(const Setting& setting) {
        if (setting.segments == 0 && setting.detail == 0) return nullptr;
        const auto [found, isNew] = details_.try_emplace({setting.segments, setting.detail});
        if (isNew) {
            const RenderRequest& r = setting.request;
            const auto onProgress = [this](double) {
                tell(told_);
                late_ = late_ || leftMs() < 0;
                return !late_;
            };
            try {
                if (setting.segments != 0)
                    found->second = tessellatedScene(scene_, setting.segments);
                else
                    found->second = detailed(scene_, {setting.detail, {r.width, r.height}, {}, r.threads, true, onProgress});
            } catch (...) {
                details_.erase(found);
                throw;
            }
        }
        return &found->second;
    }

    // What a run is to a picture: equal ones differ in nothing but noise.
    std::string workOf(size_t i) const {
        const Setting& s = out_.runs[i].setting;
        return fmt::format("{} {} {} {}", out_.runs[i].bytes, passNames_[i], s.twin, s.twin ? s.request.threads : 0);
    }

    // The run that is needed most comes first, the one that is cut first comes last.
    std::vector<size_t> byImportance() const {
        std::vector<size_t> asked(out_.runs.size(), axes().size() + out_.runs.size());
        for (const Row& row : out_.rows)
            if (row.run) asked[*row.run] = std::min(asked[*row.run], askedRank(*row.axis));
        std::vector<std::tuple<int, size_t, double, size_t>> keys;
        for (size_t i = 0; i < out_.runs.size(); ++i) {
            const MeasuredRun& run = out_.runs[i];
            const bool repeats = !run.bytes.empty() && workOf(i) == workOf(0);
            const int kind = i == 0 ? 0 : run.setting.again ? 2 : repeats ? 3 : 1;
            keys.emplace_back(kind, asked[i], estimates_[i], i);
        }
        std::sort(keys.begin(), keys.end());
        std::vector<size_t> order;
        for (const auto& key : keys) order.push_back(std::get<3>(key));
        return order;
    }

    void cutRun(size_t i, double neededMs) {
        out_.runs[i].cut = true;
        out_.runs[i].cutWhy =
            fmt::format("about {:.1f} s were needed, {:.1f} s were left", neededMs / 1000, std::max(0.0, leftMs()) / 1000);
    }

    // ms that the errors of a run take, and the rounds of all runs with it, from what others took. No choice is cut on a guess that it is slower: its draws
    // count like the default's until it has been drawn.
    std::pair<double, double> predictedMs(size_t i) const {
        const RenderRequest& request = out_.runs[i].setting.request;
        double errors = (restMs_.empty() ? 0 : medianOf(restMs_)) + 2 * estimates_[0];
        if (hasTruth(request) && !truths_.has(request)) errors += truths_.msPerSample() * request.samples;
        double round = estimates_[0];
        size_t runs = 1;
        for (size_t k = 0; k < out_.runs.size(); ++k)
            if (k != i && active(k) && estimates_[k] > 0) round += estimates_[k], ++runs;
        return {errors, leastRounds(runs + 1) * round};
    }

    // Errors of all, the most important first, so that the limit cuts the others.
    void takeErrors() {
        const double before = elapsedMs();
        takeErrorsOf(0);
        estimates_[1] = estimates_[0];
        out_.runs[1] = out_.runs[0];
        out_.runs[1].setting.again = true;
        out_.runs[1].boundWhy = "the default picture itself";
        passNames_[1] = passNames_[0];
        restMs_.push_back(std::max(0.0, elapsedMs() - before - truthsOfDefaultMs_ - 2 * estimates_[0]));
        size_t done = 2;
        for (const size_t i : byImportance()) {
            if (i < 2) continue;
            const auto [errors, rounds] = predictedMs(i);
            const double begun = elapsedMs();
            if (begun + errors + rounds > kPlannedShare * endMs()) {
                cutRun(i, errors + rounds);
            } else {
                takeErrorsOf(i);
                restMs_.push_back(std::max(0.0, elapsedMs() - begun - 2 * estimates_[i]));
            }
            tell(0.3 * double(++done) / double(out_.runs.size()));
        }
        const uint32_t most = truthSamples();
        const RenderRequest& base = plan_.base.request;
        if (!hasTruth(base)) return;
        if (const Truth* truth = truths_.at(most, base.fill, base.samples, Sampling::grid, 0)) out_.truth = *truth;
    }

    void takeErrorsOf(size_t i) {
        MeasuredRun& run = out_.runs[i];
        Setting full = run.setting;
        if (hasTruth(full.request)) full.request.planes |= kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive;
        const std::optional<RenderResult> result = drawnOf(i, full);
        if (!result) return;
        run.rays = result->counters.rays;
        run.bytes = sha256Hex(std::as_bytes(std::span(result->frame.rgba)));
        if (plan_.keepPictures) run.rgba = result->frame.rgba;
        if (hasTruth(full.request)) compareWithTruth(i, full.request, result->frame);
        const std::optional<RenderResult> plain = full.request.planes == run.setting.request.planes ? result : drawnOf(i, run.setting);
        if (!plain) return;
        if (plain->frame.rgba != result->frame.rgba)
            throw renderError(fmt::format("'{}' draws other bytes with planes than without", wordsOf(run.setting)));
        estimates_[i] = plain->totalMs;
        for (const PassTime& time : plain->times) passNames_[i] += time.pass + ",";
    }

    // None: the limit ended it, or the renderer does not draw this; then the run is cut.
    std::optional<RenderResult> drawnOf(size_t i, const Setting& setting) {
        MeasuredRun& run = out_.runs[i];
        try {
            return i == 0 ? plan_.draw(scene_, setting) : drawWithin(setting);
        } catch (const Error& refusal) {
            if (late_ && refusal.exit() == Exit::interrupted) {
                late_ = false;
                cutRun(i, predictedMs(i).first);
                return std::nullopt;
            }
            // The notes' fill does not draw every mesh; the default picture must be drawn.
            if (i == 0 || (refusal.exit() != Exit::input && refusal.exit() != Exit::usage)) throw;
            run.refused = refusal.what();
            run.cut = true;
            return std::nullopt;
        }
    }

    void compareWithTruth(size_t i, const RenderRequest& request, const Frame& frame) {
        MeasuredRun& run = out_.runs[i];
        const double begun = elapsedMs(), until = i == 0 ? kTruthShare * endMs() : endMs();
        const Detail* detail = detailOf(run.setting);
        const auto errorAgainst = [&](const Truth& truth) {
            if (detail == nullptr) return errorOf(frame, truth, request.encoding, request.transparent);
            Truth faceless = truth;
            forgetFaces(faceless, detail->redrawn);
            return errorOf(frame, faceless, request.encoding, request.transparent);
        };
        // The one truth has the most samples that any choice of any axis takes, whatever axes are measured. Its samples lie in a grid.
        const Truth* own = truths_.at(request.samples, request.fill, request.samples, samplingOf(request), until);
        const Truth* most = truths_.at(truthSamples(), request.fill, request.samples, Sampling::grid, until);
        if (i == 0) truthsOfDefaultMs_ = elapsedMs() - begun;
        if (most != nullptr) {
            run.error = errorAgainst(*most);
            if (i == 0) baseFrame_ = frame;
            run.error->unroundedPerPixel.clear();
        }
        if (own != nullptr) {
            run.alike = own == most ? run.error : errorAgainst(*own);
            run.alike->perPixel.clear();
            run.alike->unroundedPerPixel.clear();
        }
        // The twin draws the same bytes as the device, with any number of threads.
        Setting same = run.setting;
        same.twin = plan_.base.twin;
        same.request.threads = plan_.base.request.threads;
        if (i > 0 && wordsOf(same) == wordsOf(plan_.base))
            run.rounding = out_.runs[0].rounding;
        else if (leftMs() > 0)
            run.rounding = roundingOf(drawnSceneOf(run.setting), request, frame);
        if (i > 0 && run.error && out_.runs[0].error)
            takeBound(run, frame, *most);
        else if (i > 0)
            run.boundWhy = "no time left of the limit for the truth";
        if (run.error && !plan_.keepPictures) run.error->perPixel.clear();
    }

    // Only where nothing but the trade differs from the default picture, and that gives nothing away.
    void takeBound(MeasuredRun& run, const Frame& frame, const Truth& truth) {
        const RenderRequest &base = plan_.base.request, &request = run.setting.request;
        Setting rest = run.setting;
        rest.request.trade = base.trade;
        rest.request.maxDepth = base.maxDepth;
        rest.request.minWeight = base.minWeight;
        const bool traced = isTraced(base);
        const bool depthOrCutoff = traced && (request.maxDepth != base.maxDepth || request.minWeight != base.minWeight);
        if ((request.trade == base.trade && !depthOrCutoff) || wordsOf(rest) != wordsOf(plan_.base)) {
            run.boundWhy = traced ? "only depth and cutoff of rays are bounded" : "only a choice of the trade is bounded";
            return;
        }
        if (base.trade != Trade{} || base.encoding != Encoding::srgb) {
            run.boundWhy = "bounds are those of choices against an sRGB picture that trades nothing";
            return;
        }
        if (!depthOrCutoff) {
            // A pixel of several samples may show several faces.
            ColourBound bound = boundOfTrade(scene_, request, request.samples == 1 ? &baseFrame_ : nullptr);
            if (bound.proved && !bound.brighterAt.empty())
                return compareBound(run, frame, truth, {std::move(bound.brighterAt), std::move(bound.darkerAt)}, bound.steps);
            if (bound.proved) return compareBound(run, frame, truth, {bound.linear, bound.darker}, bound.steps);
            run.boundWhy = bound.why;
            return;
        }
        if (!raysBound_) raysBound_.emplace(scene_, base);
        BoundOfRays::Moves moves = raysBound_->of(request);
        if (moves.proved) return compareBound(run, frame, truth, {std::move(moves.brighter), std::move(moves.darker)}, 0);
        run.boundWhy = moves.why;
    }

    // States the bound of a run's error, and ends the measurement where the error is beyond it.
    void compareBound(MeasuredRun& run, const Frame& frame, const Truth& truth, const ColourMoves& moves, double steps) const {
        ErrorBound bound = errorBoundOf(baseFrame_, truth, plan_.base.request.transparent, moves, steps);
        std::optional<BoundBreach> breach = breachOfMoves(baseFrame_, frame, moves);
        if (!breach) breach = breachOf(*run.error, bound, frame.width);
        if (breach)
            throw renderError(fmt::format("'{}' at pixel ({}, {}): {} is {:.6g} {}, beyond its proved bound {:.6g}", nameOf(run), breach->x,
                                          breach->y, breach->figure == "linear" ? "the change" : "error." + breach->figure, breach->error,
                                          breach->unit, breach->bound));
        bound.perPixel.clear();
        run.boundWhy = bound.why();
        if (!bound.empty()) run.bound = std::move(bound);
    }

    // The row that a run was made for.
    std::string nameOf(const MeasuredRun& run) const {
        for (const Row& row : out_.rows)
            if (row.run && &out_.runs[*row.run] == &run) return fmt::format("{} {}", row.axis->name, row.choice->name);
        return wordsOf(run.setting);
    }

    double roundMs() const {
        double sum = 0;
        for (size_t i = 0; i < out_.runs.size(); ++i) sum += active(i) ? estimates_[i] : 0;
        return sum;
    }

    // Cuts what leaves the others no time for as many rounds as can tell anything apart.
    void cutToFit() {
        const std::vector<size_t> order = byImportance();
        for (size_t k = order.size(); k-- > 1;) {
            if (!active(order[k])) continue;
            const uint32_t least = leastRounds(activeRuns());
            const double needed = (least > out_.repetitions ? least - out_.repetitions : 0) * roundMs();
            if (elapsedMs() + needed <= endMs() - (1 - kPlannedShare) * std::max(0.0, leftMs())) return;
            cutRun(order[k], needed);
        }
    }

    // One time of each run that is not cut, by its index in runs; empty where the limit ends the round, which then does not count.
    std::vector<RenderResult> takeRound(const std::vector<size_t>& runs, const std::vector<size_t>& order) {
        std::vector<RenderResult> results(out_.runs.size());
        for (const size_t turn : order) {
            const size_t i = runs[turn];
            const bool must = i == 0 && out_.repetitions == 0 && runs.size() == 1;  // the default has a time, whatever the limit
            if (!must && leftMs() < std::max(estimates_[i], out_.runs[i].total.ms.empty() ? 0 : out_.runs[i].total.max())) return {};
            try {
                results[i] = must ? plan_.draw(scene_, out_.runs[i].setting) : drawWithin(out_.runs[i].setting);
            } catch (const Error& error) {
                if (!late_ || error.exit() != Exit::interrupted) throw;
                late_ = false;
                return {};
            }
            results[i].frame = {};
        }
        return results;
    }

    void takeTimes() {
        RoundOrder order(plan_.seed);
        while (out_.repetitions < plan_.repetitions) {
            cutToFit();
            std::vector<size_t> runs;
            for (size_t i = 0; i < out_.runs.size(); ++i)
                if (active(i)) runs.push_back(i);
            const std::vector<RenderResult> results = takeRound(runs, order.next(runs.size()));
            if (results.empty()) {
                if (out_.repetitions > 0 || runs.size() == 1) break;
                // Not even one round: the default alone is timed.
                for (const size_t i : runs)
                    if (i > 0) cutRun(i, roundMs());
                continue;
            }
            for (const size_t i : runs) {
                MeasuredRun& run = out_.runs[i];
                run.total.ms.push_back(results[i].totalMs);
                estimates_[i] = std::accumulate(run.total.ms.begin(), run.total.ms.end(), 0.0) / double(run.total.ms.size());
                for (const PassTime& time : results[i].times) {
                    auto pass = std::find_if(run.passes.begin(), run.passes.end(), [&](const auto& p) { return p.first == time.pass; });
                    if (pass == run.passes.end()) pass = run.passes.insert(run.passes.end(), {time.pass, {}});
                    pass->second.ms.push_back(time.ms);
                }
            }
            ++out_.repetitions;
            tell(0.3 + 0.7 * double(out_.repetitions) / plan_.repetitions);
        }
    }

    // The interval of each run's ratio to the default in the same round, and its word.
    void tellApart() {
        out_.comparisons = plan_.tables * (activeRuns() - 1);
        out_.miss = missOf(out_.comparisons);
        for (size_t i = 0; i < out_.runs.size(); ++i) {
            MeasuredRun& run = out_.runs[i];
            if (run.cut) continue;
            std::vector<double> ratios;
            for (size_t r = 0; r < run.total.ms.size(); ++r) ratios.push_back(run.total.ms[r] / out_.runs[0].total.ms[r]);
            run.ratio = intervalOf(ratios, out_.miss);
            if (i == 0 && run.ratio) run.ratio = RatioInterval{};
            if (run.ratio && !run.ratio->holdsOne()) run.told = run.ratio->high < 1 ? Told::faster : Told::slower;
        }
    }

    void finish() {
        std::vector<Row> kept;
        for (Row& row : out_.rows) {
            MeasuredRun* run = row.run ? &out_.runs[*row.run] : nullptr;
            if (run != nullptr && !run->refused.empty()) {
                row.why = run->refused;
                row.run.reset();
            } else if (run != nullptr && run->cut) {
                row.why = run->cutWhy;
                out_.cut.push_back(row);
                continue;
            } else if (run != nullptr && row.why.empty() && !run->alike) {
                row.why = "no time left of the limit for the truth";
            }
            kept.push_back(row);
        }
        out_.rows = std::move(kept);
        std::vector<std::string> works;
        for (size_t i = 0; i < out_.runs.size(); ++i) works.push_back(workOf(i));
        takeFronts(out_, works);
        out_.totalMs = elapsedMs();
        out_.limitKept = out_.totalMs <= plan_.limitMs;
    }

    const Scene& scene_;
    const MeasurePlan& plan_;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    Measurement out_;
    Truths truths_;
    Frame baseFrame_;  // the default picture
    std::optional<BoundOfRays> raysBound_;
    std::map<std::pair<uint32_t, double>, Detail> details_;  // by segments and pixels
    std::vector<double> estimates_;                          // ms of one draw of each run; 0: not drawn yet
    std::vector<std::string> passNames_;                     // of each run, in the order in which they ran
    std::vector<double> restMs_;                             // what errors took beside two draws, of each run that has them
    double truthsOfDefaultMs_ = 0;
    double told_ = 0;    // progress
    bool late_ = false;  // the limit ended a draw
};

}  // namespace

const char* nameOf(Told told) {
    static constexpr const char* kNames[] = {"faster", "slower", "not told apart"};
    return kNames[size_t(told)];
}

std::optional<double> Times::median() const { return ms.size() < kLeastForMedian ? std::nullopt : std::optional(medianOf(ms)); }
double Times::min() const { return *std::min_element(ms.begin(), ms.end()); }
double Times::max() const { return *std::max_element(ms.begin(), ms.end()); }

Measurement measure(const Scene& scene, const MeasurePlan& plan) { return Measuring(scene, plan).run(); }

}  // namespace plumb
