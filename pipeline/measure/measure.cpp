// SPDX-License-Identifier: MIT
#include "pipeline/measure/measure.h"

#include "host/error.h"
#include "pipeline/measure/pareto.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cmath>

namespace plumb {

namespace {

// A wire frame is a drawing, and has no truth.
constexpr const char* kWireWhy = "a wire frame has no truth: its lines are a drawing, not the picture of a surface";
// Of the time that is left, this share is planned with; rounds differ in length.
constexpr double kPlannedShare = 0.9;

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
                    row.why = choice.why;
                } else {
                    Setting setting = plan_.base;
                    choice.apply(setting);
                    if (!setting.twin && !plan_.deviceThere) {
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

    const Truth& truthAt(uint32_t samples) {
        auto found = truths_.find(samples);
        if (found == truths_.end()) {
            RenderRequest request = plan_.base.request;
            request.shading = Shading::phong;
            request.samples = samples;
            request.onProgress = [this](double) { return tell(0), true; };
            found = truths_.emplace(samples, truthOf(scene_, request)).first;
        }
        return found->second;
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
            const RenderResult result = plan_.draw(scene_, full);
            if (full.request.shading != Shading::wire) {
                const bool transparent = full.request.transparent;
                run.error = errorOf(result.frame, truthAt(most), full.request.encoding, transparent);
                run.alike = full.request.samples == most ? run.error
                                                         : errorOf(result.frame, truthAt(full.request.samples),
                                                                   full.request.encoding, transparent);
                run.alike->perPixel.clear();
                if (!plan_.keepPictures) run.error->perPixel.clear();
            }
            estimates_[i] = result.totalMs;
            if (full.request.planes != run.setting.request.planes) {
                const RenderResult plain = plan_.draw(scene_, run.setting);
                if (plain.frame.rgba != result.frame.rgba)
                    throw renderError(fmt::format("'{}' draws other bytes with planes than without", wordsOf(run.setting)));
                estimates_[i] = plain.totalMs;
            }
            if (plan_.keepPictures) run.rgba = result.frame.rgba;
            tell(0.3 * double(i + 1) / double(out_.runs.size()));
        }
        out_.truth = truthAt(most);
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
            tell(0.3 + 0.7 * double(r + 1) / rounds_);
        }
    }

    void finish() {
        std::vector<Row> kept;
        for (Row& row : out_.rows) (row.run && out_.runs[*row.run].cut ? out_.cut : kept).push_back(row);
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
    std::map<uint32_t, Truth> truths_;
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
