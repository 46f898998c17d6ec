// SPDX-License-Identifier: MIT
// plumb render: load once, draw each view, write each picture whole or not at all.
#include "pipeline/cli/progress.h"
#include "pipeline/command/command.h"
#include "pipeline/command/error_report.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/views.h"
#include "pipeline/image/image.h"
#include "pipeline/measure/axes.h"
#include "pipeline/scene/text.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <future>
#include <set>

namespace plumb {
namespace {

using Clock = std::chrono::steady_clock;
double millisecondsSince(Clock::time_point start) { return std::chrono::duration<double, std::milli>(Clock::now() - start).count(); }

struct OutputFile {
    std::string path;
    std::vector<Aov> aovs;
};

// Where everything goes, decided and checked before anything is drawn.
struct OutputPlan {
    bool sheet = false;                            // all views in one picture
    std::vector<std::vector<OutputFile>> files;    // of each view; of the sheet alone when there is one
    uint32_t planes = kPlaneColour;
    bool transparent = false;
};

std::string extensionOf(const std::string& path) { return path == "-" ? ".png" : std::filesystem::path(path).extension().string(); }

void checkContents(const OutputFile& file, const Options& options) {
    const std::string extension = extensionOf(file.path);
    const bool colourOnly = file.aovs.size() == 1 && file.aovs[0] == Aov::colour;
    if (extension == ".png") {
        if (!colourOnly) throw usageError(fmt::format("--aov: '{}' is a PNG and holds color only; use .exr or .npy", printable(file.path)));
    } else if (extension == ".npy") {
        if (file.aovs.size() != 1) throw usageError(fmt::format("--aov: '{}' holds one plane; use '{{aov}}' in -o, or .exr", printable(file.path)));
    } else if (extension != ".exr") {
        throw usageError(fmt::format("--output: '{}' is refused; accepted: a path that ends in .png, .exr or .npy, or -", printable(file.path)));
    }
    if (options.bits != 8 && extension != ".png") throw usageError("--bits is for .png; .exr and .npy hold float32 and uint32");
}

OutputPlan outputPlanOf(const Options& options, const std::vector<Viewpoint>& views) {
    OutputPlan plan;
    const std::string& pattern = options.output;
    const bool numbered = hasPlaceholder(pattern, "n"), named = hasPlaceholder(pattern, "view");
    if (options.turntable > 1 && !numbered) throw usageError(fmt::format("--turntable makes {} pictures: -o needs '{{n}}', e.g. spin_{{n}}.png", options.turntable));
    plan.sheet = options.turntable == 0 && views.size() > 1 && !numbered && !named;
    if (plan.sheet && extensionOf(pattern) != ".png") throw usageError("several --view make a contact sheet, which is a .png; use '{view}' or '{n}' in -o");

    const std::vector<Aov> aovs = options.aovs.empty() ? std::vector<Aov>{Aov::colour} : options.aovs;
    for (const Aov aov : aovs) plan.planes |= planeOf(aov);
    const auto count = uint32_t(plan.sheet ? 1 : views.size());
    const auto digits = uint32_t(std::to_string(count - 1).size());
    std::set<std::string> paths;
    for (uint32_t i = 0; i < count; ++i) {
        std::vector<OutputFile>& files = plan.files.emplace_back();
        if (hasPlaceholder(pattern, "aov"))
            for (const Aov aov : aovs) files.push_back({filledIn(pattern, {i, digits, views[i].name, nameOf(aov)}), {aov}});
        else
            files.push_back({filledIn(pattern, {i, digits, views[i].name, ""}), aovs});
        for (const OutputFile& file : files) {
            checkContents(file, options);
            checkWritable(file.path, options.noClobber);
            if (!paths.insert(file.path).second) throw usageError(fmt::format("--output: two pictures would be written to '{}'", printable(file.path)));
            if (extensionOf(file.path) == ".exr" && (plan.planes & kPlaneColour) != 0) plan.planes |= kPlaneLinear;
        }
    }
    if (options.bits == 16) plan.planes |= kPlaneLinear;
    plan.transparent = options.background && options.background->transparent;
    if (!options.jsonFile.empty()) {
        if (paths.count(options.jsonFile) != 0) throw usageError("--json and -o name the same file");
        checkWritable(options.jsonFile, options.noClobber);
    }
    return plan;
}

Metadata metadataOf(const std::vector<SourceFile>& sources, const RenderRequest& request, const Viewpoint& view) {
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
    if (request.trade != Trade{}) metadata["trade"] = wordsOf({request, true});
    metadata["camera"] = cameraJson(view.camera).dump();
    metadata["determinism"] = determinismOf(request);
    return metadata;
}

std::string explained(const Plan& plan) {
    std::string text = fmt::format("passes: {}\n", fmt::join(plan.passes, ", "));
    for (const Plan::Drop& drop : plan.dropped) text += fmt::format("dropped: {}: {}\n", drop.what, drop.why);
    for (const std::string& choice : plan.choices) text += fmt::format("choice: {}\n", choice);
    return text;
}

void writePicture(const std::vector<OutputFile>& files, const Frame& frame, const OutputPlan& plan, const Options& options, const RenderRequest& request,
                  const Metadata& metadata) {
    WriteOptions write;
    write.noClobber = options.noClobber;
    write.alpha = plan.transparent;
    write.bits = options.bits;
    write.linear = request.encoding == Encoding::linear;
    for (const OutputFile& file : files) {
        uint32_t planes = 0;
        for (const Aov aov : file.aovs) planes |= planeOf(aov);
        writeFrame(file.path, frame, planes, write, metadata);
    }
}

void refuseFaults(const FrameFacts& facts) {
    if (facts.nan + facts.inf == 0) return;
    throw renderError(fmt::format("the picture has {} NaN and {} infinite values; first: {}; nothing is written", facts.nan, facts.inf, facts.firstFault));
}

Json pictureJson(const Renderer& renderer, const Scene& scene, const std::vector<SourceFile>& sources, const Viewpoint& view, const RenderRequest& request,
                 const RenderResult& result, const FrameFacts& facts, bool blank) {
    Json json;
    json["tool"] = toolJson();
    json["host"] = hostJson();
    json["device"] = renderer.json();
    json["fallback"] = renderer.fallbacks();
    json["scene"] = sceneJson(scene, sources);
    json["view"] = view.name;
    json["camera"] = cameraJson(view.camera);
    json["options"] = {{"shading", nameOf(request.shading)}, {"fill", nameOf(request.fill)}, {"samples", request.samples}, {"encoding", nameOf(request.encoding)}, {"transparent", request.transparent}};
    json["plan"] = planJson(result.plan);
    json["time_ms"] = Json::object();  // filled when the picture is written
    json["image"] = imageJson(result.frame, facts, blank);
    json["counters"] = countersJson(result.counters);
    json["determinism"] = determinismOf(request);
    json["memory"] = memoryJson(renderer);
    return json;
}

}  // namespace

Exit renderCommand(const Options& options) {
    const auto start = Clock::now();
    if (options.output.empty() && !options.explain) throw usageError("-o FILE is missing");
    if (!options.output.empty()) filledIn(options.output, {});

    // Opening a device costs more than loading a small scene, and neither needs the other. A refused input is told first.
    const bool draws = !options.output.empty();
    auto opening = std::async(draws ? std::launch::async : std::launch::deferred, [&options] { return std::make_unique<Renderer>(options); });
    Scene scene = loadScene({options.inputs.begin(), options.inputs.end()}, loadOptionsOf(options));
    const std::vector<SourceFile> sources = sourcesOf(options.inputs);
    const glm::uvec2 size = sizeOf(scene, options);
    const std::vector<Viewpoint> views = viewsOf(scene, size, options);
    const double loadMs = millisecondsSince(start);
    for (const std::string& ignored : scene.ignored) say(options, fmt::format("plumb: not drawn: {}", ignored));
    for (const std::string& warning : scene.warnings) say(options, fmt::format("plumb: warning: {}", warning));

    RenderRequest request = requestOf(options, scene, size);
    scene.camera = views[0].camera;
    scene.lights = views[0].lights;
    if (!draws) {
        const Plan plan = planRender(scene, request);
        if (!options.json || !options.jsonFile.empty()) printData(explained(plan));
        writeJson(options, {{{"tool", toolJson()}, {"scene", sceneJson(scene, sources)}, {"camera", cameraJson(views[0].camera)}, {"plan", planJson(plan)}}});
        return Exit::done;
    }
    const OutputPlan plan = outputPlanOf(options, views);
    request.planes = plan.planes;
    if (options.withError) {
        if (request.shading == Shading::ray) throw usageError("--with-error: the truth of --shading ray is not in this version");
        if (request.shading == Shading::wire) throw usageError("--with-error: a wire frame has no truth: its lines are a drawing, not the picture of a surface");
        request.planes |= kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive;  // which change no byte of the picture
    }

    const std::unique_ptr<Renderer> renderer = opening.get();
    if (!options.quiet && !renderer->choice().advice.empty()) say(options, fmt::format("plumb: {}\n{}", renderer->choice().reason, renderer->choice().advice));
    if (options.verbose != 0) say(options, fmt::format("device: {}", renderer->choice().reason));
    size_t told = 0;
    const auto tellFallbacks = [&] {
        for (; told < renderer->fallbacks().size(); ++told) fmt::print(stderr, "plumb: {}\n", renderer->fallbacks()[told]);
    };
    tellFallbacks();

    Progress progress(options.progress, options.quiet);
    request.onProgress = [&progress](double fraction) {
        progress.update(fraction);
        return interruptedBy() == 0;
    };
    Exit verdict = Exit::done;
    std::vector<Json> reports;
    std::vector<Frame> cells;
    for (size_t i = 0; i < views.size(); ++i) {
        stopIfInterrupted();
        const auto pictureStart = Clock::now();
        scene.camera = views[i].camera;
        scene.lights = views[i].lights;
        progress.begin(views.size() == 1 ? "render" : fmt::format("render {}/{}", i + 1, views.size()));
        RenderResult result = renderer->render(scene, request);
        stopIfInterrupted();
        progress.clear();
        tellFallbacks();
        renderer->checkValidation();
        const FrameFacts facts = factsOf(result.frame, options.json || options.failBlank);
        refuseFaults(facts);
        const bool blank = isBlank(facts, options.failBlank.value_or(0.001));
        const bool refused = blank && options.failBlank;
        if (refused) {
            verdict = Exit::blank;
            fmt::print(stderr, "plumb: the picture is blank ({} of {} pixels covered, {} colours); nothing is written\n", facts.covered, facts.pixels, facts.distinctColours);
        }
        if (options.explain && i == 0) fmt::print(stderr, "{}", explained(result.plan));

        Json report;
        if (options.json) report = pictureJson(*renderer, scene, sources, views[i], request, result, facts, blank);
        double truthMs = 0;
        if (options.withError) {
            progress.begin("truth");
            const Truth truth = truthOf(scene, request);
            stopIfInterrupted();
            progress.clear();
            const FrameError error = errorOf(result.frame, truth, request.encoding, request.transparent);
            const std::optional<Rounding> rounding = roundingOf(scene, request, result.frame);
            say(options, errorLine(error, truth, rounding));
            truthMs = truth.timeMs;
            report["truth"] = truthJson(truth);
            report["error"] = errorJson(error, true, rounding);
        }
        const auto writeStart = Clock::now();
        if (plan.sheet) {
            cells.push_back(std::move(result.frame));
        } else if (!refused) {
            writePicture(plan.files[i], result.frame, plan, options, request, metadataOf(sources, request, views[i]));
        }
        const double writeMs = millisecondsSince(writeStart);
        if (options.json) {
            Json& times = report["time_ms"];
            times["load"] = loadMs;
            times["device"] = renderer->openMs();
            times["passes"] = Json::object();
            for (const PassTime& time : result.times) times["passes"][time.pass] = time.ms;
            times["render"] = result.totalMs;
            if (options.withError) times["truth"] = truthMs;
            times["write"] = writeMs;
            times["total"] = i == 0 ? millisecondsSince(start) : millisecondsSince(pictureStart);
            report["output"] = Json::array();
            if (!refused && verdict == Exit::done)
                for (const OutputFile& file : plan.files[plan.sheet ? 0 : i]) report["output"].push_back(file.path);
            reports.push_back(std::move(report));
        }
        const std::string where = refused ? "nothing written" : plan.sheet ? views[i].name : plan.files[i][0].path;
        say(options, fmt::format("{}: {}x{} {}, {} triangles, {:.1f} ms on {}", printable(where), request.width, request.height, nameOf(request.shading), result.counters.triangles,
                                 result.totalMs, renderer->name()));
        if (options.verbose != 0)
            for (const PassTime& time : result.times) say(options, fmt::format("  {:<12} {:9.3f} ms  {} dispatches", time.pass, time.ms, time.dispatches));
    }
    if (plan.sheet && verdict == Exit::done) {
        const glm::vec3& b = request.background;
        const Frame sheet = contactSheet(cells, 0, backgroundPixel(request), {b.r, b.g, b.b});
        Metadata metadata = metadataOf(sources, request, views[0]);
        metadata.erase("camera");
        std::string names;
        for (const Viewpoint& view : views) names += (names.empty() ? "" : " ") + view.name;
        metadata["views"] = names;
        writePicture(plan.files[0], sheet, plan, options, request, metadata);
        say(options, fmt::format("{}: {} views, {}x{}", printable(plan.files[0][0].path), views.size(), sheet.width, sheet.height));
    }
    writeJson(options, reports);
    return verdict;
}

}  // namespace plumb
