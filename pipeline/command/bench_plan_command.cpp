// SPDX-License-Identifier: MIT
// plumb bench plan: of each scene the full plan, the lossless one, and the cheapest choices that keep each budget, timed in turns, with errors.
#include "pipeline/cli/progress.h"
#include "pipeline/command/bench_report.h"
#include "pipeline/command/budget_report.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/measure_report.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/viewed_scene.h"
#include "pipeline/image/file_batch.h"
#include "pipeline/measure/measure.h"
#include "pipeline/planner/planner.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// Budgets of the largest error, in steps of 1/255, and the names of their ways.
constexpr std::pair<double, const char*> kBudgets[] = {{1, "1/255"}, {4, "4/255"}};
// A limit that no measurement reaches.
constexpr double kNoLimitMs = 1e12;
// Share of a row's progress that its truth and its plans take.
constexpr double kPlanningShare = 0.3;

// The picture of a row: its scene as it is drawn.
struct Pictured {
    std::string name;
    ViewedScene viewed;
    RenderRequest base;
    const Scene& scene() const { return viewed.scene; }
};

Pictured picturedOf(const std::string& row, const Options& options, Progress& progress) {
    Options one = options;
    one.inputs = {row};
    Pictured p{row, loadOneView(one, progress, "bench plan"), {}};
    p.base = requestOf(one, p.scene(), p.viewed.size);
    p.base.onProgress = [](double) { return interruptedBy() == 0; };
    refuse(p.scene(), p.base);
    return p;
}

// Without rows: every scene of the folder "scenes".
std::vector<std::string> committedScenes() {
    std::vector<std::string> rows;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator("scenes", none))
        if (entry.path().extension() == ".toml") rows.push_back(entry.path().string());
    if (rows.empty()) throw usageError("bench plan: there is no scenes/*.toml here; name scenes or meshes");
    std::sort(rows.begin(), rows.end());
    return rows;
}

// A way to draw a row's picture.
struct Way {
    std::string name;
    std::optional<Row> row;  // of the measurement; none: absent
    std::string absent;      // why
    std::string choices;     // of a budget
    size_t tried = 0;        // pictures that the budget drew
    std::optional<BudgetFigures> error;
};

class PlanBench {
public:
    PlanBench(const Options& options, Renderer& renderer, size_t rows) : options_(options), renderer_(renderer), rows_(rows) {}

    struct Result {
        Pictured picture;
        Measurement measured;
        MeasurePlan plan;
        Axis budgets;  // `measured` points into it
        std::vector<Way> ways;
        std::vector<std::string> dropped;  // rows of the table of drops that fire
        std::string failure;               // empty: full and lossless plan have the same bytes
        LoadAverages load{}, loadAfter{};
    };

    // `progress`: the row's own task, from 0 to 1; may throw.
    void run(Result& r, const std::function<void(double)>& progress) {
        const RenderRequest& base = r.picture.base;
        const auto draw = [this](const Scene& scene, const RenderRequest& request) {
            stopIfInterrupted();
            return renderGpu(*renderer_.device(), scene, request);
        };
        const bool surfaces = techniqueOf(r.picture.scene(), base).showsSurfaces(), notes = base.fill == Fill::notes;
        std::optional<Checker> checker;
        if (surfaces && !notes)
            checker.emplace(r.picture.scene(), base, CheckPlan{}, [&](double share) {
                progress(kPlanningShare / 2 * share);
                return interruptedBy() == 0;
            });
        std::vector<Way> ofBudgets = plannedWays(r, checker ? &*checker : nullptr, draw);
        progress(kPlanningShare);
        measureWays(r, draw, [&](double share) { progress(kPlanningShare + (1 - kPlanningShare) * share); });
        r.ways = {wayOf(r, "plan", "full"), wayOf(r, "plan", "lossless")};
        if (checker) {
            RenderRequest full = base;
            full.planes |= kCheckedPlanes;
            r.ways[0].error = r.ways[1].error = checker->of(draw(r.picture.scene(), full).frame);
        } else if (surfaces && r.measured.runs[0].alike) {
            r.ways[0].error = r.ways[1].error = figuresOf(*r.measured.runs[0].alike);
        }
        for (Way& way : ofBudgets) {
            way.row = wayOf(r, "budget", way.name).row;
            r.ways.push_back(std::move(way));
        }
        takeDrops(r);
        if (r.ways[0].row && r.measured.runs[*r.ways[0].row->run].bytes != r.measured.runs[0].bytes)
            r.failure = "full and lossless plan draw different bytes";
    }

private:
    // Chooses for each budget; the axis of the budgets then holds their requests.
    std::vector<Way> plannedWays(Result& r, const Checker* checker, const DrawPicture& draw) {
        r.budgets = {"budget", "the cheapest choices whose largest error keeps a limit", {}, Scope::both};
        std::vector<Way> ways;
        for (const auto& [steps, name] : kBudgets) {
            Way way;
            way.name = name;
            std::function<void(Setting&)> apply;
            try {
                PlannerRequest request = plannerRequestOf(options_, r.picture.base);
                request.error.max = steps;
                request.checker = checker;
                request.onProgress = [](double) { return interruptedBy() == 0; };
                takePrices(request);
                const CheckedPicture picture = drawWithinError(r.picture.scene(), request, draw);
                way.choices = picture.plan.chosen.words;
                way.error = picture.got;
                way.tried = picture.tried.size();
                apply = [request = picture.plan.chosen.request](Setting& s) {
                    const std::function<bool(double)> onProgress = s.request.onProgress;
                    s.request = request;
                    s.request.onProgress = onProgress;
                };
            } catch (const Error& error) {
                if (error.exit() != Exit::budget && error.exit() != Exit::usage) throw;
                way.absent = error.what();
            }
            r.budgets.choices.push_back({name, Verdict::bits, apply, apply ? "by the planner" : way.absent});
            ways.push_back(std::move(way));
        }
        return ways;
    }

    // Unit costs of the device, measured once at most.
    void takePrices(PlannerRequest& request) {
        if (!prices_) {
            takeCosts(request, renderer_, options_);
            prices_ = request;
        }
        request.costs = prices_->costs;
        request.twinRay = prices_->twinRay;
        request.pinned.binary64 = prices_->pinned.binary64;
    }

    void measureWays(Result& r, const DrawPicture& draw, const std::function<void(double)>& progress) {
        MeasurePlan& plan = r.plan;
        plan.axes = {&axisOf("plan"), &r.budgets};
        plan.base.request = r.picture.base;
        plan.repetitions = options_.pairs;
        plan.limitMs = kNoLimitMs;
        plan.truthSamples = r.picture.base.samples;
        plan.tables = rows_;
        plan.keepPictures = !options_.output.empty();
        plan.draw = [draw](const Scene& scene, const Setting& setting) { return draw(scene, setting.request); };
        plan.onProgress = progress;
        r.load = loadAverages();
        r.measured = measure(r.picture.scene(), plan);
        r.loadAfter = loadAverages();
    }

    static Way wayOf(const Result& r, const std::string& axis, const std::string& name) {
        Way way;
        way.name = name;
        for (const Row& row : r.measured.rows)
            if (axis == row.axis->name && name == row.choice->name) {
                if (row.run)
                    way.row = row;
                else
                    way.absent = row.why;
            }
        return way;
    }

    static void takeDrops(Result& r) {
        std::set<std::string> names;
        for (const Plan::Drop& drop : planRender(r.picture.scene(), r.picture.base, RunsOn::device).dropped)
            if (!drop.row.empty()) names.insert(drop.row);
        r.dropped.assign(names.begin(), names.end());
    }

    const Options& options_;
    Renderer& renderer_;
    const size_t rows_;
    std::optional<PlannerRequest> prices_;
};

Json jsonOf(const Way& way, const Measurement& m) {
    Json json = {{"name", way.name}, {"absent", way.absent.empty() ? Json() : Json(way.absent)}};
    json["choices"] = way.choices.empty() ? Json() : Json(way.choices);
    json["tried"] = way.tried;
    json["error"] = way.error ? figuresJson(*way.error) : Json();
    json["ms"] = json["of_lossless"] = json["told"] = json["same_as"] = json["on_front"] = Json();
    if (!way.row) return json;
    const MeasuredRun& run = m.runs[*way.row->run];
    json["ms"] = spreadJson(spreadOf(run.total.ms));
    json["on_front"] = way.row->onFront;
    if (run.ratio)
        json["of_lossless"] = {{"median", run.ratio->median},
                               {"low", run.ratio->bounded() ? Json(run.ratio->low) : Json()},
                               {"high", run.ratio->bounded() ? Json(run.ratio->high) : Json()}};
    if (way.row->baseline && way.name != "lossless") json["same_as"] = "lossless";
    json["told"] = way.row->baseline ? "default" : nameOf(run.told);
    return json;
}

Json jsonOf(const PlanBench::Result& r) {
    const RenderRequest& base = r.picture.base;
    Json json = {{"name", r.picture.name},
                 {"shading", nameOf(base.shading)},
                 {"fill", nameOf(base.fill)},
                 {"size", {base.width, base.height}},
                 {"samples", base.samples},
                 {"scene", sceneJson(r.picture.scene(), r.picture.viewed.sources)},
                 {"dropped", r.dropped},
                 {"load", r.load},
                 {"rounds", r.measured.repetitions},
                 {"ways", Json::array()},
                 {"failure", r.failure}};
    for (const Way& way : r.ways) json["ways"].push_back(jsonOf(way, r.measured));
    return json;
}

std::string textOf(const Way& way, const Measurement& m) {
    if (!way.row) return fmt::format("  {:<10} absent: {}\n", way.name, way.absent);
    const MeasuredRun& run = m.runs[*way.row->run];
    const bool is = way.row->baseline;  // the lossless plan
    std::string text = fmt::format("{} {:<10} {:>9.2f} ", way.row->onFront ? '*' : ' ', way.name, medianOf(run.total.ms));
    text += is ? fmt::format("{:>26}  {:<15}", "", way.name == "lossless" ? "" : "the same picture")
               : fmt::format("{:>8.3f} {:>17}  {:<15}", run.ratio ? run.ratio->median : 0, run.ratio ? intervalText(*run.ratio) : "-",
                             nameOf(run.told));
    if (way.error)
        text +=
            fmt::format("  {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f} %", way.error->max, way.error->p99, way.error->rms, 100 * way.error->wrong);
    return text + (way.choices.empty() ? "" : "  " + way.choices) + "\n";
}

std::string textOf(const PlanBench::Result& r) {
    const RenderRequest& base = r.picture.base;
    std::string text = fmt::format("{}: {}, {}x{}, {} sample{}; left out: {}\n", printable(r.picture.name), nameOf(base.shading),
                                   base.width, base.height, base.samples, base.samples == 1 ? "" : "s",
                                   r.dropped.empty() ? "nothing" : fmt::format("{}", fmt::join(r.dropped, ", ")));
    for (const Way& way : r.ways) text += textOf(way, r.measured);
    if (!r.failure.empty()) text += fmt::format("    THE PLANS DISAGREE: {}\n", r.failure);
    return text;
}

}  // namespace

Exit benchPlanCommand(const Options& options, Renderer& renderer, std::vector<std::string> rows) {
    if (rows.empty()) rows = committedScenes();
    if (!options.output.empty() && rows.size() != 1) throw usageError("--output: a report is of one picture: name one ROW");
    if (!options.output.empty()) checkWritable(options.output, options.noClobber);
    Progress progress(options.progress, options.quiet);
    const bool text = !options.json || !options.jsonFile.empty();
    Json json = benchContextJson(renderer);
    json["bench"] = "plan";
    json["budgets"] = Json::array();
    for (const auto& [steps, name] : kBudgets) json["budgets"].push_back({{"name", name}, {"max", steps}});
    json["confidence"] = kConfidenceOfTable;
    json["rows"] = Json::array();
    if (text)
        printData(fmt::format(
            "{}\n{} scenes, {} rounds in random order; ratio: of the lossless plan's time in the same round, median and interval; the "
            "intervals of all scenes hold together in {:g} % of runs\nmax, p99, rms: error against the truth in steps of 1/255, max where "
            "it "
            "decides the face; * on the front of its scene\n  {:<10} {:>9} {:>8} {:>17}  {:<15}  {:>8} {:>8} {:>8} {:>10}  choices\n",
            printable(renderer.name()), rows.size(), options.pairs, 100 * kConfidenceOfTable, "plan", "median ms", "ratio", "interval",
            "than lossless", "max", "p99", "rms", "wrong"));
    Exit verdict = Exit::done;
    FileBatch files;
    PlanBench bench(options, renderer, rows.size());
    for (size_t i = 0; i < rows.size(); ++i) {
        PlanBench::Result result;
        result.picture = picturedOf(rows[i], options, progress);
        if (!options.output.empty() && !techniqueOf(result.picture.scene(), result.picture.base).showsSurfaces())
            throw usageError("--output: a wire frame has no truth that a report could show");
        progress.begin(fmt::format("bench {}/{}", i + 1, rows.size()), double(i) / double(rows.size()),
                       double(i + 1) / double(rows.size()));
        bench.run(result, tellAndListen(progress));
        progress.update(1);
        progress.clear();
        renderer.checkValidation();
        if (!result.failure.empty()) verdict = Exit::overGate;
        if (text) printData(textOf(result));
        json["rows"].push_back(jsonOf(result));
        if (options.output.empty()) continue;
        const Measurement& m = result.measured;
        const Json page = measurementJson(
            m, contextJson(renderer, result.picture.scene(), result.picture.viewed.sources, result.plan, m, result.load, result.loadAfter),
            notesOf(m, result.plan, result.load, result.loadAfter));
        const std::string html = htmlOf(m, page);
        files.add(options.output, std::as_bytes(std::span(html)), options.noClobber);
    }
    json["memory"] = memoryJson(renderer);
    finish(options, files, "", {json});
    return verdict;
}

}  // namespace plumb
