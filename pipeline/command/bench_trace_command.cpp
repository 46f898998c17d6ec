// SPDX-License-Identifier: MIT
// plumb bench trace: rows as text and JSON.
#include "pipeline/bench/trace.h"
#include "pipeline/cli/progress.h"
#include "pipeline/command/bench_report.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/scene/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <string>
#include <vector>

namespace plumb {
namespace {

Json jsonOf(const TraceRow& row) {
    Json json;
    json["name"] = row.name;
    json["theirs"] = row.theirs;
    json["objects"] = row.objects;
    json["size"] = {row.width, row.height};
    json["pairs"] = row.ratio.count;
    json["rays"] = row.rays;
    json["feelers"] = row.shadowRays;
    json["ours_ms"] = spreadJson(row.oursMs);
    json["theirs_ms"] = spreadJson(row.theirsMs);
    json["ratio"] = spreadJson(row.ratio);
    json["ratio_of_least"] = row.ratioOfLeast;
    json["rays_per_second"] = double(row.rays + row.shadowRays) / row.oursMs.median * 1000;
    json["dispatch_ms"] = row.longestDispatchMs;
    json["agreement"] = {{"differ", row.differ}, {"allowed_share", row.allowed}, {"failure", row.failure}};
    return json;
}

std::string textOf(const TraceRow& row) {
    std::string text =
        fmt::format("{:<22} {:>8} {:>9.2f} {:>9.2f}   {:>5.2f} [{:.2f}..{:.2f}]   {:>5.2f}   {:>7.2f} {:>8.1f}   {:>6}   {}\n", row.name,
                    row.objects, row.theirsMs.median, row.oursMs.median, row.ratio.median, row.ratio.p10, row.ratio.p90, row.ratioOfLeast,
                    double(row.rays + row.shadowRays) / row.oursMs.median * 1e-3, row.longestDispatchMs, row.differ, row.theirs);
    if (!row.failure.empty()) text += fmt::format("    PICTURES DISAGREE: {}\n", row.failure);
    return text;
}

}  // namespace

Exit benchTraceCommand(const Options& options, Renderer& renderer, std::vector<std::string> rows) {
    const std::vector<std::string> known = traceBenchNames();
    if (rows.empty()) rows = known;
    for (const std::string& row : rows)
        if (std::find(known.begin(), known.end(), row) == known.end())
            throw usageError(fmt::format("bench trace: '{}' is no row; accepted: {}", printable(row), fmt::join(known, ", ")));
    TraceBenchOptions trace;
    if (options.size) trace.width = options.size->x, trace.height = options.size->y;
    trace.pairs = options.pairs;
    trace.threads = options.threads;
    trace.watchdogMs = options.watchdogMs;
    Progress progress(options.progress, options.quiet);
    trace.onProgress = tellAndListen(progress);
    const bool text = !options.json || !options.jsonFile.empty();
    Json json = benchContextJson(renderer);
    json["bench"] = "trace";
    json["rows"] = Json::array();
    if (text)
        printData(
            fmt::format("{}\n{}x{}, {} pairs; ratio = theirs / ours, median [10 %..90 %]; Mray/s of ours, shadow rays "
                        "counted; differ: pixels more than 4 levels or another triangle\n"
                        "{:<22} {:>8} {:>9} {:>9}   {:<18}  {:>5}   {:>7} {:>8}   {:>6}   {}\n",
                        printable(renderer.name()), trace.width, trace.height, trace.pairs, "row", "objects", "theirs ms", "ours ms",
                        "ratio", "least", "Mray/s", "dispatch", "differ", "theirs"));
    Exit verdict = Exit::done;
    std::vector<std::string> absent;
    for (size_t i = 0; i < rows.size(); ++i) {
        progress.begin(fmt::format("bench {}/{}", i + 1, rows.size()), double(i) / double(rows.size()),
                       double(i + 1) / double(rows.size()));
        const std::vector<TraceRow> measured = benchTrace(*renderer.device(), rows[i], trace, absent);
        progress.update(1);
        progress.clear();
        renderer.checkValidation();
        for (const TraceRow& row : measured) {
            if (!row.failure.empty()) verdict = Exit::overGate;
            if (text) printData(textOf(row));
            json["rows"].push_back(jsonOf(row));
        }
    }
    for (const std::string& line : absent)
        if (text) printData(fmt::format("  absent: {}\n", line));
    json["absent"] = absent;
    json["memory"] = memoryJson(renderer);
    writeJson(options, {json});
    return verdict;
}

}  // namespace plumb
