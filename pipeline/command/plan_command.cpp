// SPDX-License-Identifier: MIT
// plumb plan: the choices and steps of a picture, their cost and their error, before it is drawn. JSON: docs/outputs.md.
#include "pipeline/cli/progress.h"
#include "pipeline/command/budget_report.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/picture_report.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/viewed_scene.h"
#include "pipeline/command/warnings.h"
#include "pipeline/render/technique.h"

#include <fmt/core.h>
#include <string>

namespace plumb {

Exit planCommand(const Options& options) {
    Progress progress(options.progress, options.quiet);
    ViewedScene viewed = loadOneView(options, progress, "plan");
    const Scene& scene = viewed.scene;
    tellScene(options, scene);
    const RenderRequest base = requestOf(options, scene, viewed.size);
    refuse(scene, base);
    tellLeftToRays(options, scene, base);
    PlannerRequest request = plannerRequestOf(options, base);
    progress.begin("plan", 0, 1, Progress::kMoment);
    request.onProgress = [&progress](double share) {
        progress.update(share);
        return interruptedBy() == 0;
    };
    Renderer renderer(deviceRequestOf(options));
    for (const std::string& fallback : renderer.fallbacks()) tell(fmt::format("plumb: {}", fallback));
    takeCosts(request, renderer, options);
    const PlannedPicture planned = planPicture(scene, request);
    progress.update(1);
    progress.clear();
    const Plan steps = planRender(scene, planned.chosen.request, renderer.device() == nullptr ? RunsOn::twin : RunsOn::device);
    Json sceneReport = sceneJson(scene, viewed.sources);
    MovedVertices moved(options);
    moved.tell(scene, planned.chosen.request, sceneReport);
    moved.tell(steps);
    Json accuracy = accuracyJson(steps);
    moved.addTo(accuracy);
    std::string text = choicesText(request, planned, options.explain);
    Json forecast;
    if (isTraced(base)) {
        if (const std::string rays = raysText(planned); !rays.empty()) text += rays + "\n";
        PlannerRequest chosen = request;
        chosen.base = planned.chosen.request;
        const RayForecast f = forecastRays(scene, chosen);
        text += sentenceOf(f) + "\n";
        forecast = forecastJson(f);
    }
    text += explained(steps);
    if (!options.json || !options.jsonFile.empty()) printData(text);
    writeJson(options, {{{"tool", toolJson()},
                         {"scene", sceneReport},
                         {"camera", cameraJson(*scene.camera)},
                         {"plan", planJson(steps)},
                         {"accuracy", accuracy},
                         {"forecast", forecast},
                         {"budget", budgetJson(request, planned, nullptr, -1)}}});
    return Exit::done;
}

}  // namespace plumb
