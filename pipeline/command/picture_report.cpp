// SPDX-License-Identifier: MIT
#include "pipeline/command/picture_report.h"

#include "pipeline/command/request.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <cstdint>
#include <filesystem>
#include <utility>

namespace plumb {
namespace {

// As on the command line; nothing for the defaults.
std::string raysInWords(const RayChoices& rays) {
    std::string words;
    const auto add = [&](const std::string& word) { words += (words.empty() ? "" : " ") + word; };
    if (rays.sampling != RayChoices::Sampling::grid) add(fmt::format("sampling={}", nameOf(rays.sampling)));
    for (const auto& [name, amount] :
         {std::pair("reflect", rays.jitterReflect), std::pair("refract", rays.jitterRefract), std::pair("shadow", rays.jitterShadow)})
        if (amount > 0) add(fmt::format("jitter.{}={:g}", name, amount));
    if (rays.seed != 0) add(fmt::format("seed={}", rays.seed));
    if (rays.cutLevels) add(fmt::format("levels={}", wordOf(kLevelForms, true)));
    return words;
}

std::string counted(uint64_t count, const char* thing) { return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s"); }

}  // namespace

Metadata metadataOf(const std::vector<SourceFile>& sources, const RenderRequest& request, const Viewpoint& view, const Stereo& stereo) {
    // Neither device nor time nor folder: the same scene gives the same file on every machine.
    const Json tool = toolJson();
    Metadata metadata;
    metadata["Software"] = fmt::format("plumb {} ({})", versionText(), tool["git"].get<std::string>());
    std::string names, hashes;
    for (const SourceFile& source : sources) {
        names += (names.empty() ? "" : "\n") + printable(std::filesystem::path(source.path).filename().string());
        hashes += (hashes.empty() ? "" : "\n") + source.sha256;
    }
    metadata["scene"] = names;
    metadata["scene_sha256"] = hashes;
    metadata["shading"] = nameOf(request.shading);
    metadata["fill"] = nameOf(request.fill);
    metadata["samples"] = std::to_string(request.samples);
    metadata["encoding"] = nameOf(request.encoding);
    // Nothing for the default, whose files stay as they are.
    if (request.wire != WireView::seeThrough) metadata["wire"] = nameOf(request.wire);
    if (request.distantViewer) metadata["viewer"] = "distant";
    if (request.trade != Trade{}) metadata["trade"] = wordsOf(request.trade);
    if (const std::string rays = raysInWords(request.rays); !rays.empty()) metadata["rays"] = rays;
    metadata["camera"] = cameraJson(view.camera).dump();
    if (stereo.form != StereoForm::none) metadata["stereo"] = stereo.json().dump();
    metadata["determinism"] = determinismOf(request);
    return metadata;
}

std::string explained(const Plan& plan) {
    std::string text = fmt::format("passes: {}\n", plan.steps.empty() ? "none" : fmt::format("{}", fmt::join(plan.names(), ", ")));
    for (const PlanStep& step : plan.steps) {
        const std::string where = step.fusedIn.empty() ? nameOf(step.side) : "in " + step.fusedIn;
        text += fmt::format("  {:<10} {:<10} {}{}\n", step.name, where, step.why,
                            step.idle.empty() ? "" : fmt::format(" (nothing to do: {})", step.idle));
    }
    for (const Plan::Raise& r : plan.raised) text += fmt::format("{}: {} for {}: {}\n", r.what, r.to, r.of, r.why);
    for (const Plan::Drop& drop : plan.dropped)
        text += fmt::format("dropped: {}: {}{}\n", drop.what, drop.why, drop.saves.empty() ? "" : fmt::format(" (saves {})", drop.saves));
    for (const std::string& choice : plan.choices) text += fmt::format("choice: {}\n", choice);
    return text;
}

std::string contentOf(const Scene& scene, const RenderCounters& counters) {
    std::vector<std::string> parts;
    if (!scene.objects.empty()) parts.push_back(counted(counters.triangles, "triangle"));
    if (!scene.spheres.empty()) parts.push_back(counted(scene.spheres.size(), "sphere"));
    if (!scene.planes.empty()) parts.push_back(counted(scene.planes.size(), "plane"));
    return fmt::format("{}", fmt::join(parts, ", "));
}

Json pictureJson(const Renderer& renderer, const Scene& scene, const std::vector<SourceFile>& sources, const Viewpoint& view,
                 const RenderRequest& request, const RenderResult& result, const FrameFacts& facts, bool blank) {
    Json json;
    json["tool"] = toolJson();
    json["host"] = hostJson();
    json["device"] = deviceJson(renderer);
    json["fallback"] = renderer.fallbacks();
    json["scene"] = sceneJson(scene, sources);
    json["view"] = view.name;
    json["camera"] = cameraJson(view.camera);
    json["options"] = {{"shading", nameOf(request.shading)}, {"fill", nameOf(request.fill)},
                       {"samples", request.samples},         {"encoding", nameOf(request.encoding)},
                       {"transparent", request.transparent}, {"viewer", request.distantViewer ? "distant" : "local"}};
    if (isTraced(request)) json["options"]["rays"] = raysInWords(request.rays);
    json["plan"] = planJson(result.plan);
    json["accuracy"] = accuracyJson(result.plan);
    json["time_ms"] = Json::object();  // filled when the picture is written
    json["image"] = imageJson(result.frame, facts, blank);
    json["counters"] = countersJson(result.counters);
    json["determinism"] = determinismOf(request);
    json["memory"] = memoryJson(renderer);
    return json;
}

}  // namespace plumb
