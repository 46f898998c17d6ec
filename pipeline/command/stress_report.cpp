// SPDX-License-Identifier: MIT
#include "pipeline/command/stress_report.h"

#include <fmt/core.h>
#include <optional>
#include <string>

namespace plumb {
namespace {

using stress::AxisMargin;
using stress::End;
using stress::Margin;
using stress::Outcome;
using stress::StressReport;
using stress::Tried;

// A value with as many digits as bisection knows.
std::string number(const AxisMargin& axis, double value) {
    return axis.axis->whole ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}
std::string valued(const AxisMargin& axis, double value) {
    const std::string unit = axis.axis->unit;
    return number(axis, value) + (unit.empty() ? "" : " " + unit);
}

// "breaks at 6.1e3", "holds up to 1e6, the largest ...".
std::string endOf(const AxisMargin& axis, const Margin& m) {
    switch (m.end) {
        case End::breaks:
            return fmt::format("breaks at {}", valued(axis, m.beyond));
        case End::holds:
            return fmt::format("holds {} {}, {}", axis.axis->rises ? "up to" : "down to", valued(axis, m.margin), m.why);
        case End::passed:
            return fmt::format("is passed: within {} {}", axis.axis->rises ? "up to" : "down to", valued(axis, m.margin));
        case End::other:
            return fmt::format("does not bring the error within: {}", m.why);
        case End::cut:
            return "has no margin yet: --limit left no time";
    }
    return "";
}

std::string lineOf(const AxisMargin& axis) {
    std::string line = fmt::format("{}: ", axis.axis->title);
    if (!axis.absent.empty()) return line + fmt::format("does not apply: {}\n", axis.absent);
    line += endOf(axis, axis.margin);
    line += axis.present ? fmt::format(" (you are at {})", number(axis, *axis.present)) : " (the scene has none)";
    if (axis.float32 && axis.float32->end != End::cut && endOf(axis, *axis.float32) != endOf(axis, axis.margin))
        line += fmt::format("; with float32 alone it {}", endOf(axis, *axis.float32));
    for (const double island : axis.margin.islands) line += fmt::format("; it is beyond at {}, too", number(axis, island));
    return line + "\n";
}

std::string figuresText(const StressReport& report) {
    const Tried& t = report.itself;
    if (!t.why.empty()) return t.why;
    return fmt::format("max {:.3f}, p99 {:.3f}, rms {:.3f} steps of 1/255, {:.3f} % wrong faces of {} pixels", t.figures.max, t.figures.p99,
                       t.figures.rms, 100 * t.figures.wrong, t.figures.pixels);
}

Json orNull(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json triedJson(const Tried& t, bool valued) {
    Json json;
    if (valued) json["value"] = t.value;
    json["outcome"] = nameOf(t.outcome);
    const bool figures = t.outcome != Outcome::refused && t.why.empty();
    json["p99"] = figures ? Json(t.figures.p99) : Json();
    json["wrong"] = figures ? Json(t.figures.wrong) : Json();
    json["max"] = figures ? Json(t.figures.max) : Json();
    json["rms"] = figures ? Json(t.figures.rms) : Json();
    json["pixels"] = figures ? Json(t.figures.pixels) : Json();
    json["raised"] = t.raised;
    json["why"] = t.why;
    return json;
}

Json marginJson(const Margin& m) {
    Json json;
    json["end"] = nameOf(m.end);
    const bool ends = m.end != End::cut && m.end != End::other;
    json["within"] = ends ? Json(m.margin) : Json();
    json["beyond"] = m.end == End::breaks || m.end == End::passed ? Json(m.beyond) : Json();
    json["why"] = m.why;
    json["islands"] = m.islands;
    json["tried"] = Json::array();
    for (const Tried& t : m.tried) json["tried"].push_back(triedJson(t, true));
    return json;
}

}  // namespace

std::string stressText(const StressReport& report) {
    std::string text =
        fmt::format("the scene as it is {} {}: {}\n", report.beyond() ? "is BEYOND" : "keeps", wordsOf(report.budget), figuresText(report));
    for (const AxisMargin& axis : report.axes) text += lineOf(axis);
    return text + fmt::format("{} pictures in {:.1f} s\n", report.pictures, report.totalMs / 1000);
}

Json stressJson(const StressReport& report) {
    const ErrorBudget& b = report.budget;
    Json json;
    json["budget"] = {{"max", orNull(b.max)}, {"p99", orNull(b.p99)}, {"rms", orNull(b.rms)}, {"wrong", orNull(b.wrongLimit())}};
    json["unit"] = "steps of 1/255; wrong: share of pixels";
    json["itself"] = triedJson(report.itself, false);
    json["axes"] = Json::array();
    for (const AxisMargin& axis : report.axes) {
        Json one;
        one["axis"] = axis.axis->name;
        one["title"] = axis.axis->title;
        one["unit"] = axis.axis->unit;
        one["rises"] = axis.axis->rises;
        one["applies"] = axis.absent.empty();
        one["absent"] = axis.absent;
        one["present"] = orNull(axis.present);
        one["planned"] = axis.absent.empty() ? marginJson(axis.margin) : Json();
        one["float32"] = axis.float32 ? marginJson(*axis.float32) : Json();
        json["axes"].push_back(one);
    }
    json["pictures"] = report.pictures;
    json["time_ms"] = report.totalMs;
    return json;
}

}  // namespace plumb
