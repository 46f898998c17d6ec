// SPDX-License-Identifier: MIT
#include "pipeline/command/measure_report.h"

#include "pipeline/command/error_report.h"
#include "pipeline/command/report.h"
#include "pipeline/report/report.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <thread>
#include <utility>

namespace plumb {
namespace {

Json loadJson(const LoadAverages& load) { return load[0] < 0 ? Json() : Json(load); }

Json numberJson(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

// No median of fewer than three times.
Json timesJson(const Times& t) { return {{"median", numberJson(t.median())}, {"min", t.min()}, {"max", t.max()}, {"n", t.ms.size()}}; }

// Medians; null where there are none.
Json passesJson(const MeasuredRun& run) {
    Json json = Json::object();
    for (const auto& [pass, times] : run.passes) json[pass] = numberJson(times.median());
    return json;
}

// Null ends: too few rounds to bound the interval.
Json intervalJson(const RatioInterval& ratio) {
    return {{"low", ratio.bounded() ? Json(ratio.low) : Json()}, {"high", ratio.bounded() ? Json(ratio.high) : Json()}};
}

// "default" for the default's own row, else what its interval says; nothing without an interval.
const char* toldOf(const Row& row, const Measurement& m) {
    const MeasuredRun& run = m.runs[*row.run];
    return !run.ratio ? "" : row.baseline ? "default" : nameOf(run.told);
}

// What a bound says below full scale; else null.
Json stated(double bound) { return std::isfinite(bound) ? Json(bound) : Json(); }

Json rowJson(const Row& row, const Measurement& m) {
    Json json;
    json["axis"] = row.axis->name;
    json["choice"] = row.choice->name;
    json["what"] = row.choice->apply != nullptr ? Json(row.choice->why) : Json();
    json["baseline"] = row.baseline;
    json["absent"] = !row.run;
    json["why"] = row.why.empty() ? Json() : Json(row.why);
    json["verdict"] = row.run ? Json(nameOf(row.choice->verdict)) : Json();
    json["timeMs"] = json["ratio"] = json["passesMs"] = json["error"] = json["errorAtItsSamples"] = Json();
    json["bound"] = json["boundWhy"] = json["rays"] = json["ratioInterval"] = json["told"] = Json();
    if (row.run) {
        const MeasuredRun& run = m.runs[*row.run];
        json["timeMs"] = timesJson(run.total);
        if (run.ratio) {
            json["ratio"] = run.ratio->median;
            json["ratioInterval"] = intervalJson(*run.ratio);
            json["told"] = toldOf(row, m);
        }
        json["passesMs"] = passesJson(run);
        if (!run.rays.empty()) {
            RenderCounters::RayCounts sum;
            for (const RenderCounters::RayCounts& depth : run.rays)
                sum.primary += depth.primary, sum.reflected += depth.reflected, sum.refracted += depth.refracted,
                    sum.shadowRays += depth.shadowRays;
            json["rays"] = {
                {"primary", sum.primary}, {"reflected", sum.reflected}, {"refracted", sum.refracted}, {"feelers", sum.shadowRays}};
        }
        if (run.alike) json["errorAtItsSamples"] = errorJson(*run.alike, true, run.rounding);
        if (run.error) json["error"] = errorJson(*run.error, false, run.rounding);
        if (run.error && run.alike) {
            for (const char* key : {"wrongPrimitive", "wrongPrimitiveShare", "wrongPrimitiveAt", "depthRelative"})
                json["error"][key] = json["errorAtItsSamples"][key];
        }
        if (!run.boundWhy.empty()) json["boundWhy"] = run.boundWhy;
        if (run.bound)
            json["bound"] = {
                {"max", stated(run.bound->max / 255)},
                {"mean", stated(run.bound->mean / 255)},
                {"rms", stated(run.bound->rms / 255)},
                {"p99", stated(run.bound->p99 / 255)},
                {"choice",
                 {{"brighter", stated(run.bound->brighter)},
                  {"darker", stated(run.bound->darker)},
                  {"linear", stated(std::max(run.bound->brighter, run.bound->darker))},
                  {"steps", run.bound->steps}}},
                {"kind",
                 "pixel by pixel, how far the truth is from the furthest code that the choice may make of the default picture's colour"}};
    }
    json["onFront"] = row.onFront;
    json["onAxisFront"] = row.onAxisFront;
    return json;
}

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + "\"";
}

// One cell, empty where there is no figure.
std::string cell(bool known, double value) { return known ? fmt::format("{}", value) : std::string(); }

// What the report compares is what eyes see: bytes of a picture that is stored in linear light become sRGB codes.
std::vector<uint32_t> displayed(const std::vector<uint32_t>& rgba, Encoding encoding) {
    if (encoding == Encoding::srgb) return rgba;
    std::array<uint32_t, 256> codes{};
    for (size_t i = 0; i < codes.size(); ++i) codes[i] = uint32_t(std::lround(srgbCode(double(i) / 255)));
    std::vector<uint32_t> out;
    out.reserve(rgba.size());
    for (const uint32_t pixel : rgba)
        out.push_back((pixel & 0xff000000u) | codes[pixel >> 16 & 0xff] << 16 | codes[pixel >> 8 & 0xff] << 8 | codes[pixel & 0xff]);
    return out;
}

}  // namespace

LoadAverages loadAverages() {
    LoadAverages load{};
    if (::getloadavg(load.data(), 3) != 3) load = {-1, -1, -1};
    return load;
}

std::string intervalText(const RatioInterval& ratio) {
    return ratio.bounded() ? fmt::format("{:.3f} .. {:.3f}", ratio.low, ratio.high) : std::string("too few rounds");
}

std::vector<std::string> notesOf(const Measurement& m, const MeasurePlan& plan, const LoadAverages& loadBefore,
                                 const LoadAverages& loadAfter) {
    std::vector<std::string> notes;
    const unsigned cores = std::thread::hardware_concurrency();
    if (const double load = std::max(loadBefore[0], loadAfter[0]); cores > 0 && load > cores)
        notes.push_back(
            fmt::format("load {:.2f} exceeds {} cores: others took time from what was measured; absolute times say little, and fewer rows "
                        "are told apart",
                        load, cores));
    if (m.repetitions < kLeastForMedian)
        notes.push_back(fmt::format("{} round{}: no median, no ratio and no front below {}", m.repetitions, m.repetitions == 1 ? "" : "s",
                                    kLeastForMedian));
    else if (const uint32_t least = roundsToTell(m.miss); m.repetitions < least)
        notes.push_back(fmt::format("{} rounds tell no times apart: {} are needed for {} rows", m.repetitions, least, m.comparisons));
    if (!m.limitKept)
        notes.push_back(fmt::format("--limit {:g}s was not kept: the default picture, which is always drawn, ended after {:.2f} s",
                                    plan.limitMs / 1000, m.totalMs / 1000));
    return notes;
}

Json contextJson(const Renderer& renderer, const Scene& scene, const std::vector<SourceFile>& sources, const MeasurePlan& plan,
                 const Measurement& m, const LoadAverages& loadBefore, const LoadAverages& loadAfter) {
    const Json host = hostJson(), tool = toolJson();
    Json json;
    json["device"] = deviceJson(renderer);
    json["cpu"] = host["cpu_model"];
    json["threads"] = host["threads"];
    json["load"] = loadJson(loadBefore);
    json["loadAfter"] = loadJson(loadAfter);
    json["build"] = {{"version", tool["version"]},
                     {"git", tool["git"]},
                     {"compiler", __VERSION__},
#ifdef NDEBUG
                     {"type", "release"}
#else
                     {"type", "debug"}
#endif
    };
    json["scene"] = sceneJson(scene, sources);
    json["size"] = {plan.base.request.width, plan.base.request.height};
    json["samples"] = plan.base.request.samples;
    json["options"] = {{"shading", nameOf(plan.base.request.shading)},
                       {"encoding", nameOf(plan.base.request.encoding)},
                       {"transparent", plan.base.request.transparent}};
    json["repetitions"] = m.repetitions;
    json["interleaved"] = true;
    json["order"] = {{"kind", "each round in another order, from Williams squares"}, {"seed", plan.seed}};
    json["limitMs"] = plan.limitMs;
    json["limitKept"] = m.limitKept;
    json["totalMs"] = m.totalMs;
    json["date"] = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
    return json;
}

Json measurementJson(const Measurement& m, Json context, const std::vector<std::string>& notes) {
    Json json;
    json["schema"] = "plumb-measure-1";
    json["tool"] = toolJson();
    json["context"] = std::move(context);
    json["truth"] = m.truth ? truthJson(*m.truth) : Json();
    json["baseline"] = {
        {"choices", wordsOf(m.runs[0].setting)}, {"timeMs", timesJson(m.runs[0].total)}, {"passesMs", passesJson(m.runs[0])}};
    json["baseline"]["error"] = m.runs[0].error ? errorJson(*m.runs[0].error, false, m.runs[0].rounding) : Json();
    json["rows"] = Json::array();
    for (const Row& row : m.rows) json["rows"].push_back(rowJson(row, m));
    json["frontBy"] = {"ratioInterval", "errorAtItsSamples.rms", "error.rms"};
    json["telling"] = {{"confidence", kConfidenceOfTable},
                       {"rows", m.comparisons},
                       {"confidenceOfRow", 1 - m.miss},
                       {"interval", "order statistics of the rounds' ratios"},
                       {"leastRounds", roundsToTell(m.miss)}};
    json["notes"] = notes;
    json["front"] = Json::array();
    for (const size_t i : m.front) json["front"].push_back({{"axis", m.rows[i].axis->name}, {"choice", m.rows[i].choice->name}});
    json["cut"] = Json::array();
    for (const Row& row : m.cut)
        json["cut"].push_back(
            {{"axis", row.axis->name},
             {"choice", row.choice->name},
             {"why", fmt::format("no time left of --limit {:g}s: {}", json["context"]["limitMs"].get<double>() / 1000, row.why)}});
    return json;
}

std::string csvOf(const Measurement& m) {
    std::string text =
        "axis,choice,baseline,absent,verdict,time_ms_median,time_ms_min,time_ms_max,n,ratio,error_max,error_max_x,"
        "error_max_y,error_p99,error_mean,error_rms,"
        "wrong_primitive_share,error_at_its_samples_rms,unrounded_at_its_samples_max,rounding_max,bound_max,bound_rms,"
        "on_front,why,told,ratio_low,ratio_high,on_axis_front\n";
    for (const Row& row : m.rows) {
        text += fmt::format("{},{},{:d},{:d},{},", row.axis->name, row.choice->name, row.baseline, !row.run,
                            row.run ? nameOf(row.choice->verdict) : "");
        const MeasuredRun* run = row.run ? &m.runs[*row.run] : nullptr;
        const bool ratio = run != nullptr && run->ratio;
        if (run != nullptr) {
            const std::optional<double> median = run->total.median();
            text += fmt::format("{},{},{},{},{},", cell(median.has_value(), median.value_or(0)), run->total.min(), run->total.max(),
                                run->total.ms.size(), cell(ratio, ratio ? run->ratio->median : 0));
            if (run->error) {
                const ErrorFigures& e = run->error->picture;
                text += fmt::format("{},{},{},{},{},{},", e.max / 255, e.x, e.y, e.p99 / 255, e.mean / 255, e.rms / 255);
            } else {
                text += ",,,,,,";
            }
            const bool alike = run->alike.has_value();
            text += fmt::format("{},{},{},{},{},{},", cell(alike, alike ? run->alike->wrongShare() : 0),
                                cell(alike, alike ? run->alike->picture.rms / 255 : 0),
                                cell(alike, alike ? run->alike->unrounded.max / 255 : 0),
                                cell(run->rounding.has_value(), run->rounding ? run->rounding->max / 255 : 0),
                                cell(run->bound && std::isfinite(run->bound->max), run->bound ? run->bound->max / 255 : 0),
                                cell(run->bound && std::isfinite(run->bound->rms), run->bound ? run->bound->rms / 255 : 0));
        } else {
            text += ",,,,,,,,,,,,,,,,,";
        }
        const bool bounded = ratio && run->ratio->bounded();
        text += fmt::format("{:d},{},{},{},{},{:d}\n", row.onFront, row.why.empty() ? "" : quoted(row.why),
                            run != nullptr ? toldOf(row, m) : "", cell(bounded, bounded ? run->ratio->low : 0),
                            cell(bounded, bounded ? run->ratio->high : 0), row.onAxisFront);
    }
    for (const Row& row : m.cut)
        text +=
            fmt::format("{},{},0,1,,,,,,,,,,,,,,,,,,,0,{},,,,0\n", row.axis->name, row.choice->name, quoted("cut by --limit: " + row.why));
    return text;
}

std::string tableOf(const Measurement& m, const std::string& title, const LoadAverages& load, const std::vector<std::string>& notes) {
    std::string text = fmt::format("{}, {} rounds, load {:.2f}\n", title, m.repetitions, load[0]);
    for (const std::string& note : notes) text += "note: " + note + "\n";
    text += fmt::format("  {:<13} {:<21} {:>9} {:>7} {:>15}  {:<14} {:>8} {:>8} {:>8} {:>10} {:>8} {:>10} {:>9}\n", "axis", "choice",
                        "median ms", "ratio", "interval", "than default", "own rms", "rms", "p99", "alone rms", "wrong", "bound rms",
                        "rounding");
    for (const Row& row : m.rows) {
        text += fmt::format("{} {:<13} {:<21} ",
                            row.onFront       ? '*'
                            : row.onAxisFront ? '+'
                                              : ' ',
                            row.axis->name, std::string(row.choice->name) + (row.baseline ? " (default)" : ""));
        if (!row.run) {
            text += fmt::format("absent: {}\n", row.why);
            continue;
        }
        const MeasuredRun& run = m.runs[*row.run];
        const std::optional<double> median = run.total.median();
        if (median)
            text += fmt::format("{:>9.2f} {:>7.3f} {:>15}  {:<14} ", *median, run.ratio->median,
                                row.baseline ? "" : intervalText(*run.ratio), row.baseline ? "" : nameOf(run.told));
        else
            text += fmt::format("{:>49} ", fmt::format("{:.2f} .. {:.2f} ms, no median", run.total.min(), run.total.max()));
        const auto figure = [](bool known, const char* digits, double value) {
            return known ? fmt::format(fmt::runtime(digits), value) : std::string("-");
        };
        if (run.alike)
            text += fmt::format("{:>8.3f} {:>8} {:>8} {:>10.5f} {:>7.3f}% {:>10} {:>9}\n", run.alike->picture.rms,
                                figure(run.error.has_value(), "{:.3f}", run.error ? run.error->picture.rms : 0),
                                figure(run.error.has_value(), "{:.3f}", run.error ? run.error->picture.p99 : 0), run.alike->unrounded.rms,
                                100 * run.alike->wrongShare(),
                                figure(run.bound && std::isfinite(run.bound->rms), "{:.3f}", run.bound ? run.bound->rms : 0),
                                figure(run.rounding.has_value(), "{:.2g}", run.rounding ? run.rounding->max : 0));
        else
            text += fmt::format("no error: {}\n", row.why);
    }
    for (const Row& row : m.cut)
        text += fmt::format("  {:<13} {:<21} cut, no time left of --limit: {}\n", row.axis->name, row.choice->name, row.why);
    text += fmt::format(
        "ratio: median of each round's time over the default's in that round; the intervals hold {:g} % of all tables whole ({:.2f} % a "
        "row)\n"
        "rms, p99: against the truth of {} samples a pixel, in steps of 1/255; own rms: against the truth at the picture's own samples; "
        "alone rms: that before rounding to bytes; wrong: pixels of another face; "
        "bound rms: what rms is proved not to exceed; rounding: the most that float32 alone costs\n",
        100 * kConfidenceOfTable, 100 * (1 - m.miss), m.truth ? m.truth->samples : 0);
    text += m.repetitions < kLeastForMedian ? fmt::format("no front: {} rounds of {}\n", m.repetitions, kLeastForMedian)
                                            : "* on the front: nothing is told to be faster and no less accurate, and nothing more "
                                              "accurate is as fast; + on the front of its axis alone\n";
    return text;
}

std::string htmlOf(const Measurement& m, const Json& json) {
    const uint32_t width = m.truth->width, height = m.truth->height;
    ReportPicture truth{"", "", width, height, {}};
    for (size_t i = 0; i < size_t(width) * height; ++i) {
        uint32_t pixel = 0xff000000u;
        for (size_t k = 0; k < 3; ++k) pixel |= uint32_t(std::lround(srgbCode(m.truth->linear[3 * i + k]))) << (8 * k);
        truth.rgba.push_back(pixel);
    }
    std::vector<ReportPicture> pictures;
    for (const Row& row : m.rows)
        if (row.run && !m.runs[*row.run].rgba.empty())
            pictures.push_back({row.axis->name, row.choice->name, width, height,
                                displayed(m.runs[*row.run].rgba, m.runs[*row.run].setting.request.encoding)});
    return reportHtml(json, truth, pictures);
}

}  // namespace plumb
