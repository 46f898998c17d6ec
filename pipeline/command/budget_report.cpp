// SPDX-License-Identifier: MIT
#include "pipeline/command/budget_report.h"

#include "host/binary64.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/report.h"
#include "pipeline/planner/calibration.h"
#include "pipeline/render/technique.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <thread>
#include <utility>

namespace plumb {
namespace {

Json orNull(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json workJson(const Work& work) {
    Json json = Json::object();
    for (const Choice<Unit>& unit : kUnitWords)
        if (work[unit.value] > 0) json[unit.word] = work[unit.value];
    return json;
}

// Null figures: no bound below full scale.
Json boundJson(const ProvedErrors& b) {
    const auto stated = [&](double steps) { return b.proved && std::isfinite(steps) ? Json(steps) : Json(); };
    return {{"max", stated(b.max)}, {"p99", stated(b.p99)}, {"rms", stated(b.rms)}, {"why", b.proved ? Json() : Json(b.why)}};
}

Json weighedJson(const Weighed& w) {
    Json json = {{"choices", w.words}, {"predicted_ms", w.costMs}, {"work", workJson(w.work)}};
    json["probe"] = w.error ? figuresJson(w.error->middle) : Json();
    json["bound"] = w.bound ? boundJson(*w.bound) : Json();
    json["got"] = w.got ? figuresJson(*w.got) : Json();
    json["took_ms"] = orNull(w.tookMs);
    json["kept"] = w.got || w.tookMs ? Json(w.kept) : Json();
    return json;
}

// Metric whose figure is the largest share of its limit.
const char* tightest(const BudgetFigures& f, const ErrorBudget& budget) {
    const std::pair<const char*, ErrorBudget> alone[] = {{"max", {budget.max, {}, {}, 1.0}},
                                                         {"p99", {{}, budget.p99, {}, {}}},
                                                         {"rms", {{}, {}, budget.rms, {}}},
                                                         {"wrong", {{}, {}, {}, budget.wrongLimit()}}};
    const char* name = kErrorMetrics[0].word;
    double most = -1;
    for (const auto& [word, one] : alone) {
        const bool asked = word == std::string("max") ? budget.max.has_value() : !one.empty();
        if (asked && excessOf(f, one) > most) most = excessOf(f, one), name = word;
    }
    return name;
}

std::string gotText(const BudgetFigures& f) {
    return fmt::format("max {:.3f} at ({}, {}), p99 {:.3f}, rms {:.3f}, wrong face in {} of {} ({:.3f} %), {} left out of max", f.max, f.x,
                       f.y, f.p99, f.rms, f.wrongPixels, f.pixels, 100 * f.wrong, f.undecided);
}

bool hasErrors(const PlannedPicture& plan) {
    return std::any_of(plan.weighed.begin(), plan.weighed.end(), [](const Weighed& w) { return w.error.has_value(); });
}

// A picture that takes longer is said to.
constexpr double kLongMs = 60000;
// No device needs a minute for as many rays.
constexpr double kFewRays = 1e7;
// The twin's processor time is that many times what a device takes, at most one as slow as a processor.
constexpr double kTwinAtMost = 4;

uint32_t threadsOf(uint32_t threads) { return threads != 0 ? threads : std::max(1u, std::thread::hardware_concurrency()); }

// Device, driver and version, in one line.
std::string keyOf(const Renderer& renderer, uint32_t threads) {
    const Json tool = toolJson(), host = hostJson();
    std::string key = fmt::format("{} {} on {}, {} threads", versionText(), tool["git"].get<std::string>(),
                                  host["cpu_model"].get<std::string>(), threadsOf(threads));
    if (const Device* device = renderer.device(); device != nullptr) {
        const DeviceInfo& info = device->info();
        key = fmt::format("{} | {} | {} | {} | {}", info.uuid, info.name, info.driver, info.driverInfo, key);
    } else {
        key = "CPU twin | " + key;
    }
    std::replace(key.begin(), key.end(), '\n', ' ');
    return key;
}

}  // namespace

Json figuresJson(const BudgetFigures& f) {
    return {{"max", f.max},     {"maxAt", {f.x, f.y}},          {"p99", f.p99},       {"rms", f.rms},
            {"wrong", f.wrong}, {"wrongPixels", f.wrongPixels}, {"pixels", f.pixels}, {"undecided", f.undecided}};
}

PlannerRequest plannerRequestOf(const Options& options, const RenderRequest& base) {
    PlannerRequest request;
    request.base = base;
    request.base.onProgress = nullptr;
    request.pinned.shading = options.shading.has_value();
    request.pinned.samples = options.samples.has_value();
    request.pinned.maxDepth = options.maxDepth.has_value();
    request.pinned.minWeight = options.minWeight.has_value();
    request.pinned.trade = options.traded;
    request.error = options.error;
    request.timeMs = options.timeMs;
    request.checkMs = options.checkMs;
    refuseBelowRounding(options.error, base.encoding);
    return request;
}

void takeCosts(PlannerRequest& request, Renderer& renderer, const Options& options) {
    Device* device = renderer.device();
    if (device != nullptr) request.pinned.binary64 = lacksBinary64(*device).empty();
    const Calibration calibration =
        calibrationOf(keyOf(renderer, request.base.threads), [&](const Scene& scene, const RenderRequest& wanted) {
            RenderRequest picture = wanted;
            picture.threads = request.base.threads;
            picture.onProgress = [](double) { return interruptedBy() == 0; };
            return device != nullptr ? renderGpu(*device, scene, picture) : renderCpu(scene, picture);
        });
    request.costs = calibration.costs;
    request.twinRay = calibration.twinRay;
    if (!calibration.fromCache)
        say(options, fmt::format("plumb: unit costs of {} measured in {:.0f} ms{}", renderer.name(), calibration.ms,
                                 calibration.steady ? ", and kept" : " beside other work, and not kept"));
}

void tellLongPicture(const Options& options, const Scene& scene, const RenderRequest& request, Renderer& renderer) {
    if (options.quiet || !isTraced(request) || mostRaysOf(scene, request) < kFewRays) return;
    if (pilotMs(scene, request) < kLongMs / kTwinAtMost) return;
    PlannerRequest forecast;
    forecast.base = request;
    Calibration calibration;
    if (keptCalibration(keyOf(renderer, request.threads), calibration)) {
        forecast.costs = calibration.costs;
        forecast.twinRay = calibration.twinRay;
    } else {
        forecast.costs[Unit::ray] = 1.0 / double(threadsOf(request.threads));  // of the twin's own processor time
        forecast.twinRay = 1;
    }
    const RayForecast f = forecastRays(scene, forecast);
    if (f.picture.weighed[0].costMs >= kLongMs) say(options, fmt::format("plumb: {}", sentenceOf(f)));
}

Json forecastJson(const RayForecast& f) {
    Json json = {{"rays", f.rays}, {"predicted_ms", f.picture.weighed[0].costMs}, {"less", Json()}};
    if (f.less)
        json["less"] = {
            {"min_weight", f.less->minWeight}, {"share", f.less->share}, {"steps", orNull(f.less->steps)}, {"why", f.less->why}};
    return json;
}

std::string budgetLine(const PlannerRequest& request, const CheckedPicture& p) {
    const std::string checked =
        p.certified ? fmt::format("checked on all {} pixels", p.checkedPixels)
                    : fmt::format("checked on a random sample of {} pixels: with 95 % confidence fewer than {:.2g} % of all are beyond",
                                  p.checkedPixels, 100 * shareBelow(0, p.got.pixels));
    return fmt::format("budget {}: kept by '{}': {}; {}; {} tried, planned in {:.0f} ms, truth in {:.0f} ms", wordsOf(request.error),
                       p.plan.chosen.words, gotText(p.got), checked, p.tried.size(), p.plan.planMs, p.truthMs);
}

std::string timeLine(const PlannerRequest& request, const PlannedPicture& plan, double tookMs) {
    const Weighed& w = plan.weighed[plan.index];
    return fmt::format("budget {:g} ms: '{}', predicted {:.3g} ms, took {:.3g} ms; planned in {:.0f} ms", *request.timeMs, w.words,
                       w.costMs, tookMs, plan.planMs);
}

Json budgetJson(const PlannerRequest& request, const PlannedPicture& plan, const CheckedPicture* picture, double tookMs) {
    const ErrorBudget& e = request.error;
    const Weighed& w = plan.weighed[plan.index];
    Json json;
    json["asked"] = {{"max", orNull(e.max)},
                     {"p99", orNull(e.p99)},
                     {"rms", orNull(e.rms)},
                     {"wrong", orNull(e.wrongLimit())},
                     {"time_ms", orNull(request.timeMs)}};
    json["unit"] = "steps of 1/255; wrong: share of pixels";
    const bool checked = picture != nullptr && !e.empty();
    const BudgetFigures* figures = checked ? &picture->got : w.error ? &w.error->middle : nullptr;
    json["metric"] = figures != nullptr && !e.empty() ? Json(tightest(*figures, e)) : Json();
    json["choices"] = w.words;
    json["predicted_ms"] = w.costMs;
    json["took_ms"] = tookMs >= 0 ? Json(tookMs) : Json();
    json["kept"] = tookMs >= 0 ? Json((!request.timeMs || tookMs <= *request.timeMs) && (!checked || picture->tried.back().kept)) : Json();
    json["got"] = checked ? figuresJson(picture->got) : Json();
    json["wrong"] = figures != nullptr ? Json(figures->wrong) : Json();
    json["certified"] = checked && picture->certified;
    json["checked"] = Json();
    if (checked) {
        json["checked"] = {{"pixels", picture->checkedPixels}, {"confidence", 0.95}};
        json["checked"]["beyond_below"] = picture->certified ? 0.0 : shareBelow(0, picture->got.pixels);
    }
    json["tried"] = Json::array();
    if (picture != nullptr)
        for (const Weighed& one : picture->tried) json["tried"].push_back(weighedJson(one));
    json["weighed"] = Json::array();
    for (const Weighed& one : plan.weighed) json["weighed"].push_back(weighedJson(one));
    json["probe"] = {{"every", plan.shrink}};
    json["time_ms"] = {{"plan", plan.planMs},
                       {"truth", checked ? Json(picture->truthMs) : Json()},
                       {"tried", picture != nullptr ? Json(picture->triedMs) : Json()}};
    return json;
}

std::string choicesText(const PlannerRequest& request, const PlannedPicture& plan, bool all) {
    std::string text = fmt::format("  {:>12}  {:>8}  {:>8}  {:>8}  {:>9}  {:>17}  choices\n", "predicted ms", "max", "p99", "rms", "wrong",
                                   "proved max, rms");
    const auto add = [&](const Weighed& w, bool chosen) {
        const auto figure = [&](double f, bool share) {
            return w.error ? (share ? fmt::format("{:.3f} %", 100 * f) : fmt::format("{:.3f}", f)) : "-";
        };
        const BudgetFigures f = w.error ? w.error->middle : BudgetFigures{};
        const auto proved = [](double steps) { return std::isfinite(steps) ? fmt::format("{:.3f}", steps) : std::string("-"); };
        const std::string bound =
            w.bound && w.bound->proved ? fmt::format("{:>8} {:>8}", proved(w.bound->max), proved(w.bound->rms)) : std::string("-");
        text += fmt::format("{} {:>12.4g}  {:>8}  {:>8}  {:>8}  {:>9}  {:>17}  {}\n", chosen ? '*' : ' ', w.costMs, figure(f.max, false),
                            figure(f.p99, false), figure(f.rms, false), figure(f.wrong, true), bound, w.words);
    };
    for (size_t i = 0; i < plan.weighed.size(); ++i)
        if (all || i == plan.index) add(plan.weighed[i], i == plan.index);
    if (hasErrors(plan))
        text += fmt::format("errors: {}, against the truth{}\n",
                            plan.shrink == 1 ? std::string("of the whole picture")
                                             : fmt::format("of every {}th pixel of every {}th row", plan.shrink, plan.shrink),
                            request.error.empty() ? " of 16 samples a pixel" : "");
    return text;
}

std::string raysText(const PlannedPicture& plan) {
    if (plan.rays.empty()) return "";
    double primary = 0, sent = 0, shadow = 0;
    for (const RenderCounters::RayCounts& r : plan.rays) {
        primary += double(r.primary);
        sent += double(r.reflected + r.refracted);
        shadow += double(r.shadowRays);
    }
    return fmt::format("about {:.3g} rays: {:.3g} from the eye, {:.3g} mirrored or refracted up to depth {}, {:.3g} to lights",
                       primary + sent + shadow, primary, sent, plan.rays.size(), shadow);
}

}  // namespace plumb
