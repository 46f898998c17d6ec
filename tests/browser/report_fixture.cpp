// SPDX-License-Identifier: MIT
// Writes a report of a made-up measurement, with everything that a page must survive: bounds, an error of 0, rows that share a picture, absent and cut
// choices, rows that are not told apart, a note, names that would end a script. usage: report_fixture OUT.html
#include "pipeline/image/image.h"
#include "pipeline/report/report.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

namespace {

using Json = nlohmann::ordered_json;
using plumb::ReportPicture;

constexpr uint32_t kWidth = 320, kHeight = 240;

// A lit disc on a ground; `steps` makes its light coarse, `shift` moves its edge.
ReportPicture disc(const char* axis, const char* choice, double steps, double shift) {
    ReportPicture p{axis, choice, kWidth, kHeight, {}};
    for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x) {
            const double u = (x - 160.0 - shift) / 100, v = (y - 120.0) / 100, r = u * u + v * v;
            double light = r < 1 ? 0.2 + 0.8 * std::max(0.0, std::sqrt(1 - r) * 0.8 - u * 0.4 - v * 0.4) : 0.06;
            if (steps > 0 && r < 1) light = std::floor(light * steps) / steps;
            const auto code = [&](double c) { return uint32_t(std::lround(255 * std::clamp(light * c, 0.0, 1.0))); };
            p.rgba.push_back(0xff000000u | code(0.5) << 16 | code(0.75) << 8 | code(1));
        }
    return p;
}

constexpr double kDefaultMs = 11;

Json row(const char* axis, const char* choice, double ms, double error, Json bound, bool front, bool baseline = false) {
    const double ratio = ms / kDefaultMs, low = baseline ? 1 : ratio * 0.95, high = baseline ? 1 : ratio * 1.08;
    return {{"axis", axis},
            {"choice", choice},
            {"what", "made up"},
            {"baseline", baseline},
            {"absent", false},
            {"why", nullptr},
            {"verdict", "bits"},
            {"timeMs", {{"median", ms}, {"min", ms * 0.9}, {"max", ms * 1.3}, {"n", 5}}},
            {"ratio", ratio},
            {"ratioInterval", {{"low", low}, {"high", high}}},
            {"told", baseline   ? "default"
                     : high < 1 ? "faster"
                     : low > 1  ? "slower"
                                : "not told apart"},
            {"passesMs", {{"transform", ms * 0.1}, {"fill", ms * 0.6}, {"encode", ms * 0.1}}},
            {"error",
             {{"max", error * 4},
              {"maxAt", {200, 100}},
              {"p99", error * 3},
              {"mean", error / 2},
              {"rms", error},
              {"wrongPrimitiveShare", error / 10}}},
            {"errorAtItsSamples", {{"rms", error}, {"unrounded", {{"rms", axis == std::string("specular") ? error / 1000 : error / 10}}}}},
            {"bound", bound},
            {"onFront", front},
            {"onAxisFront", true}};
}

// Bound in JSON with a given largest error, the other figures half of that. The choice may move a colour in linear light by 0.01 up and 0.02 down.
Json bounded(double most) {
    return {{"max", most},
            {"mean", most / 2},
            {"rms", most / 2},
            {"p99", most / 2},
            {"choice", {{"brighter", 0.01}, {"darker", 0.02}, {"steps", 1}}}};
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 2) return 2;
    Json m;
    m["schema"] = "plumb-measure-1";
    m["context"] = {{"device", {{"name", "a device"}, {"type", "cpu"}}},
                    {"cpu", "a processor </script><script>alert(1)</script>"},
                    {"threads", 2},
                    {"load", {0.5, 0.4, 0.3}},
                    {"build", {{"version", "0.1.0"}, {"git", "0123456789abcdef"}}},
                    {"scene", {{"path", "scenes/disc<!--.toml"}, {"triangles", 1234}}},
                    {"size", {kWidth, kHeight}},
                    {"samples", 1},
                    {"repetitions", 5}};
    m["truth"] = {{"kind", "binary64 oracle"}, {"samples", 16}, {"redone", 3}};
    m["rows"] = Json::array({row("shading", "flat", 4, 0.03, nullptr, true), row("shading", "gouraud", 6, 0.011, bounded(0.2), true),
                             row("shading", "phong", 11, 0.002, bounded(0.05), true, true),
                             row("fill", "exact", 11, 0.002, bounded(0.05), false, true), row("samples", "16", 130, 0, nullptr, true),
                             row("specular", "slow", 60, 0.009, bounded(0.15), false),
                             row("control", "default again", 11.2, 0.002, nullptr, true)});
    m["rows"].push_back(
        {{"axis", "trace"}, {"choice", "depth"}, {"absent", true}, {"why", "nothing is traced"}, {"timeMs", nullptr}, {"error", nullptr}});
    m["front"] = Json::array({{{"axis", "shading"}, {"choice", "flat"}}});
    m["telling"] = {{"confidence", 0.95}, {"rows", 5}, {"confidenceOfRow", 0.99}, {"leastRounds", 8}};
    m["notes"] = {"load 7.00 exceeds 2 cores"};
    m["cut"] = Json::array({{{"axis", "samples"}, {"choice", "64"}, {"why", "no time left"}}});
    const ReportPicture truth = disc("", "", 0, 0);
    const std::vector<ReportPicture> pictures = {
        disc("shading", "flat", 4, 1.5),          disc("shading", "gouraud", 12, 0.5), disc("shading", "phong", 60, 0.2),
        disc("fill", "exact", 60, 0.2),           disc("samples", "16", 0, 0),         disc("specular", "slow", 30, 0),
        disc("control", "default again", 60, 0.2)};
    const std::string html = plumb::reportHtml(m, truth, pictures);
    plumb::writeFileAtomically(arguments[1], std::as_bytes(std::span(html)), false);
    std::printf("%zu bytes\n", html.size());
    return 0;
}
