// SPDX-License-Identifier: MIT
// plumb verify: the device against the twin, plane by plane. A difference is a verdict (exit 1), not a failure.
#include "pipeline/cli/progress.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/views.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/image/image.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

namespace fs = std::filesystem;

constexpr double kLoadShare = 0.1;  // of a scene's time; a large one takes more, a small one less

// Channels that differ are at least half bright, whatever the difference; all else is black.
Frame differenceOf(const Frame& a, const Frame& b) {
    Frame difference;
    difference.width = a.width;
    difference.height = a.height;
    difference.rgba.reserve(a.rgba.size());
    for (size_t i = 0; i < a.rgba.size(); ++i) {
        uint32_t pixel = 0xff000000u;
        for (int shift = 0; shift < 24; shift += 8) {
            const int d = std::abs(int(a.rgba[i] >> shift & 0xff) - int(b.rgba[i] >> shift & 0xff));
            if (d != 0) pixel |= uint32_t(128 + d / 2) << shift;
        }
        difference.rgba.push_back(pixel);
    }
    return difference;
}

// -o FOLDER: FOLDER/twin.png; -o FOLDER/NAME.png: FOLDER/NAME.twin.png. With several pictures, each has its own number.
std::vector<std::string> writeEvidence(const Options& options, FileBatch& files, const VerifyReport& report, size_t number, size_t count,
                                       bool transparent) {
    std::vector<std::string> written;
    if (options.output.empty()) return written;
    const fs::path output = options.output;
    const bool folder = fs::is_directory(output);
    const std::string prefix = fmt::format("{}{}", folder ? "" : output.stem().string() + ".", count > 1 ? fmt::format("{}.", number) : "");
    WriteOptions write;
    write.alpha = transparent;
    const auto put = [&](const char* name, const Frame& frame) {
        const fs::path path = (folder ? output : output.parent_path()) / (prefix + name);
        files.addFrame(path, frame, kPlaneColour, write, {{"Software", fmt::format("plumb {} verify", versionText())}});
        written.push_back(path.string());
    };
    put("twin.png", report.twin.frame);
    put("device.png", report.device.frame);
    write.alpha = false;
    put("diff.png", differenceOf(report.twin.frame, report.device.frame));
    return written;
}

std::string textOf(const std::string& title, const VerifyReport& report, const std::vector<std::string>& written) {
    std::string text = fmt::format("{}: {}\n", title, !report.equal ? "DIFFERS" : report.bounded ? "within the bound" : "equal");
    if (report.bounded)
        text += fmt::format("  bound {:.3g} in linear light, {:g} steps of the code: the device's own functions draw\n",
                            std::max({report.boundLinear.x, report.boundLinear.y, report.boundLinear.z}), report.boundSteps);
    for (const auto& [pass, equal] : report.passes) text += fmt::format("  pass  {:<12} {}\n", pass, equal ? "equal" : "differs");
    for (const VerifyPlane& plane : report.planes) {
        const bool equal = plane.differing == 0 && plane.twinSha256 == plane.deviceSha256;
        text += fmt::format("  plane {:<12} {:<7} {}", plane.name, equal ? "equal" : "differs", plane.twinSha256);
        text += equal ? std::string("\n")
                      : fmt::format(" twin\n{:28}{} device, {} elements differ{}\n", "", plane.deviceSha256, plane.differing,
                                    report.bounded ? fmt::format(", {} beyond the bound", plane.beyond) : "");
    }
    for (const Mismatch& m : report.mismatches)
        text += fmt::format("  {}{}: {}\n", m.pass, m.chain ? " (whole chain)" : " (on the twin's input)", m.what);
    for (const std::string& path : written) text += fmt::format("  wrote {}\n", printable(path));
    return text;
}

Json jsonOf(const VerifyReport& report, const std::vector<std::string>& written) {
    Json json;
    json["equal"] = report.equal;
    json["bound"] =
        report.bounded
            ? Json({{"linear", {report.boundLinear.x, report.boundLinear.y, report.boundLinear.z}}, {"steps", report.boundSteps}})
            : Json();
    json["passes"] = Json::array();
    for (const auto& [pass, equal] : report.passes) json["passes"].push_back({{"pass", pass}, {"equal", equal}});
    json["covered_pixels"] = report.twin.frame.coveredPixels;
    json["planes"] = Json::array();
    for (const VerifyPlane& p : report.planes)
        json["planes"].push_back({{"name", p.name},
                                  {"equal", p.differing == 0 && p.twinSha256 == p.deviceSha256},
                                  {"differing", p.differing},
                                  {"beyond", p.beyond},
                                  {"sha256_twin", p.twinSha256},
                                  {"sha256_device", p.deviceSha256}});
    json["mismatches"] = Json::array();
    for (const Mismatch& m : report.mismatches) json["mismatches"].push_back({{"pass", m.pass}, {"chain", m.chain}, {"what", m.what}});
    json["written"] = written;
    return json;
}

}  // namespace

Exit verifyCommand(const Options& options) {
    const auto start = std::chrono::steady_clock::now();
    if (!options.output.empty() && !fs::is_directory(options.output)) {
        if (options.output == "-") throw usageError("--output: '-' is refused; accepted: a folder, or a path that ends in .png");
        checkWritable(fs::path(options.output).parent_path() / "twin.png", false);
    }
    Renderer renderer(options);
    if (renderer.device() == nullptr) {
        std::string why = renderer.choice().reason;
        for (const std::string& fallback : renderer.fallbacks()) why += fmt::format("; {}", fallback);
        if (!renderer.choice().advice.empty()) why += fmt::format("\n{}", renderer.choice().advice);
        throw deviceError(fmt::format("verify compares a device with the twin, and there is no device: {}", why));
    }
    if (options.verbose != 0) say(options, fmt::format("device: {}", renderer.choice().reason));

    // Scene files stand alone; every input is a scene of its own here, so that a folder of meshes is a list of checks.
    Progress progress(options.progress, options.quiet);
    Exit verdict = Exit::done;
    std::vector<Json> reports;
    FileBatch files;                 // evidence
    std::vector<std::string> texts;  // said when the files that they name are there
    const bool reportOnOutput = options.json && options.jsonFile.empty();
    if (reportOnOutput) expectReader();
    const auto sayTexts = [&] {
        for (const std::string& text : texts) say(options, text);
        texts.clear();
    };
    for (size_t i = 0; i < options.inputs.size(); ++i) {
        stopIfInterrupted();
        Options one = options;
        one.inputs = {options.inputs[i]};
        // A scene's load is the first part of its share.
        const double begin = double(i) / double(options.inputs.size()), share = 1 / double(options.inputs.size());
        const double drawn = begin + share * kLoadShare;
        const LoadOptions load = loadOptionsOf(options, &progress, begin, drawn);
        Scene scene = loadScene({one.inputs[0]}, load);
        const std::vector<SourceFile> sources = options.json ? sourcesOf(one.inputs, load) : std::vector<SourceFile>();
        const glm::uvec2 size = sizeOf(scene, one);
        const std::vector<Viewpoint> views = viewsOf(scene, size, one, isBareMesh(one.inputs[0], load));
        RenderRequest request = requestOf(one, scene, size);
        request.onProgress = [&progress](double fraction) {
            progress.update(fraction);
            return interruptedBy() == 0;
        };
        for (size_t v = 0; v < views.size(); ++v) {
            stopIfInterrupted();
            scene.camera = views[v].camera;
            scene.lights = views[v].lights;
            const size_t item = i * views.size() + v, count = options.inputs.size() * views.size();
            const double viewCount = double(views.size()), left = begin + share - drawn;
            progress.begin(fmt::format("verify {}/{}", item + 1, count), drawn + left * double(v) / viewCount,
                           drawn + left * double(v + 1) / viewCount);
            const VerifyReport report = verifyRender(*renderer.device(), scene, request);
            stopIfInterrupted();
            progress.update(1);
            progress.clear();
            renderer.checkValidation();
            if (!report.equal) verdict = Exit::overGate;
            if (report.twin.frame.coveredPixels == 0 && report.device.frame.coveredPixels == 0)
                say(options, nothingSeen(report.twin.counters));
            const std::vector<std::string> written = report.equal
                                                         ? std::vector<std::string>()
                                                         : writeEvidence(options, files, report, i * views.size() + v,
                                                                         options.inputs.size() * views.size(), request.transparent);
            const std::string title = fmt::format("{}{}{} {}x{} {}", printable(one.inputs[0]), views[v].name.empty() ? "" : " ",
                                                  views[v].name, size.x, size.y, nameOf(request.shading));
            const std::string text = textOf(title, report, written);
            if (!reportOnOutput) {
                files.place();
                printData(text);
                files.keep();
            } else {
                texts.push_back(text.substr(0, text.size() - 1));
                if (files.due()) {
                    expectReader();
                    files.commit();
                }
                if (files.empty()) sayTexts();
            }
            if (!options.json) continue;
            Json json;
            json["tool"] = toolJson();
            json["host"] = hostJson();
            json["device"] = renderer.json();
            json["scene"] = sceneJson(scene, sources);
            json["view"] = views[v].name;
            json["size"] = {size.x, size.y};
            json["options"] = {{"shading", nameOf(request.shading)},
                               {"fill", nameOf(request.fill)},
                               {"samples", request.samples},
                               {"encoding", nameOf(request.encoding)}};
            json["verify"] = jsonOf(report, written);
            json["plan"] = planJson(report.device.plan);
            json["time_ms"] = {{"twin", report.twin.totalMs},
                               {"device", report.device.totalMs},
                               {"total", std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count()}};
            json["counters"] = countersJson(report.device.counters);
            json["determinism"] = determinismOf(request);
            json["memory"] = memoryJson(renderer);
            reports.push_back(std::move(json));
        }
    }
    finish(options, files, "", reports);
    sayTexts();
    return verdict;
}

}  // namespace plumb
