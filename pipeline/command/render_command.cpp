// SPDX-License-Identifier: MIT
// plumb render: load once, draw each view, write each picture whole or not at all.
#include "pipeline/cli/progress.h"
#include "pipeline/command/command.h"
#include "pipeline/command/error_report.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/output_plan.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/stereo.h"
#include "pipeline/command/views.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/image/image.h"
#include "pipeline/measure/axes.h"
#include "pipeline/render/bounds/vertex_error.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <future>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using Clock = std::chrono::steady_clock;
double millisecondsSince(Clock::time_point start) { return std::chrono::duration<double, std::milli>(Clock::now() - start).count(); }

// As on the command line; nothing for the defaults.
std::string raysInWords(const RayChoices& rays) {
    std::string words;
    const auto add = [&](const std::string& word) { words += (words.empty() ? "" : " ") + word; };
    if (rays.sampling != RayChoices::Sampling::grid) add(fmt::format("sampling={}", nameOf(rays.sampling)));
    for (const auto& [name, amount] :
         {std::pair("reflect", rays.jitterReflect), std::pair("refract", rays.jitterRefract), std::pair("shadow", rays.jitterShadow)})
        if (amount > 0) add(fmt::format("jitter.{}={:g}", name, amount));
    if (rays.seed != 0) add(fmt::format("seed={}", rays.seed));
    if (rays.cutLevels) add("levels=cut");
    return words;
}

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
    if (request.wire != WireView::seeThrough) metadata["wire"] = request.wire == WireView::solid ? "solid" : "culled";
    if (request.distantViewer) metadata["viewer"] = "distant";
    if (request.trade != Trade{}) metadata["trade"] = wordsOf({request, true});
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
    for (const Plan::Drop& drop : plan.dropped) text += fmt::format("dropped: {}: {}\n", drop.what, drop.why);
    for (const std::string& choice : plan.choices) text += fmt::format("choice: {}\n", choice);
    return text;
}

// `eye`: of a stereo pair; else every file is of this picture.
void writePicture(FileBatch& batch, const std::vector<OutputFile>& files, const Frame& frame, const OutputPlan& plan,
                  const Options& options, const RenderRequest& request, const Metadata& metadata, std::optional<Eye> eye = std::nullopt) {
    for (const OutputFile& file : files) {
        if (file.eye != eye) continue;
        WriteOptions write;
        write.noClobber = options.noClobber;
        write.alpha = plan.transparent;
        write.bits = options.bits;
        write.linear = request.encoding == Encoding::linear;
        write.grey = file.inks.has_value();
        uint32_t planes = 0;
        for (const Aov aov : file.aovs) planes |= planeOf(aov);
        Metadata own = metadata;
        if (file.eye) own["eye"] = nameOf(*file.eye);
        if (file.field)
            own["field"] = *file.field == Field::odd ? "odd: lines 1, 3, 5, ... of the picture" : "even: lines 2, 4, 6, ... of the picture";
        if (file.inks) own["ink"] = std::string(namesOf(*file.inks)[file.ink]) + ": 255 is full ink";
        if (!file.field && !file.inks) {
            batch.addFrame(file.path, frame, planes, write, own);
            continue;
        }
        const Frame field = file.field ? fieldOf(frame, *file.field) : frame;
        batch.addFrame(file.path, file.inks ? separationOf(field, *file.inks, file.ink) : field, planes, write, own);
    }
}

std::string counted(uint64_t count, const char* thing) { return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s"); }

std::string contentOf(const Scene& scene, const RenderCounters& counters) {
    std::vector<std::string> parts;
    if (!scene.objects.empty()) parts.push_back(counted(counters.triangles, "triangle"));
    if (!scene.spheres.empty()) parts.push_back(counted(scene.spheres.size(), "sphere"));
    if (!scene.planes.empty()) parts.push_back(counted(scene.planes.size(), "plane"));
    return fmt::format("{}", fmt::join(parts, ", "));
}

std::string namesOf(const std::vector<OutputFile>& files) {
    std::vector<std::string> names;
    for (const OutputFile& file : files) names.push_back(printable(file.path));
    return fmt::format("{}", fmt::join(names, ", "));
}

void refuseFaults(const FrameFacts& facts) {
    if (facts.nan + facts.inf == 0) return;
    throw renderError(fmt::format("the picture has {} NaN and {} infinite values; first: {}; nothing is written", facts.nan, facts.inf,
                                  facts.firstFault));
}

Json pictureJson(const Renderer& renderer, const Scene& scene, const std::vector<SourceFile>& sources, const Viewpoint& view,
                 const RenderRequest& request, const RenderResult& result, const FrameFacts& facts, bool blank) {
    Json json;
    json["tool"] = toolJson();
    json["host"] = hostJson();
    json["device"] = renderer.json();
    json["fallback"] = renderer.fallbacks();
    json["scene"] = sceneJson(scene, sources);
    json["view"] = view.name;
    json["camera"] = cameraJson(view.camera);
    json["options"] = {{"shading", nameOf(request.shading)}, {"fill", nameOf(request.fill)},
                       {"samples", request.samples},         {"encoding", nameOf(request.encoding)},
                       {"transparent", request.transparent}, {"viewer", request.distantViewer ? "distant" : "local"}};
    if (request.shading == Shading::ray) json["options"]["rays"] = raysInWords(request.rays);
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
    // What can be refused before a mesh is read.
    if (!options.output.empty() && options.output.find('{') == std::string::npos) checkWritable(options.output, options.noClobber);

    // Opening a device costs more than loading a small scene, and neither needs the other. A refused input is told first.
    const bool draws = !options.output.empty();
    auto opening =
        std::async(draws ? std::launch::async : std::launch::deferred, [&options] { return std::make_unique<Renderer>(options); });
    Progress progress(options.progress, options.quiet);
    const LoadOptions load = loadOptionsOf(options, &progress);
    Scene scene = loadScene({options.inputs.begin(), options.inputs.end()}, load);
    const std::vector<SourceFile> sources = sourcesOf(options.inputs, load);
    const bool bareMesh = isBareMesh(options.inputs[0], load);
    load.once->clear();
    progress.clear();
    const glm::uvec2 size = sizeOf(scene, options);
    const std::vector<Viewpoint> views = viewsOf(scene, size, options, bareMesh);
    const double loadMs = millisecondsSince(start);
    for (const std::string& ignored : scene.ignored) say(options, fmt::format("plumb: not drawn: {}", ignored));
    for (const std::string& warning : scene.warnings) say(options, fmt::format("plumb: warning: {}", warning));

    RenderRequest request = requestOf(options, scene, size);
    scene.camera = views[0].camera;
    scene.lights = views[0].lights;
    refuse(scene, request);
    if (const std::string asked = leftToRays(scene, request); !asked.empty()) {
        if (options.strict)
            throw inputError(printable(scene.path),
                             fmt::format("{}; only --shading ray draws that, and --strict refuses to leave it out", asked));
        say(options, fmt::format("plumb: not drawn: reflection and refraction: {}; only --shading ray traces them", asked));
    }
    if (options.stereo != StereoForm::none && techniqueOf(scene, request).parallel)
        throw usageError("--stereo: --fill notes draws spheres in parallel projection, which shows both eyes the same");
    // Warnings of moved vertices: in the JSON of each view, on standard error once an object.
    std::set<uint32_t> toldMoved;
    const auto tellMoved = [&](Json& sceneReport) {
        for (const VertexError& error : vertexErrors(scene, request)) {
            const std::string sentence = sentenceOf(scene, error);
            sceneReport["warnings"].push_back(sentence);
            if (toldMoved.insert(error.object).second) say(options, fmt::format("plumb: warning: {}", sentence));
        }
    };
    if (!draws) {
        Json sceneReport = sceneJson(scene, sources);
        tellMoved(sceneReport);
        const Plan plan = planRender(scene, request, options.device == "twin" ? RunsOn::twin : RunsOn::device);
        if (!options.json || !options.jsonFile.empty()) printData(explained(plan));
        writeJson(options,
                  {{{"tool", toolJson()}, {"scene", sceneReport}, {"camera", cameraJson(views[0].camera)}, {"plan", planJson(plan)}}});
        return Exit::done;
    }
    const OutputPlan plan = outputPlanOf(options, views, size);
    request.planes = plan.planes;
    if (options.withError) {
        if (options.stereo != StereoForm::none)
            throw usageError("--with-error: the truth is that of one eye; measure each by its own --eye");
        if (!techniqueOf(scene, request).showsSurfaces())
            throw usageError("--with-error: a wire frame has no truth: its lines are a drawing, not the picture of a surface");
        request.planes |= kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive;  // which change no byte of the picture
    }

    const std::unique_ptr<Renderer> renderer = opening.get();
    if (!options.quiet && !renderer->choice().advice.empty())
        say(options, fmt::format("plumb: {}\n{}", renderer->choice().reason, renderer->choice().advice));
    if (options.verbose != 0) say(options, fmt::format("device: {}", renderer->choice().reason));
    size_t told = 0;
    const auto tellFallbacks = [&] {
        for (; told < renderer->fallbacks().size(); ++told) tell(fmt::format("plumb: {}", renderer->fallbacks()[told]));
    };
    tellFallbacks();

    request.onProgress = [&progress](double fraction) {
        progress.update(fraction);
        return interruptedBy() == 0;
    };
    Exit verdict = Exit::done;
    std::vector<Json> reports;
    std::vector<Frame> cells;
    // Pictures that are finished wait for one another, because they are synced together; so do the lines that name them.
    FileBatch batch;
    std::vector<std::string> lines;
    const bool reportOnOutput = options.json && options.jsonFile.empty();
    if (reportOnOutput) expectReader();
    const auto sayLines = [&] {
        for (const std::string& line : lines) say(options, line);
        lines.clear();
    };
    for (size_t i = 0; i < views.size(); ++i) {
        stopIfInterrupted();
        const auto pictureStart = Clock::now();
        scene.camera = views[i].camera;
        scene.lights = views[i].lights;
        const std::string which = views.size() == 1 ? "" : fmt::format(" {}/{}", i + 1, views.size());
        const double begin = double(i) / double(views.size()), end = double(i + 1) / double(views.size());
        const double drawn = options.withError ? (begin + end) / 2 : end;  // where the truth begins
        progress.begin("render" + which, begin, drawn);
        const Stereo stereo(options, views[i].camera, size);
        std::optional<RenderResult> secondEye;  // of a pair
        RenderResult result;
        if (stereo.form == StereoForm::none) {
            result = renderer->render(scene, request);
        } else if (stereo.form == StereoForm::pair) {
            result = renderEye(*renderer, scene, views[i].camera, request, stereo, Eye::left);
            secondEye = renderEye(*renderer, scene, views[i].camera, request, stereo, Eye::right);
        } else {
            result = renderBothEyes(*renderer, scene, views[i].camera, request, stereo);
        }
        stopIfInterrupted();
        progress.update(1);
        progress.clear();
        tellFallbacks();
        renderer->checkValidation();
        const FrameFacts facts = factsOf(result.frame, options.json || options.failBlank);
        refuseFaults(facts);
        if (secondEye) refuseFaults(factsOf(secondEye->frame, false));
        const bool blank = isBlank(facts, options.failBlank.value_or(0.001));
        const bool refused = blank && options.failBlank;
        if (refused) {
            verdict = Exit::blank;
            tell(fmt::format("plumb: the picture is blank ({} of {} pixels covered, {} colours); nothing is written", facts.covered,
                             facts.pixels, facts.distinctColours));
        }
        if (options.explain && i == 0) {
            const std::string text = explained(result.plan);
            tell(text.substr(0, text.size() - 1));
        }

        Json report, sceneReport;
        tellMoved(sceneReport);
        if (options.json) report = pictureJson(*renderer, scene, sources, views[i], request, result, facts, blank);
        if (options.json && stereo.form != StereoForm::none) report["stereo"] = stereo.json();
        if (options.json && sceneReport.contains("warnings"))
            for (const Json& sentence : sceneReport["warnings"]) report["scene"]["warnings"].push_back(sentence);
        double truthMs = 0;
        if (options.withError) {
            progress.begin("truth" + which, drawn, end);
            const Truth truth = truthOf(scene, request);
            stopIfInterrupted();
            progress.update(1);
            progress.clear();
            const FrameError error = errorOf(result.frame, truth, request.encoding, request.transparent);
            const std::optional<Rounding> rounding = roundingOf(scene, request, result.frame);
            say(options, errorLine(error, truth, rounding));
            truthMs = truth.timeMs;
            report["truth"] = truthJson(truth);
            report["error"] = errorJson(error, true, rounding);
        }
        const glm::uvec2 drawnSize(result.frame.width, result.frame.height);
        if (result.frame.coveredPixels == 0 && !refused) say(options, nothingSeen(result.counters));
        const auto writeStart = Clock::now();
        if (plan.sheet) {
            cells.push_back(std::move(result.frame));
        } else if (!refused) {
            const Metadata metadata = metadataOf(sources, request, views[i], stereo);
            writePicture(batch, plan.files[i], result.frame, plan, options, request, metadata,
                         secondEye ? std::optional(Eye::left) : std::nullopt);
            if (secondEye) writePicture(batch, plan.files[i], secondEye->frame, plan, options, request, metadata, Eye::right);
        }
        const double writeMs = millisecondsSince(writeStart);
        if (options.json) {
            const double perSecond = result.totalMs > 0 ? 1000 / result.totalMs : 0;  // of the picture alone, without loading and writing
            report["frame_rate"] = {{"per_second", perSecond}, {"holds_30", perSecond >= 30}, {"holds_60", perSecond >= 60}};
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
        const std::string where = refused ? "nothing written" : plan.sheet ? printable(views[i].name) : namesOf(plan.files[i]);
        const std::string form = stereo.form == StereoForm::none ? "" : fmt::format(" {}", nameOf(stereo.form));
        lines.push_back(fmt::format("{}: {}x{} {}{}{}, {}, {:.1f} ms on {}", where, drawnSize.x, drawnSize.y, nameOf(request.shading), form,
                                    options.interlace ? " in two fields" : "", contentOf(scene, result.counters), result.totalMs,
                                    renderer->name()));
        if (options.verbose != 0)
            for (const PassTime& time : result.times)
                lines.push_back(fmt::format("  {:<12} {:9.3f} ms  {} dispatches", time.pass, time.ms, time.dispatches));
        if (i + 1 == views.size() || !batch.due()) continue;
        if (reportOnOutput) expectReader();
        batch.commit();
        sayLines();
    }
    if (plan.sheet && verdict == Exit::done) {
        const glm::vec3& b = request.background;
        const Frame sheet = contactSheet(cells, 0, backgroundPixel(request), {b.r, b.g, b.b});
        Metadata metadata = metadataOf(sources, request, views[0], Stereo(options, views[0].camera, size));
        metadata.erase("camera");
        std::string names;
        for (const Viewpoint& view : views) names += (names.empty() ? "" : " ") + view.name;
        metadata["views"] = names;
        writePicture(batch, plan.files[0], sheet, plan, options, request, metadata);
        lines.push_back(fmt::format("{}: {} views, {}x{}", printable(plan.files[0][0].path), views.size(), sheet.width, sheet.height));
    }
    finish(options, batch, "", reports);
    sayLines();
    return verdict;
}

}  // namespace plumb
