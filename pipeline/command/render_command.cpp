// SPDX-License-Identifier: MIT
// plumb render: load once, draw each view, write each picture whole or not at all.
#include "pipeline/cli/progress.h"
#include "pipeline/command/budget_report.h"
#include "pipeline/command/command.h"
#include "pipeline/command/detail_report.h"
#include "pipeline/command/error_report.h"
#include "pipeline/command/flicker.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/output_plan.h"
#include "pipeline/command/picture_report.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/stereo.h"
#include "pipeline/command/viewed_scene.h"
#include "pipeline/command/views.h"
#include "pipeline/command/warnings.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/image/image.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <future>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using Clock = std::chrono::steady_clock;
double millisecondsSince(Clock::time_point start) { return std::chrono::duration<double, std::milli>(Clock::now() - start).count(); }

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
        for (const Plane aov : file.aovs) planes |= aov;
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

struct Loaded : ViewedScene {
    double ms = 0;
    std::optional<Detail> detail = {};  // of --detail

    // What is drawn. The scene itself is what errors are measured against.
    Scene& drawn() { return detail ? detail->scene : scene; }
    const Scene& drawn() const { return detail ? detail->scene : scene; }
    // Takes the camera and the lights of a view.
    void lookFrom(size_t view) {
        scene.camera = views[view].camera;
        scene.lights = views[view].lights;
        if (!detail) return;
        detail->scene.camera = scene.camera;
        detail->scene.lights = scene.lights;
    }
    // Adds what --detail did to a plan.
    void explainDetail(Plan& plan, double pixels) const {
        if (!detail) return;
        for (std::string& line : detail->sentences(pixels)) plan.choices.push_back(std::move(line));
    }
};

// Refuses what can be refused before a mesh is read.
void refuseOutput(const Options& options) {
    if (options.output.empty() && !options.explain) throw usageError("-o FILE is missing");
    if (!options.output.empty()) filledIn(options.output, {});
    if (!options.output.empty() && options.output.find('{') == std::string::npos) checkWritable(options.output, options.noClobber);
}

Loaded load(const Options& options, Progress& progress, Clock::time_point start) {
    Loaded loaded{loadViews(options, progress)};
    loaded.ms = millisecondsSince(start);
    tellScene(options, loaded.scene);
    return loaded;
}

// The request of the first view, or an Error where nothing draws it.
RenderRequest choose(const Options& options, Loaded& loaded) {
    Scene& scene = loaded.scene;
    RenderRequest request = requestOf(options, scene, loaded.size);
    loaded.lookFrom(0);
    refuse(scene, request);
    tellLeftToRays(options, scene, request);
    if (options.stereo != StereoForm::none && techniqueOf(scene, request).parallel)
        throw usageError("--stereo: --fill notes draws spheres in parallel projection, which shows both eyes the same");
    return request;
}

// Asks for the planes that the truth is compared with; they change no byte of the picture.
void askForTruth(const Options& options, const Scene& scene, RenderRequest& request) {
    const char* flag = std::any_of(options.aovs.begin(), options.aovs.end(), [](Plane aov) { return (aov & kPlanesJudged) != 0; })
                           ? "--aov error, certified"
                           : "--with-error";
    if (options.stereo != StereoForm::none)
        throw usageError(fmt::format("{}: the truth is that of one eye; measure each by its own --eye", flag));
    if (!techniqueOf(scene, request).showsSurfaces())
        throw usageError(fmt::format("{}: a wire frame has no truth: its lines are a drawing, not the picture of a surface", flag));
    request.planes |= kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive;
}

void explainOnly(const Options& options, const Loaded& loaded, const RenderRequest& request) {
    Json sceneReport = sceneJson(loaded.scene, loaded.sources);
    Plan plan = planRender(loaded.drawn(), request, options.device == "twin" ? RunsOn::twin : RunsOn::device);
    loaded.explainDetail(plan, options.detail);
    MovedVertices moved(options);
    moved.tell(loaded.drawn(), request, sceneReport);
    moved.tell(plan);
    if (!options.json || !options.jsonFile.empty()) printData(explained(plan));
    Json accuracy = accuracyJson(plan);
    moved.addTo(accuracy);
    Json report = {{"tool", toolJson()},
                   {"scene", sceneReport},
                   {"camera", cameraJson(loaded.views[0].camera)},
                   {"plan", planJson(plan)},
                   {"accuracy", accuracy}};
    if (loaded.detail) report["detail"] = detailJson(*loaded.detail, options.detail, loaded.scene);
    writeJson(options, {report});
}

// Draws, judges and writes the picture of each view.
class Pictures {
public:
    Pictures(const Options& options, Loaded& loaded, RenderRequest request, OutputPlan plan, Renderer& renderer, Progress& progress,
             Clock::time_point start)
        : options_(options),
          loaded_(loaded),
          request_(std::move(request)),
          asked_(request_),
          plan_(std::move(plan)),
          renderer_(renderer),
          progress_(progress),
          start_(start),
          reportOnOutput_(options.json && options.jsonFile.empty()),
          moved_(options),
          flicker_(options.turntable) {
        if (!options_.quiet && !renderer_.choice().advice.empty())
            say(options_, fmt::format("plumb: {}\n{}", renderer_.choice().reason, renderer_.choice().advice));
        if (options_.verbose != 0) say(options_, fmt::format("device: {}", renderer_.choice().reason));
        tellFallbacks();
        request_.onProgress = [this](double fraction) {
            progress_.update(fraction);
            return interruptedBy() == 0;
        };
        asked_.onProgress = request_.onProgress;
        if (reportOnOutput_) expectReader();
    }
    Pictures(const Pictures&) = delete;
    Pictures& operator=(const Pictures&) = delete;

    Exit make() {
        for (size_t i = 0; i < loaded_.views.size(); ++i) {
            makeView(i);
            if (i + 1 == loaded_.views.size() || !batch_.due()) continue;
            if (reportOnOutput_) expectReader();
            batch_.commit();
            sayLines();
        }
        if (plan_.sheet && verdict_ == Exit::done) writeSheet();
        if (options_.flicker) tellFlicker();
        finish(options_, batch_, "", reports_);
        sayLines();
        return verdict_;
    }

private:
    struct Picture {
        size_t view;
        Clock::time_point start;
        Stereo stereo;
        double begin, drawn, end;  // shares of the progress: the drawing, then the truth
        RenderResult result = {};
        std::optional<RenderResult> secondEye = {};  // of a pair
        FrameFacts facts = {};
        bool blank = false, refused = false;
        Json report = {};
        double truthMs = 0, writeMs = 0;
        Json budget = {};  // null without a budget
    };

    void makeView(size_t i) {
        stopIfInterrupted();
        const auto pictureStart = Clock::now();
        loaded_.lookFrom(i);
        const double begin = double(i) / double(loaded_.views.size()), end = double(i + 1) / double(loaded_.views.size());
        Picture p{
            i,  pictureStart, Stereo(options_, loaded_.views[i].camera, loaded_.size), begin, options_.withError ? (begin + end) / 2 : end,
            end};
        draw(p);
        judge(p);
        report(p);
        if (options_.withError) compareWithTruth(p);
        const glm::uvec2 drawnSize(p.result.frame.width, p.result.frame.height);
        if (p.result.frame.coveredPixels == 0 && !p.refused) say(options_, nothingSeen(p.result.counters));
        write(p);
        if (options_.json) completeReport(p);
        addLines(p, drawnSize);
    }

    // " 3/24", as the name of a task ends; nothing for a single view.
    std::string which(const Picture& p) const {
        return loaded_.views.size() == 1 ? "" : fmt::format(" {}/{}", p.view + 1, loaded_.views.size());
    }

    void endTask() {
        stopIfInterrupted();
        progress_.update(1);
        progress_.clear();
    }

    void draw(Picture& p) {
        const Camera& camera = loaded_.views[p.view].camera;
        progress_.begin("render" + which(p), p.begin, p.drawn);
        if (!hasBudget(options_)) tellLongPicture(options_, loaded_.drawn(), request_, renderer_);
        if (hasBudget(options_)) {
            drawWithinBudget(p);
        } else if (p.stereo.form == StereoForm::none) {
            p.result = renderer_.render(loaded_.drawn(), request_);
            loaded_.explainDetail(p.result.plan, options_.detail);
        } else if (p.stereo.form == StereoForm::pair) {
            p.result = renderEye(renderer_, loaded_.scene, camera, request_, p.stereo, Eye::left);
            p.secondEye = renderEye(renderer_, loaded_.scene, camera, request_, p.stereo, Eye::right);
        } else {
            p.result = renderBothEyes(renderer_, loaded_.scene, camera, request_, p.stereo);
        }
        if (options_.flicker) flicker_.add(p.result.frame);
        endTask();
        tellFallbacks();
        renderer_.checkValidation();
    }

    // Draws with the choices that the budget needs; the request is theirs from then on.
    void drawWithinBudget(Picture& p) {
        PlannerRequest budget = plannerRequestOf(options_, asked_);
        budget.onProgress = [](double) { return interruptedBy() == 0; };
        takeCosts(budget, renderer_, options_);
        const DrawPicture draw = [this](const Scene& scene, const RenderRequest& wanted) -> RenderResult {
            RenderRequest request = wanted;
            request.onProgress = asked_.onProgress;
            return renderer_.render(scene, request);
        };
        const bool error = !budget.error.empty();
        CheckedPicture drawn = error ? drawWithinError(loaded_.scene, budget, draw) : drawWithinTime(loaded_.scene, budget, draw);
        const double took = drawn.result.totalMs;
        if (budget.timeMs && took > *budget.timeMs)
            throw Error(Exit::budget, fmt::format("'{}' keeps {} and took {:.3g} ms, beyond --time {:g} ms; nothing is written",
                                                  drawn.plan.chosen.words, wordsOf(budget.error), took, *budget.timeMs));
        p.budget = budgetJson(budget, drawn.plan, &drawn, took);
        lines_.push_back(error ? budgetLine(budget, drawn) : timeLine(budget, drawn.plan, took));
        request_ = drawn.plan.chosen.request;
        p.result = std::move(drawn.result);
        request_.onProgress = asked_.onProgress;
    }

    // Throws where a value is not finite; a blank picture is refused with --fail-blank.
    void judge(Picture& p) {
        p.facts = factsOf(p.result.frame, options_.json || options_.failBlank);
        refuseFaults(p.facts);
        if (p.secondEye) refuseFaults(factsOf(p.secondEye->frame, false));
        p.blank = isBlank(p.facts, options_.failBlank.value_or(0.001));
        p.refused = p.blank && options_.failBlank;
        if (p.refused) {
            verdict_ = Exit::blank;
            tell(fmt::format("plumb: the picture is blank ({} of {} pixels covered, {} colours); nothing is written", p.facts.covered,
                             p.facts.pixels, p.facts.distinctColours));
        }
    }

    void report(Picture& p) {
        if (options_.explain && p.view == 0) {
            const std::string text = explained(p.result.plan);
            tell(text.substr(0, text.size() - 1));
        }
        Json sceneReport;
        moved_.tell(loaded_.drawn(), request_, sceneReport);
        moved_.tell(p.result.plan);
        if (!options_.json) return;
        p.report = pictureJson(renderer_, loaded_.scene, loaded_.sources, loaded_.views[p.view], request_, p.result, p.facts, p.blank);
        moved_.addTo(p.report["accuracy"]);
        if (loaded_.detail) p.report["detail"] = detailJson(*loaded_.detail, options_.detail, loaded_.scene);
        if (p.stereo.form != StereoForm::none) p.report["stereo"] = p.stereo.json();
        if (!p.budget.is_null()) p.report["budget"] = p.budget;
        if (sceneReport.contains("warnings"))
            for (const Json& sentence : sceneReport["warnings"]) p.report["scene"]["warnings"].push_back(sentence);
    }

    void compareWithTruth(Picture& p) {
        progress_.begin("truth" + which(p), p.drawn, p.end);
        Truth truth = truthOf(loaded_.scene, request_);
        if (loaded_.detail) forgetFaces(truth, loaded_.detail->redrawn);
        endTask();
        const FrameError error = errorOf(p.result.frame, truth, request_.encoding, request_.transparent);
        const std::optional<Rounding> rounding = roundingOf(loaded_.drawn(), request_, p.result.frame);
        say(options_, errorLine(error, truth, rounding));
        p.truthMs = truth.timeMs;
        p.report["truth"] = truthJson(truth);
        p.report["error"] = errorJson(error, true, rounding);
        Certificate certificate = certificateOf(p.result.frame, truth, request_.encoding, request_.transparent);
        say(options_, certificateLine(certificate));
        p.report["certificate"] = certificateJson(certificate);
        if (plan_.planes & kPlaneError) p.result.frame.error = std::move(certificate.steps);
        if (plan_.planes & kPlaneCertified) p.result.frame.certified = std::move(certificate.grades);
    }

    // Hands the frame to the batch of files, or to the sheet.
    void write(Picture& p) {
        const auto writeStart = Clock::now();
        if (plan_.sheet) {
            cells_.push_back(std::move(p.result.frame));
        } else if (!p.refused) {
            const Metadata metadata = metadataOf(loaded_.sources, request_, loaded_.views[p.view], p.stereo);
            writePicture(batch_, plan_.files[p.view], p.result.frame, plan_, options_, request_, metadata,
                         p.secondEye ? std::optional(Eye::left) : std::nullopt);
            if (p.secondEye) writePicture(batch_, plan_.files[p.view], p.secondEye->frame, plan_, options_, request_, metadata, Eye::right);
        }
        p.writeMs = millisecondsSince(writeStart);
    }

    void completeReport(Picture& p) {
        const double perSecond = p.result.totalMs > 0 ? 1000 / p.result.totalMs : 0;  // of the picture alone, without loading and writing
        p.report["frame_rate"] = {{"per_second", perSecond}, {"holds_30", perSecond >= 30}, {"holds_60", perSecond >= 60}};
        Json& times = p.report["time_ms"];
        times["load"] = loaded_.ms;
        if (loaded_.detail) times["detail"] = loaded_.detail->ms;
        times["device"] = renderer_.openMs();
        times["passes"] = Json::object();
        for (const PassTime& time : p.result.times) times["passes"][time.pass] = time.ms;
        times["render"] = p.result.totalMs;
        if (options_.withError) times["truth"] = p.truthMs;
        times["write"] = p.writeMs;
        times["total"] = p.view == 0 ? millisecondsSince(start_) : millisecondsSince(p.start);
        p.report["output"] = Json::array();
        if (!p.refused && verdict_ == Exit::done)
            for (const OutputFile& file : plan_.files[plan_.sheet ? 0 : p.view]) p.report["output"].push_back(file.path);
        reports_.push_back(std::move(p.report));
    }

    void addLines(const Picture& p, glm::uvec2 drawnSize) {
        const std::string where = p.refused     ? "nothing written"
                                  : plan_.sheet ? printable(loaded_.views[p.view].name)
                                                : namesOf(plan_.files[p.view]);
        const std::string form = p.stereo.form == StereoForm::none ? "" : fmt::format(" {}", nameOf(p.stereo.form));
        lines_.push_back(fmt::format("{}: {}x{} {}{}{}, {}, {:.1f} ms on {}", where, drawnSize.x, drawnSize.y, nameOf(request_.shading),
                                     form, options_.interlace ? " in two fields" : "", contentOf(loaded_.scene, p.result.counters),
                                     p.result.totalMs, renderer_.name()));
        if (options_.verbose != 0)
            for (const PassTime& time : p.result.times)
                lines_.push_back(fmt::format("  {:<12} {:9.3f} ms  {} dispatches", time.pass, time.ms, time.dispatches));
    }

    void writeSheet() {
        const glm::vec3& b = request_.background;
        const Frame sheet = contactSheet(cells_, 0, backgroundPixel(request_), {b.r, b.g, b.b});
        const std::vector<Viewpoint>& views = loaded_.views;
        Metadata metadata = metadataOf(loaded_.sources, request_, views[0], Stereo(options_, views[0].camera, loaded_.size));
        metadata.erase("camera");
        std::string names;
        for (const Viewpoint& view : views) names += (names.empty() ? "" : " ") + view.name;
        metadata["views"] = names;
        writePicture(batch_, plan_.files[0], sheet, plan_, options_, request_, metadata);
        lines_.push_back(fmt::format("{}: {} views, {}x{}", printable(plan_.files[0][0].path), views.size(), sheet.width, sheet.height));
    }

    // The figure of a whole turn, in the report of its last picture.
    void tellFlicker() {
        lines_.push_back(flicker_.line());
        if (!reports_.empty()) reports_.back()["flicker"] = flicker_.json();
    }

    void tellFallbacks() {
        for (; told_ < renderer_.fallbacks().size(); ++told_) tell(fmt::format("plumb: {}", renderer_.fallbacks()[told_]));
    }

    void sayLines() {
        for (const std::string& line : lines_) say(options_, line);
        lines_.clear();
    }

    const Options& options_;
    Loaded& loaded_;
    RenderRequest request_, asked_;  // as drawn; as the flags and the scene ask
    const OutputPlan plan_;
    Renderer& renderer_;
    Progress& progress_;
    const Clock::time_point start_;
    const bool reportOnOutput_;
    MovedVertices moved_;
    Flicker flicker_;
    size_t told_ = 0;  // fallbacks
    Exit verdict_ = Exit::done;
    std::vector<Json> reports_;
    std::vector<Frame> cells_;
    // Pictures that are finished wait for one another, because they are synced together; so do the lines that name them.
    FileBatch batch_;
    std::vector<std::string> lines_;
};

}  // namespace

Exit renderCommand(const Options& options) {
    const auto start = Clock::now();
    refuseOutput(options);
    // Opening a device costs more than loading a small scene, and neither needs the other. A refused input is told first.
    const bool draws = !options.output.empty();
    auto opening = std::async(draws ? std::launch::async : std::launch::deferred,
                              [&options] { return std::make_unique<Renderer>(deviceRequestOf(options)); });
    Progress progress(options.progress, options.quiet);
    Loaded loaded = load(options, progress, start);
    RenderRequest request = choose(options, loaded);
    if (!draws && hasBudget(options)) throw usageError("--error and --time choose a picture to draw: give -o FILE, or ask `plumb plan`");
    if (options.detail > 0) {
        loaded.detail = detailOf(options, loaded.scene, loaded.size, loaded.views, progress);
        loaded.lookFrom(0);
        if (!options.explain && !options.json)
            for (const std::string& line : loaded.detail->sentences(options.detail)) say(options, line);
    }
    if (!draws) {
        explainOnly(options, loaded, request);
        return Exit::done;
    }
    if (hasBudget(options)) plannerRequestOf(options, request);  // refuses what cannot be kept before a device is opened
    OutputPlan plan = outputPlanOf(options, loaded.views, loaded.size);
    request.planes = plan.planes & ~uint32_t(kPlanesJudged);
    if (options.withError) askForTruth(options, loaded.scene, request);
    if (options.flicker) request.planes |= kPlaneObject;
    const std::unique_ptr<Renderer> renderer = opening.get();
    return Pictures(options, loaded, std::move(request), std::move(plan), *renderer, progress, start).make();
}

}  // namespace plumb
