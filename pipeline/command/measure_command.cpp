// SPDX-License-Identifier: MIT
// plumb measure: every choice against one truth, with its time. JSON: docs/outputs.md and docs/measure.md.
#include "host/binary64.h"
#include "pipeline/cli/progress.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/measure_report.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/viewed_scene.h"
#include "pipeline/command/warnings.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/image/image.h"
#include "pipeline/measure/measure.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/text.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// Share of the limit that writing a report may take.
constexpr double kReportShare = 0.03;

std::vector<const Axis*> axesOf(const Options& options) {
    std::vector<const Axis*> chosen;
    for (const std::string& name : options.axes) {
        const Axis& axis = axisOf(name);
        if (std::find(chosen.begin(), chosen.end(), &axis) == chosen.end()) chosen.push_back(&axis);
    }
    if (chosen.empty())
        for (const Axis& axis : axes()) chosen.push_back(&axis);
    return chosen;
}

}  // namespace

Exit measureCommand(const Options& options) {
    const auto begun = std::chrono::steady_clock::now();
    MeasurePlan plan;
    plan.axes = axesOf(options);
    plan.limitMs = options.limitMs;
    plan.repetitions = options.repetitions;
    plan.seed = options.seed.value_or(0);
    plan.keepPictures = !options.output.empty();
    for (const std::string& file : {options.output, options.jsonFile, options.csvFile})
        if (!file.empty()) checkWritable(file, options.noClobber);
    if (options.json && options.csv && options.jsonFile == options.csvFile)
        throw usageError("--json and --csv both want standard output: name a file for one of them");

    Progress progress(options.progress, options.quiet);
    ViewedScene viewed = loadOneView(options, progress, "measure");
    Scene& scene = viewed.scene;
    const glm::uvec2 size = viewed.size;

    Renderer renderer(deviceRequestOf(options));
    if (!renderer.choice().advice.empty()) say(options, fmt::format("plumb: {}\n{}", renderer.choice().reason, renderer.choice().advice));
    for (const std::string& fallback : renderer.fallbacks()) tell(fmt::format("plumb: {}", fallback));
    plan.deviceThere = renderer.device() != nullptr;
    if (plan.deviceThere) plan.noBinary64 = lacksBinary64(*renderer.device());
    plan.base.request = requestOf(options, scene, size);
    if (!techniqueOf(scene, plan.base.request).showsSurfaces())
        throw usageError("--shading: wire has no truth to be measured against; it is a row of the axis 'shading'");
    refuse(scene, plan.base.request);
    warnOfMovedVertices(options, scene, plan.base.request);
    plan.base.request.onProgress = [](double) { return interruptedBy() == 0; };
    plan.base.twin = !plan.deviceThere;
    plan.draw = [&renderer, &options, first = true](const Scene& drawn, const Setting& setting) mutable {
        stopIfInterrupted();
        // No fallback here: a time of something else would be a lie.
        RenderResult result = setting.twin ? renderCpu(drawn, setting.request) : renderGpu(*renderer.device(), drawn, setting.request);
        if (std::exchange(first, false) && result.frame.coveredPixels == 0) say(options, nothingSeen(result.counters));
        return result;
    };
    progress.begin("measure");
    plan.onProgress = [&progress](double fraction) {
        progress.update(fraction);
        stopIfInterrupted();
    };
    const LoadAverages load = loadAverages();
    plan.beforeMs = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
    if (plan.keepPictures) plan.afterMs = kReportShare * plan.limitMs;
    const Measurement m = measure(scene, plan);
    progress.update(1);
    const LoadAverages loadAfter = loadAverages();
    progress.clear();
    renderer.checkValidation();
    if (plan.keepPictures && !m.truth)
        throw Error(Exit::budget, fmt::format("--limit {:g}s leaves no time for the truth, which the report shows beside the pictures",
                                              plan.limitMs / 1000));
    const std::vector<std::string> notes = notesOf(m, plan, load, loadAfter);

    const std::string title = fmt::format("{} {}x{} on {}", printable(options.inputs[0]), size.x, size.y, renderer.name());
    const std::string table = tableOf(m, title, load, notes), csv = options.csv ? csvOf(m) : "";
    const bool dataElsewhere = (options.json && options.jsonFile.empty()) || (options.csv && options.csvFile.empty());
    FileBatch files;
    if (options.csv && !options.csvFile.empty()) files.add(options.csvFile, std::as_bytes(std::span(csv)), options.noClobber);
    const Json json = measurementJson(m, contextJson(renderer, scene, viewed.sources, plan, m, load, loadAfter), notes);
    if (!options.output.empty()) {
        const std::string html = htmlOf(m, json);
        files.add(options.output, std::as_bytes(std::span(html)), options.noClobber);
    }
    finish(options, files, (dataElsewhere ? "" : table) + (options.csv && options.csvFile.empty() ? csv : ""), {json});
    if (dataElsewhere) say(options, table.substr(0, table.size() - 1));
    return Exit::done;
}

}  // namespace plumb
