// SPDX-License-Identifier: MIT
// plumb stress: how far each extreme can be driven before the picture's error passes a budget. JSON: docs/outputs.md.
#include "pipeline/cli/progress.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/stress_report.h"
#include "pipeline/command/viewed_scene.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/stress/stress.h"

#include <fmt/core.h>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

Exit stressCommand(const Options& options) {
    if (!options.jsonFile.empty()) checkWritable(options.jsonFile, false);
    stress::StressPlan plan;
    plan.axes = stress::rowsOf(options.axes);
    plan.budget = stress::budgetOr(options.error);
    plan.limitMs = options.limitMs;
    Progress progress(options.progress, options.quiet);
    ViewedScene viewed = loadOneView(options, progress, "stress");
    stress::Picture picture{std::move(viewed.scene), {}};
    const Scene& scene = picture.scene;
    picture.request = requestOf(options, scene, viewed.size);
    refuseBelowRounding(plan.budget, picture.request.encoding);
    Renderer renderer(deviceRequestOf(options));
    for (const std::string& fallback : renderer.fallbacks()) tell(fmt::format("plumb: {}", fallback));
    picture.request.onProgress = [](double) { return interruptedBy() == 0; };
    plan.draw = [&renderer](const Scene& drawn, const RenderRequest& request) {
        stopIfInterrupted();
        return renderer.device() == nullptr ? renderCpu(drawn, request) : renderGpu(*renderer.device(), drawn, request);
    };
    progress.begin("stress");
    plan.onProgress = [&progress](double share) {
        progress.update(share);
        stopIfInterrupted();
    };
    const stress::StressReport report = stress::findMargins(picture, plan);
    progress.update(1);
    progress.clear();
    renderer.checkValidation();
    FileBatch files;
    std::vector<Json> reports;
    if (options.json) {
        Json json;
        json["tool"] = toolJson();
        json["host"] = hostJson();
        json["device"] = deviceJson(renderer);
        json["scene"] = sceneJson(scene, viewed.sources);
        json["size"] = {viewed.size.x, viewed.size.y};
        json["camera"] = cameraJson(*scene.camera);
        json["stress"] = stressJson(report);
        reports.push_back(std::move(json));
    }
    finish(options, files, options.json && options.jsonFile.empty() ? "" : stressText(report), reports);
    return report.beyond() ? Exit::overGate : Exit::done;
}

}  // namespace plumb
