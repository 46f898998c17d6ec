// SPDX-License-Identifier: MIT
// plumb pixel: pixels, polygons and vertices of a picture opened into the chain of the lecture notes. JSON: docs/outputs.md.
#include "pipeline/cli/progress.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/pixel_report.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/viewed_scene.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/image/image.h"
#include "pipeline/pixel/open.h"
#include "pipeline/scene/look_at.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <array>
#include <charconv>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace plumb {
namespace {

// Column and row of "X,Y". Throws Error(usage) for other words.
glm::uvec2 pixelOf(const std::string& word) {
    glm::uvec2 pixel(0);
    const size_t comma = word.find(',');
    const auto whole = [&](std::string_view text, uint32_t& value) {
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        return error == std::errc() && end == text.data() + text.size() && !text.empty();
    };
    if (comma == word.npos || !whole(std::string_view(word).substr(0, comma), pixel.x) ||
        !whole(std::string_view(word).substr(comma + 1), pixel.y))
        throw usageError(fmt::format("'{}' is refused; accepted: a pixel as COLUMN,ROW from the top left, e.g. 320,240", printable(word)));
    return pixel;
}

// Object of --object: by number, or by name. Throws Error(usage), one sentence.
uint32_t objectOf(const Scene& scene, const std::string& word) {
    if (word.empty()) return 0;
    for (uint32_t i = 0; i < scene.objects.size(); ++i)
        if (scene.objects[i].name == word) return i;
    uint32_t number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error == std::errc() && end == word.data() + word.size() && number < scene.objects.size()) return number;
    throw usageError(
        fmt::format("--object: the scene has no object '{}'; it has {}, numbered from 0", printable(word), scene.objects.size()));
}

std::vector<Asked> askedBy(const Options& options, const Scene& scene) {
    std::vector<Asked> all;
    Asked common;
    common.face = options.polygon;
    common.vertex = options.vertex;
    common.object = objectOf(scene, options.object);
    for (size_t i = 1; i < options.inputs.size(); ++i) {
        Asked one = common;
        one.pixel = pixelOf(options.inputs[i]);
        all.push_back(one);
    }
    if (options.ray) {
        common.pixel = glm::uvec2(0);
        common.through = (*options.ray)[1];
    }
    if (all.empty() && (common.face || common.vertex || options.ray)) all.push_back(common);
    return all;
}

// A ray is the picture of one pixel from its start.
void lookAlong(const std::array<glm::dvec3, 2>& ray, ViewedScene& viewed) {
    viewed.scene.camera = lookAt(ray[0], ray[1], viewed.scene.up, 45, viewed.scene.leftHanded);
    viewed.views[0].name = "ray";
    viewed.views[0].camera = *viewed.scene.camera;
}

}  // namespace

Exit pixelCommand(const Options& options) {
    if (!options.jsonFile.empty()) checkWritable(options.jsonFile, false);
    for (size_t i = 1; i < options.inputs.size(); ++i) pixelOf(options.inputs[i]);
    if (options.inputs.size() == 1 && !options.polygon && !options.vertex && !options.ray)
        throw usageError("nothing is asked for: name pixels as COLUMN,ROW, or give --polygon, --vertex or --ray");
    Progress progress(options.progress, options.quiet);
    Options one = options;
    one.inputs = {options.inputs[0]};
    if (options.ray) one.size = glm::uvec2(1, 1), one.shading = Shading::ray;
    ViewedScene viewed = loadOneView(one, progress, "pixel");
    if (options.ray) lookAlong(*options.ray, viewed);
    const Scene& scene = viewed.scene;
    const glm::uvec2 size = viewed.size;
    RenderRequest request = requestOf(one, scene, size);
    request.knobs.keepEverything = true;  // a chain shows also what a plan drops, since that changes no byte
    const std::vector<Asked> asked = askedBy(options, scene);
    for (const Asked& which : asked) checkAsked(scene, request, which);

    Renderer renderer(deviceRequestOf(one));
    for (const std::string& fallback : renderer.fallbacks()) tell(fmt::format("plumb: {}", fallback));
    progress.begin("pixel");
    request.onProgress = [&progress](double fraction) {
        progress.update(fraction);
        return interruptedBy() == 0;
    };
    const std::unique_ptr<PixelOpener> opener = openerOf(renderer.device(), renderer.reason(), scene, request);
    stopIfInterrupted();
    Json pixels = Json::array();
    std::string text;
    for (const Asked& which : asked) {
        stopIfInterrupted();
        const OpenedPixel opened = opener->open(which);
        if (options.json) pixels.push_back(pixelJson(opened));
        if (!options.json || !options.jsonFile.empty()) text += textOf(opened);
    }
    progress.update(1);
    progress.clear();
    renderer.checkValidation();
    FileBatch files;
    std::vector<Json> reports;
    if (options.json) {
        Json report;
        report["tool"] = toolJson();
        report["host"] = hostJson();
        report["device"] = deviceJson(renderer);
        report["scene"] = sceneJson(scene, viewed.sources);
        report["view"] = viewed.views[0].name;
        report["size"] = {size.x, size.y};
        report["options"] = {{"shading", nameOf(request.shading)},
                             {"fill", nameOf(request.fill)},
                             {"samples", request.samples},
                             {"encoding", nameOf(request.encoding)}};
        report["camera"] = cameraJson(*scene.camera);
        report["pixels"] = pixels;
        report["determinism"] = determinismOf(request);
        reports.push_back(report);
    }
    finish(options, files, text, reports);
    return Exit::done;
}

}  // namespace plumb
