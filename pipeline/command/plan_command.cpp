// SPDX-License-Identifier: MIT
// plumb plan: the choices and steps of a picture, their cost and their error, before it is drawn. JSON: docs/outputs.md.
#include "pipeline/cli/progress.h"
#include "pipeline/command/budget_report.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/picture_report.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/views.h"
#include "pipeline/render/bounds/vertex_error.h"
#include "pipeline/render/technique.h"

#include <fmt/core.h>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb {

Exit planCommand(const Options& options) {
    if (options.views.size() > 1) throw usageError("plan looks from one viewpoint: give --view once at most");
    Progress progress(options.progress, options.quiet);
    const LoadOptions loading = loadOptionsOf(options, &progress);
    Scene scene = loadScene({options.inputs.begin(), options.inputs.end()}, loading);
    const std::vector<SourceFile> sources = sourcesOf(options.inputs, loading);
    const bool bareMesh = isBareMesh(options.inputs[0], loading);
    loading.once->clear();
    progress.clear();
    const glm::uvec2 size = sizeOf(scene, options);
    const std::vector<Viewpoint> views = viewsOf(scene, size, options, bareMesh);
    scene.camera = views[0].camera;
    scene.lights = views[0].lights;
    const RenderRequest base = requestOf(options, scene, size);
    refuse(scene, base);
    for (const VertexError& error : vertexErrors(scene, base)) {
        scene.warnings.push_back(sentenceOf(scene, error));
        say(options, fmt::format("plumb: warning: {}", scene.warnings.back()));
    }
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
    std::string text = choicesText(request, planned, options.explain);
    Json forecast;
    if (base.shading == Shading::ray) {
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
                         {"scene", sceneJson(scene, sources)},
                         {"camera", cameraJson(views[0].camera)},
                         {"plan", planJson(steps)},
                         {"forecast", forecast},
                         {"budget", budgetJson(request, planned, nullptr, -1)}}});
    return Exit::done;
}

}  // namespace plumb
