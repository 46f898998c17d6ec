// SPDX-License-Identifier: MIT
#include "pipeline/measure/measure.h"

#include "host/error.h"
#include "pipeline/measure/pareto.h"
#include "pipeline/render/bound.h"

#include <cstdint>
#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace plumb {

namespace {

// A wire frame is a drawing, and has no truth.
constexpr const char* kWireWhy = "a wire frame has no truth: its lines are a drawing, not the picture of a surface";
// Of the time that is left, this share is planned with; rounds differ in length.
constexpr double kPlannedShare = 0.9;

// What the notes' fill does not have. Null: nothing is missing.
const char* notesLack(const Setting& setting) {
    const RenderRequest& r = setting.request;
    if (r.fill != Fill::notes || r.shading == Shading::wire) return nullptr;
    Trade other = r.trade;
    other.specular = Trade().specular;
    return other != Trade{} ? "the notes' fill has no such choice" : nullptr;
}

// What a picture of rays has and a raster picture has not, and the other way round. Null: nothing is missing.
const char* scopeLacks(const Axis& axis, const Setting& base, const Setting& setting) {
    const bool traced = base.request.shading == Shading::ray;
    if (traced && axis.scope == Scope::raster) return "not applicable: a choice of the raster passes, and this picture is traced";
    if (!traced && axis.scope == Scope::rays) return "not applicable: nothing is traced in a raster picture; measure with --shading ray";
    if (!traced && setting.request.shading == Shading::ray)
        return "not applicable: rays see shadows and mirrors, which the truth of a raster picture has not; measure with --shading ray";
    return nullptr;
}

class Measuring {
public:
    Measuring(const Scene& scene, const MeasurePlan& plan) : scene_(scene), plan_(plan) {}

    Measurement run() {
        listRuns();
        takeErrors();
        planRounds();
        takeTimes();
        finish();
        return std::move(out_);
    }

private:
    double elapsedMs() const {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_).count();
    }
    double leftMs() const { return plan_.limitMs - elapsedMs(); }
    void tell(double fraction) const {
        if (plan_.onProgress) plan_.onProgress(fraction);
    }

    size_t runOf(const Setting& setting) {
        const std::string words = wordsOf(setting);
        for (size_t i = 0; i < out_.runs.size(); ++i)
            if (wordsOf(out_.runs[i].setting) == words) return i;
        out_.runs.push_back({});
        out_.runs.back().setting = setting;
        return out_.runs.size() - 1;
    }

    void listRuns() {
        runOf(plan_.base);
        for (const Axis* axis : plan_.axes)
            for (const Choice& choice : axis->choices) {
                Row row;
                row.axis = axis;
                row.choice = &choice;
                if (choice.apply == nullptr) {
                    const char* outside = scopeLacks(*axis, plan_.base, plan_.base);
                    row.why = outside != nullptr ? outside : choice.why;
                } else {
                    Setting setting = plan_.base;
                    choice.apply(setting);
                    if (const char* outside = scopeLacks(*axis, plan_.base, setting); outside != nullptr) {
                        row.why = outside;
                    } else if (const char* lacks = notesLack(setting); lacks != nullptr) {
                        row.why = lacks;
                    } else if (!setting.twin && !plan_.deviceThere) {
                        row.why = "no device draws here";
                    } else {
                        row.run = runOf(setting);
                        row.baseline = *row.run == 0;
                        if (setting.request.shading == Shading::wire) row.why = kWireWhy;
                    }
                }
                out_.rows.push_back(row);
            }
        estimates_.assign(out_.runs.size(), 0);
    }

    bool traced() const { return plan_.base.request.shading == Shading::ray; }

    // The notes' fill samples whole coordinates, and so does the truth that it is held against. Rays may lie elsewhere in a pixel.
    const Truth& truthAt(uint32_t samples, Fill fill, uint32_t drawn, Sampling sampling = Sampling::grid) {
        if (fill != Fill::notes) drawn = samples;
        auto found = truths_.find({samples, fill, drawn, sampling});
        if (found == truths_.end()) {
            RenderRequest request = plan_.base.request;
            request.fill = fill;
            request.shading = traced() ? Shading::ray : Shading::phong;
            request.rays.sampling = sampling;
            request.samples = samples;
            request.onProgress = [this](double) { return tell(0), true; };
            found = truths_.emplace(std::tuple(samples, fill, drawn, sampling), truthOf(scene_, request, drawn)).first;
        }
        return found->second;
    }
    // At the places of a picture's own samples.
    const Truth& truthLike(const RenderRequest& request) {
        const bool rays = request.shading == Shading::ray;
        return truthAt(request.samples, request.fill, request.samples, rays ? request.rays.sampling : Sampling::grid);
    }

    // The one truth has the most accurate choice of every knob: the most samples among the runs.
    void takeErrors() {
        uint32_t most = 1;
        for (const MeasuredRun& run : out_.runs) most = std::max(most, run.setting.request.samples);
        for (size_t i = 0; i < out_.runs.size(); ++i) {
            MeasuredRun& run = out_.runs[i];
            if (i > 0 && leftMs() < 0) {
                run.cut = true;
                continue;
            }
            Setting full = run.setting;
            if (full.request.shading != Shading::wire)
                full.request.planes |= kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive;
            RenderResult result;
            try {
                result = plan_.draw(scene_, full);
            } catch (const Error& refusal) {
                // The notes' fill does not draw every mesh; the default picture must be drawn.
                if (i == 0 || (refusal.exit() != Exit::input && refusal.exit() != Exit::usage)) throw;
                run.refused = refusal.what();
                run.cut = true;
                continue;
            }
            if (full.request.shading != Shading::wire) {
                const bool transparent = full.request.transparent;
                const Fill fill = full.request.fill;
                run.error = errorOf(result.frame, truthAt(most, fill, full.request.samples), full.request.encoding, transparent);
                const Truth& own = truthLike(full.request);
                run.alike = &own == &truthAt(most, fill, full.request.samples) ? run.error : errorOf(result.frame, own, full.request.encoding, transparent);
                run.alike->perPixel.clear();
                run.alike->unroundedPerPixel.clear();
                if (i == 0) baseFrame_ = result.frame;
                run.error->unroundedPerPixel.clear();
                // The twin draws the same bytes as the device, with any number of threads.
                Setting same = run.setting;
                same.twin = plan_.base.twin;
                same.request.threads = plan_.base.request.threads;
                if (i > 0 && wordsOf(same) == wordsOf(plan_.base))
                    run.rounding = out_.runs[0].rounding;
                else if (i == 0 || leftMs() > 0)
                    run.rounding = roundingOf(scene_, full.request, result.frame);
                if (i > 0) takeBound(run, result.frame, truthAt(most, fill, full.request.samples));
                if (!plan_.keepPictures) run.error->perPixel.clear();
            }
            estimates_[i] = result.totalMs;
            run.rays = result.counters.rays;
            if (full.request.planes != run.setting.request.planes) {
                const RenderResult plain = plan_.draw(scene_, run.setting);
                if (plain.frame.rgba != result.frame.rgba)
                    throw renderError(fmt::format("'{}' draws other bytes with planes than without", wordsOf(run.setting)));
                estimates_[i] = plain.totalMs;
            }
            if (plan_.keepPictures) run.rgba = result.frame.rgba;
            tell(0.3 * double(i + 1) / double(out_.runs.size()));
        }
        out_.truth = truthAt(most, plan_.base.request.fill, plan_.base.request.samples);
    }

    // Only where nothing but the trade differs from the default picture, and that gives nothing away.
    void takeBound(MeasuredRun& run, const Frame& frame, const Truth& truth) {
        const RenderRequest &base = plan_.base.request, &request = run.setting.request;
        Setting rest = run.setting;
        rest.request.trade = base.trade;
        rest.request.maxDepth = base.maxDepth;
        rest.request.minWeight = base.minWeight;
        const bool depthOrCutoff = traced() && (request.maxDepth != base.maxDepth || request.minWeight != base.minWeight);
        if ((request.trade == base.trade && !depthOrCutoff) || wordsOf(rest) != wordsOf(plan_.base)) {
            run.boundWhy = traced() ? "only depth and cutoff of rays are bounded" : "only a choice of the trade is bounded";
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
            throw renderError(fmt::format("'{}' at pixel ({}, {}): {} is {:.6g} {}, beyond its proved bound {:.6g}", nameOf(run), breach->x, breach->y,
                                          breach->figure == "linear" ? "the change" : "error." + breach->figure, breach->error, breach->unit, breach->bound));
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

    void planRounds() {
        const uint32_t least = std::min(2u, plan_.repetitions);
        const auto round = [&] {
            double sum = 0;
            for (size_t i = 0; i < out_.runs.size(); ++i) sum += out_.runs[i].cut ? 0 : estimates_[i];
            return sum;
        };
        while (least * round() > kPlannedShare * leftMs()) {
            size_t slowest = 0;
            for (size_t i = 1; i < out_.runs.size(); ++i)
                if (!out_.runs[i].cut && (slowest == 0 || estimates_[i] > estimates_[slowest])) slowest = i;
            if (slowest == 0) break;  // the default picture stays
            out_.runs[slowest].cut = true;
        }
        const double possible = std::floor(std::max(0.0, kPlannedShare * leftMs()) / std::max(round(), 1e-3));
        rounds_ = uint32_t(std::clamp(possible, double(least), double(plan_.repetitions)));
    }

    void takeTimes() {
        for (uint32_t r = 0; r < rounds_; ++r) {
            // A round is taken whole or not at all once each run has been timed twice, so that all rows have the same number.
            if (r >= 2 && leftMs() < 0) break;
            const double before = elapsedMs();
            for (MeasuredRun& run : out_.runs) {
                if (run.cut) continue;
                const RenderResult result = plan_.draw(scene_, run.setting);
                run.total.ms.push_back(result.totalMs);
                for (const PassTime& time : result.times) {
                    auto place = std::find_if(run.passes.begin(), run.passes.end(),
                                              [&](const auto& p) { return p.first == time.pass; });
                    if (place == run.passes.end()) place = run.passes.insert(run.passes.end(), {time.pass, {}});
                    place->second.ms.push_back(time.ms);
                }
            }
            ++out_.repetitions;
            // The first draws made pipelines, the first round shows what one takes: more may fit than were planned, never fewer.
            if (r == 0) {
                const double more = std::floor(std::max(0.0, kPlannedShare * leftMs()) / std::max(elapsedMs() - before, 1e-3));
                rounds_ = std::max(rounds_, uint32_t(std::min(1 + more, double(plan_.repetitions))));
            }
            tell(0.3 + 0.7 * double(r + 1) / rounds_);
        }
    }

    void finish() {
        std::vector<Row> kept;
        for (Row& row : out_.rows) {
            if (row.run && !out_.runs[*row.run].refused.empty()) {
                row.why = out_.runs[*row.run].refused;
                row.run.reset();
            }
            (row.run && out_.runs[*row.run].cut ? out_.cut : kept).push_back(row);
        }
        out_.rows = std::move(kept);
        std::vector<TradePoint> points;
        std::vector<size_t> runs;
        for (size_t i = 0; i < out_.runs.size(); ++i) {
            const MeasuredRun& run = out_.runs[i];
            if (run.cut || !run.error || run.total.ms.empty()) continue;
            points.push_back({run.total.median(), run.error->picture.rms});
            runs.push_back(i);
        }
        for (const size_t point : paretoFront(points)) {
            bool first = true;
            for (size_t i = 0; i < out_.rows.size(); ++i) {
                if (out_.rows[i].run != runs[point]) continue;
                out_.rows[i].onFront = true;
                if (first) out_.front.push_back(i);
                first = false;
            }
        }
        out_.totalMs = elapsedMs();
    }

    const Scene& scene_;
    const MeasurePlan& plan_;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    Measurement out_;
    std::map<std::tuple<uint32_t, Fill, uint32_t, Sampling>, Truth> truths_;  // by its samples, fill, samples drawn, places of rays
    Frame baseFrame_;  // the default picture
    std::optional<BoundOfRays> raysBound_;
    std::vector<double> estimates_;  // ms of one draw of each run
    uint32_t rounds_ = 0;
};

}  // namespace

double Times::median() const {
    PLUMB_ASSERT(!ms.empty());
    std::vector<double> sorted = ms;
    std::sort(sorted.begin(), sorted.end());
    const size_t n = sorted.size();
    return n % 2 != 0 ? sorted[n / 2] : (sorted[n / 2 - 1] + sorted[n / 2]) / 2;
}
double Times::min() const { return *std::min_element(ms.begin(), ms.end()); }
double Times::max() const { return *std::max_element(ms.begin(), ms.end()); }

Measurement measure(const Scene& scene, const MeasurePlan& plan) { return Measuring(scene, plan).run(); }

}  // namespace plumb
