// SPDX-License-Identifier: MIT
// plumb verify: the device against the twin, plane by plane. A difference is a verdict (exit 1), not a failure.
#include "pipeline/cli/progress.h"
#include "pipeline/command/capsules.h"
#include "pipeline/command/command.h"
#include "pipeline/command/detail_report.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/suite_command.h"
#include "pipeline/command/views.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/image/image.h"
#include "pipeline/scene/text.h"
#include "pipeline/suite/reduce.h"

#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
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

Json jsonOf(const VerifyReport& report, const std::vector<std::string>& written, const std::string& capsule) {
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
    json["capsule"] = capsule.empty() ? Json() : Json(capsule);
    return json;
}

void refuseOutput(const Options& options) {
    if (options.output.empty() || fs::is_directory(options.output)) return;
    if (options.output == "-") throw usageError("--output: '-' is refused; accepted: a folder, or a path that ends in .png");
    checkWritable(fs::path(options.output).parent_path() / "twin.png", false);
}

void refuseTwinAlone(Renderer& renderer) {
    if (renderer.device() != nullptr) return;
    std::string why = renderer.choice().reason;
    for (const std::string& fallback : renderer.fallbacks()) why += fmt::format("; {}", fallback);
    if (!renderer.choice().advice.empty()) why += fmt::format("\n{}", renderer.choice().advice);
    throw deviceError(fmt::format("verify compares a device with the twin, and there is no device: {}", why));
}

// Checks pictures one by one. Scene files stand alone; every input is a scene of its own here, so that a folder of meshes is a list of
// checks.
class Checks {
public:
    Checks(const Options& options, Renderer& renderer, std::chrono::steady_clock::time_point start)
        : options_(options), renderer_(renderer), start_(start), progress_(options.progress, options.quiet) {
        if (reportOnOutput_) expectReader();
    }

    Exit make() {
        for (size_t i = 0; i < options_.inputs.size(); ++i) checkInput(i);
        finish(options_, files_, "", reports_);
        sayTexts();
        return verdict_;
    }

private:
    // One input and its pictures.
    struct Input {
        std::string path;
        Scene scene;
        std::vector<SourceFile> sources;
        glm::uvec2 size{0};
        std::vector<Viewpoint> views;
        RenderRequest request;
        std::optional<Detail> detail;
        size_t firstNumber = 0, count = 0;  // of its pictures, and of all
    };

    void checkInput(size_t i) {
        stopIfInterrupted();
        Options one = options_;
        one.inputs = {options_.inputs[i]};
        // A scene's load is the first part of its share.
        const double begin = double(i) / double(options_.inputs.size()), share = 1 / double(options_.inputs.size());
        const double drawn = begin + share * kLoadShare;
        const LoadOptions load = loadOptionsOf(options_, &progress_, begin, drawn);
        Input input;
        input.path = one.inputs[0];
        input.scene = loadScene({one.inputs[0]}, load);
        if (options_.json) input.sources = sourcesOf(one.inputs, load);
        input.size = sizeOf(input.scene, one);
        input.views = viewsOf(input.scene, input.size, one, isBareMesh(one.inputs[0], load));
        input.request = requestOf(one, input.scene, input.size);
        input.request.onProgress = [this](double fraction) {
            progress_.update(fraction);
            return interruptedBy() == 0;
        };
        if (options_.detail > 0) {
            input.detail = detailOf(options_, input.scene, input.size, input.views, progress_, begin, drawn);
            input.scene = input.detail->scene;
            if (!options_.json)
                for (const std::string& line : input.detail->sentences(options_.detail)) say(options_, line);
        }
        input.firstNumber = i * input.views.size();
        input.count = options_.inputs.size() * input.views.size();
        const double viewCount = double(input.views.size()), left = begin + share - drawn;
        for (size_t v = 0; v < input.views.size(); ++v)
            checkView(input, v, drawn + left * double(v) / viewCount, drawn + left * double(v + 1) / viewCount);
    }

    void checkView(Input& input, size_t v, double begin, double end) {
        stopIfInterrupted();
        const Viewpoint& view = input.views[v];
        const size_t number = input.firstNumber + v;
        input.scene.camera = view.camera;
        input.scene.lights = view.lights;
        progress_.begin(fmt::format("verify {}/{}", number + 1, input.count), begin, end);
        const VerifyReport report = verified(input, number);
        stopIfInterrupted();
        progress_.update(1);
        progress_.clear();
        renderer_.checkValidation();
        if (!report.equal) verdict_ = Exit::overGate;
        if (report.twin.frame.coveredPixels == 0 && report.device.frame.coveredPixels == 0)
            say(options_, nothingSeen(report.twin.counters));
        std::vector<std::string> written;
        if (!report.equal) written = writeEvidence(options_, files_, report, number, input.count, input.request.transparent);
        const std::string capsule = report.equal ? "" : keepCapsule(input, number, report.mismatches[0].pass);
        const std::string title = fmt::format("{}{}{} {}x{} {}", printable(input.path), view.name.empty() ? "" : " ", view.name,
                                              input.size.x, input.size.y, nameOf(input.request.shading));
        tellText(textOf(title, report, written));
        if (options_.json) reports_.push_back(reportOf(input, view, report, written, capsule));
    }

    // A device that fails is a difference too, which a capsule can hold.
    VerifyReport verified(const Input& input, size_t number) {
        try {
            return verifyRender(*renderer_.device(), input.scene, input.request);
        } catch (const Error& error) {
            if (error.exit() == Exit::failed && !options_.capsule.empty())
                keepCapsule(input, number, suite::differingPass(*renderer_.device(), input.scene, input.request));
            throw;
        }
    }

    // Folder of the capsule that it made; empty where none is asked for, or none was made.
    std::string keepCapsule(const Input& input, size_t number, const std::string& pass) {
        if (options_.capsule.empty()) return "";
        fs::path folder = options_.capsule;
        if (input.count > 1) folder /= std::to_string(number);
        progress_.begin("reduce", 0, 1);
        const std::string line = writeCapsule(options_, *renderer_.device(), input.scene, input.request, pass, folder, progress_);
        progress_.clear();
        say(options_, line);
        return fs::exists(folder / "capsule.json") ? folder.string() : "";
    }

    // Prints the text when the files that it names are there.
    void tellText(const std::string& text) {
        if (!reportOnOutput_) {
            files_.place();
            printData(text);
            files_.keep();
            return;
        }
        texts_.push_back(text.substr(0, text.size() - 1));
        if (files_.due()) {
            expectReader();
            files_.commit();
        }
        if (files_.empty()) sayTexts();
    }

    void sayTexts() {
        for (const std::string& text : texts_) say(options_, text);
        texts_.clear();
    }

    Json reportOf(const Input& input, const Viewpoint& view, const VerifyReport& report, const std::vector<std::string>& written,
                  const std::string& capsule) const {
        const RenderRequest& request = input.request;
        Json json;
        json["tool"] = toolJson();
        json["host"] = hostJson();
        json["device"] = deviceJson(renderer_);
        json["scene"] = sceneJson(input.scene, input.sources);
        json["view"] = view.name;
        json["size"] = {input.size.x, input.size.y};
        json["options"] = {{"shading", nameOf(request.shading)},
                           {"fill", nameOf(request.fill)},
                           {"samples", request.samples},
                           {"encoding", nameOf(request.encoding)}};
        json["verify"] = jsonOf(report, written, capsule);
        json["plan"] = planJson(report.device.plan);
        json["time_ms"] = {{"twin", report.twin.totalMs},
                           {"device", report.device.totalMs},
                           {"total", std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count()}};
        json["counters"] = countersJson(report.device.counters);
        if (input.detail) json["detail"] = detailJson(*input.detail, options_.detail, input.scene);
        json["determinism"] = determinismOf(request);
        json["memory"] = memoryJson(renderer_);
        return json;
    }

    const Options& options_;
    Renderer& renderer_;
    const std::chrono::steady_clock::time_point start_;
    Progress progress_;
    const bool reportOnOutput_ = options_.json && options_.jsonFile.empty();
    Exit verdict_ = Exit::done;
    std::vector<Json> reports_;
    FileBatch files_;                 // evidence
    std::vector<std::string> texts_;  // said when the files that they name are there
};

}  // namespace

Exit verifyCommand(const Options& options) {
    const auto start = std::chrono::steady_clock::now();
    if (options.suite) return suiteCommand(options);
    refuseOutput(options);
    refuseCapsuleFolder(options);
    Renderer renderer(deviceRequestOf(options));
    refuseTwinAlone(renderer);
    if (options.verbose != 0) say(options, fmt::format("device: {}", renderer.choice().reason));
    return Checks(options, renderer, start).make();
}

}  // namespace plumb
