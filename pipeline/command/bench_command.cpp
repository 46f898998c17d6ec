// SPDX-License-Identifier: MIT
// plumb bench: rows as text and JSON. A time is reported, never judged; pictures and bytes that disagree are exit 1.
#include "pipeline/bench/claims.h"
#include "pipeline/bench/matrix.h"
#include "pipeline/bench/meshes.h"
#include "pipeline/bench/raster.h"
#include "pipeline/cli/progress.h"
#include "pipeline/command/bench_report.h"
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/command/views.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

Json passesJson(const std::vector<PassTime>& times) {
    Json json = Json::object();
    for (const PassTime& p : times) json[p.pass] = p.ms;
    return json;
}

Json jsonOf(const RasterRow& row) {
    Json json;
    json["name"] = row.name;
    json["triangles"] = row.triangles;
    json["size"] = {row.width, row.height};
    json["pairs"] = row.ratio.count;
    json["resident"] = row.resident;
    json["graphics_ms"] = spreadJson(row.graphicsMs);
    json["compute_ms"] = spreadJson(row.computeMs);
    json["ratio"] = spreadJson(row.ratio);
    json["ratio_of_least"] = row.ratioOfLeast;
    json["passes_ms"] = passesJson(row.passes);
    uint32_t dispatches = 0;
    for (const PassTime& p : row.passes) dispatches += p.dispatches;
    json["dispatches"] = dispatches;
    json["counters"] = countersJson(row.counters);
    const Agreement& a = row.agreement;
    json["agreement"] = {{"covered", a.covered},           {"coverage_differs", a.coverageDiffers},
                         {"unexplained", a.unexplained},   {"furthest_pixels", a.furthestPixels},
                         {"allowed_pixels", kSnapPixels},  {"colour_most", a.colourMost},
                         {"colour_over_4", a.colourOver4}, {"failure", a.failure}};
    return json;
}

Json jsonOf(const PassesRow& row) {
    return {{"name", row.name},
            {"triangles", row.triangles},
            {"lights", row.lights},
            {"size", {row.width, row.height}},
            {"pictures", row.ms.count},
            {"resident", row.resident},
            {"ms", spreadJson(row.ms)},
            {"passes_ms", passesJson(row.passes)},
            {"counters", countersJson(row.counters)}};
}

std::string textOf(const PassesRow& row) {
    return fmt::format("{:<14} {:>9} {:>6} {:>9.2f} [{:.2f}..{:.2f}]{}\n", printable(row.name), row.triangles, row.lights, row.ms.median,
                       row.ms.p10, row.ms.p90, row.resident ? "" : "   in several bands or chunks: it uploads within its time");
}

std::string textOf(const RasterRow& row) {
    const Agreement& a = row.agreement;
    std::string text =
        fmt::format("{:<14} {:>9} {:>9.2f} {:>9.2f}   {:>5.2f} [{:.2f}..{:.2f}]   {:>5.2f}   {}/{} {}/{}\n", printable(row.name),
                    row.triangles, row.graphicsMs.median, row.computeMs.median, row.ratio.median, row.ratio.p10, row.ratio.p90,
                    row.ratioOfLeast, a.coverageDiffers, a.unexplained, a.colourOver4, a.colourMost);
    if (!row.resident) text += "    ours drew in several bands or chunks: it uploads within its time\n";
    if (!a.failure.empty()) text += fmt::format("    PICTURES DISAGREE: {}\n", a.failure);
    return text;
}

Json jsonOf(const MatrixTable& table) {
    Json json;
    json["work"] = table.work;
    json["count"] = table.count;
    json["bytes_each"] = table.bytesEach;
    json["bandwidth_gb_s"] = table.bandwidthGBs;
    json["ceiling"] = table.ceiling;
    json["ways"] = Json::array();
    for (const MatrixWay& way : table.ways)
        json["ways"].push_back({{"name", way.name},
                                {"ms", spreadJson(way.ms)},
                                {"per_second", way.perSecond},
                                {"share_of_bound", way.shareOfBound},
                                {"of_device", way.ofDevice.count == 0 ? Json() : spreadJson(way.ofDevice)},
                                {"partial", way.partial},
                                {"against_glm", way.partial ? Json() : spreadJson(way.againstGlm)},
                                {"products", way.products},
                                {"steps", way.steps},
                                {"error_u", way.partial ? Json() : Json(way.errorU)}});
    json["absent"] = table.absent;
    json["failure"] = table.failure;
    return json;
}

std::string textOf(const MatrixTable& table) {
    std::string text = fmt::format("{} of {}; memory {:.1f} GB/s at this size, {:.0f} bytes each\n", table.work, table.count,
                                   table.bandwidthGBs, table.bytesEach);
    for (const MatrixWay& way : table.ways) {
        text += fmt::format("  {:<54} {:>10.4f} ms [{:.4f}..{:.4f}]  {:>8.4f} G/s  {:>5.1f} % of the bound", way.name, way.ms.median,
                            way.ms.p10, way.ms.p90, way.perSecond * 1e-9, way.shareOfBound * 100);
        if (way.ofDevice.count != 0)
            text += fmt::format("  {:>5.1f} % of the device's ceiling [{:.1f}..{:.1f}]", way.ofDevice.median * 100, way.ofDevice.p10 * 100,
                                way.ofDevice.p90 * 100);
        if (!way.partial)
            text += fmt::format("  {:>6.2f} of GLM [{:.2f}..{:.2f}]  {} products, {} in a row  error {:.2f} u", way.againstGlm.median,
                                way.againstGlm.p10, way.againstGlm.p90, way.products, way.steps, way.errorU);
        text += '\n';
    }
    for (const std::string& line : table.absent) text += fmt::format("  absent: {}\n", line);
    if (!table.failure.empty()) text += fmt::format("  DISAGREES: {}\n", table.failure);
    return text;
}

Scene sceneOf(const std::string& row, glm::uvec2 size, const Options& options) {
    if (std::optional<Scene> made = benchScene(row, double(size.x) / size.y)) return std::move(*made);
    if (row.find('.') == row.npos)
        throw usageError(
            fmt::format("bench: '{}' is no row; accepted: sphereN, knotN, displacedN (N from 1e3 to 1e7), lightsN (N from 1 to 64), "
                        "full-screen, layers-b2f, layers-f2b, a scene or a mesh",
                        printable(row)));
    Options one = options;
    one.inputs = {row};
    const LoadOptions load = loadOptionsOf(options);
    Scene scene = loadScene({row}, load);
    const std::vector<Viewpoint> views = viewsOf(scene, size, one, isBareMesh(row, load));
    scene.camera = views[0].camera;
    scene.lights = views[0].lights;
    return scene;
}

RasterOptions rasterOptionsOf(const Options& options) {
    RasterOptions raster;
    if (options.size) raster.width = options.size->x, raster.height = options.size->y;
    raster.pairs = options.pairs;
    raster.watchdogMs = options.watchdogMs;
    return raster;
}

Exit benchPassesCommand(const Options& options, Renderer& renderer, std::vector<std::string> rows) {
    if (rows.empty()) rows = benchSceneNames();
    RasterOptions raster = rasterOptionsOf(options);
    Progress progress(options.progress, options.quiet);
    raster.onProgress = tellAndListen(progress);
    const bool text = !options.json || !options.jsonFile.empty();
    Json json = benchContextJson(renderer);
    json["bench"] = "passes";
    json["rows"] = Json::array();
    if (text)
        printData(fmt::format("{}\n{}x{}; {} pictures, median [10 %..90 %]\n{:<14} {:>9} {:>6} {:>9}\n", printable(renderer.name()),
                              raster.width, raster.height, raster.pairs, "row", "triangles", "lights", "ms"));
    for (size_t i = 0; i < rows.size(); ++i) {
        progress.begin(fmt::format("bench {}/{}", i + 1, rows.size()), double(i) / double(rows.size()),
                       double(i + 1) / double(rows.size()));
        const PassesRow row = benchPasses(*renderer.device(), sceneOf(rows[i], {raster.width, raster.height}, options), rows[i], raster);
        progress.update(1);
        progress.clear();
        renderer.checkValidation();
        if (text) printData(textOf(row));
        json["rows"].push_back(jsonOf(row));
    }
    json["memory"] = memoryJson(renderer);
    writeJson(options, {json});
    return Exit::done;
}

Exit benchRasterCommand(const Options& options, Renderer& renderer, std::vector<std::string> rows) {
    if (rows.empty()) rows = benchSceneNames();
    RasterOptions raster = rasterOptionsOf(options);
    Progress progress(options.progress, options.quiet);
    raster.onProgress = tellAndListen(progress);
    const bool text = !options.json || !options.jsonFile.empty();
    Json json = benchContextJson(renderer);
    json["bench"] = "raster";
    json["rows"] = Json::array();
    if (text)
        printData(
            fmt::format("{}\n{}x{}, {} pairs; ratio = graphics pipeline / passes, median [10 %..90 %]; coverage: pixels drawn by one side "
                        "only/further than 1/256 px from an edge; "
                        "colour: pixels more than 4 levels apart/most levels\n{:<14} {:>9} {:>9} {:>9}   {:<18}  {:>5}   {}\n",
                        printable(renderer.name()), raster.width, raster.height, raster.pairs, "row", "triangles", "theirs ms", "ours ms",
                        "ratio", "least", "coverage colour"));
    Exit verdict = Exit::done;
    for (size_t i = 0; i < rows.size(); ++i) {
        progress.begin(fmt::format("bench {}/{}", i + 1, rows.size()), double(i) / double(rows.size()),
                       double(i + 1) / double(rows.size()));
        const Scene scene = sceneOf(rows[i], {raster.width, raster.height}, options);
        const RasterRow row = benchRaster(*renderer.device(), scene, rows[i], raster);
        progress.update(1);
        progress.clear();
        renderer.checkValidation();
        if (!row.agreement.failure.empty()) verdict = Exit::overGate;
        if (text) printData(textOf(row));
        json["rows"].push_back(jsonOf(row));
    }
    json["memory"] = memoryJson(renderer);
    writeJson(options, {json});
    return verdict;
}

uint64_t countOf(const std::string& word) {
    double count = 0;
    const char* end = word.data() + word.size();
    if (std::from_chars(word.data(), end, count).ptr != end || !(count >= 1 && count <= 1e8) || count != double(uint64_t(count)))
        throw usageError(fmt::format("bench matrix: '{}' is no count; accepted: a whole number, 1 to 1e8, e.g. 1e6", printable(word)));
    return uint64_t(count);
}

// Count of items from which a benchmark runs fewer rounds: a fifth of those asked for, at least 3, because one round takes longer than a
// second.
constexpr uint64_t kLargeCount = 4000000;

Exit benchMatrixCommand(const Options& options, Renderer& renderer, const std::vector<std::string>& rows) {
    std::vector<uint64_t> vertices, chains;
    for (const std::string& row : rows) vertices.push_back(countOf(row));
    chains = vertices;
    if (rows.empty()) {
        vertices = {1000, 10000, 100000, 1000000, 10000000};
        chains = {7, 1000, 10000, 100000, 1000000};
    }
    Progress progress(options.progress, options.quiet);
    MatrixOptions matrix;
    matrix.threads = options.threads;
    matrix.watchdogMs = options.watchdogMs;
    matrix.onProgress = tellAndListen(progress);
    const bool text = !options.json || !options.jsonFile.empty();
    Json json = benchContextJson(renderer);
    json["bench"] = "matrix";
    json["tables"] = Json::array();
    if (text)
        printData(fmt::format(
            "{}; medians [10 %..90 %] of rounds that run every way in turn; error against long double, u = 2^-24 of the largest entry; "
            "products: of two matrices or a matrix and a vertex, and how many of them wait for one another\n",
            printable(renderer.name())));
    Exit verdict = Exit::done;
    const auto add = [&](const MatrixTable& table) {
        progress.update(1);
        progress.clear();
        renderer.checkValidation();
        if (!table.failure.empty()) verdict = Exit::overGate;
        if (text) printData(textOf(table));
        json["tables"].push_back(jsonOf(table));
    };
    auto part = [&, tables = double(vertices.size() + chains.size()), done = 0](const std::string& task) mutable {
        progress.begin(task, done / tables, (done + 1) / tables);
        ++done;
    };
    const auto rounds = [&](uint64_t count) { return count < kLargeCount ? options.pairs : std::max(3u, options.pairs / 5); };
    for (const uint64_t count : vertices) {
        part(fmt::format("{} vertices", count));
        matrix.rounds = rounds(count);
        add(benchVertices(*renderer.device(), count, matrix));
    }
    for (const uint64_t count : chains) {
        part(fmt::format("a chain of {}", count));
        matrix.rounds = rounds(count);
        add(benchChain(*renderer.device(), count, matrix));
    }
    json["memory"] = memoryJson(renderer);
    writeJson(options, {json});
    return verdict;
}

Json jsonOf(const ClaimTable& table) {
    Json json;
    json["claim"] = table.claim;
    json["says"] = table.says;
    json["measured"] = table.measured;
    json["ways"] = Json::array();
    for (const ClaimWay& way : table.ways) {
        Json one{{"name", way.name}, {"ms", spreadJson(way.ms)}, {"ratio", spreadJson(way.ratio)}, {"counts", Json::object()}};
        for (const auto& [what, count] : way.counts) one["counts"][what] = count;
        json["ways"].push_back(one);
    }
    json["failure"] = table.failure;
    return json;
}

std::string textOf(const ClaimTable& table) {
    std::string text = fmt::format("{}  {}\n    {}\n", table.claim, table.says, table.measured);
    for (const ClaimWay& way : table.ways) {
        std::string counts;
        for (const auto& [what, count] : way.counts) counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count, what);
        text += fmt::format("    {:<28} {:>10.4f} ms [{:.4f}..{:.4f}]  {:>7.2f} of the first [{:.2f}..{:.2f}]  {}\n", way.name,
                            way.ms.median, way.ms.p10, way.ms.p90, way.ratio.median, way.ratio.p10, way.ratio.p90, counts);
    }
    if (!table.failure.empty()) text += fmt::format("    THE COUNT DISAGREES: {}\n", table.failure);
    return text;
}

// Default mesh of the claims, closed and convex: as many triangles as the notes' meshes would have on a screen of today.
constexpr const char* kClaimScene = "sphere1e4";

Exit benchClaimsCommand(const Options& options, Renderer& renderer, const std::vector<std::string>& rows) {
    ClaimOptions claims;
    if (options.size) claims.width = options.size->x, claims.height = options.size->y;
    claims.rounds = options.pairs;
    claims.watchdogMs = options.watchdogMs;
    Progress progress(options.progress, options.quiet);
    claims.onProgress = tellAndListen(progress);
    const std::string row = rows.empty() ? kClaimScene : rows[0];
    if (rows.size() > 1 || !row.starts_with("sphere"))
        throw usageError("bench claims takes one closed convex mesh: sphereN, N from 1e3 to 1e7");
    const Scene scene = sceneOf(row, {claims.width, claims.height}, options);
    progress.begin("bench claims");
    std::vector<ClaimTable> tables = benchTransformClaims(*renderer.device(), claims);
    for (ClaimTable& table : benchClaims(*renderer.device(), scene, claims)) tables.push_back(std::move(table));
    progress.update(1);
    progress.clear();
    renderer.checkValidation();
    const bool text = !options.json || !options.jsonFile.empty();
    Json json = benchContextJson(renderer);
    json["bench"] = "claims";
    json["row"] = row;
    json["size"] = {claims.width, claims.height};
    json["tables"] = Json::array();
    if (text)
        printData(fmt::format("{}\n{} at {}x{}; medians [10 %..90 %] of {} rounds that run every way in turn\n", printable(renderer.name()),
                              row, claims.width, claims.height, claims.rounds));
    Exit verdict = Exit::done;
    for (const ClaimTable& table : tables) {
        if (!table.failure.empty()) verdict = Exit::overGate;
        if (text) printData(textOf(table));
        json["tables"].push_back(jsonOf(table));
    }
    json["memory"] = memoryJson(renderer);
    writeJson(options, {json});
    return verdict;
}

}  // namespace

Exit benchCommand(const Options& options) {
    const std::string& what = options.inputs[0];
    if (what != "raster" && what != "passes" && what != "matrix" && what != "claims" && what != "trace" && what != "plan")
        throw usageError(fmt::format("bench: '{}' is refused; accepted: raster, passes, matrix, claims, trace, plan", printable(what)));
    const std::vector<std::string> rows(options.inputs.begin() + 1, options.inputs.end());
    if (what == "matrix" && options.size) throw usageError("--size is of `plumb bench raster`, `passes`, `claims`, `trace` and `plan`");
    if (what != "plan" && !options.output.empty()) throw usageError("--output is of `plumb bench plan`");
    Renderer renderer(deviceRequestOf(options));
    if (renderer.device() == nullptr) {
        std::string why = renderer.choice().reason;
        for (const std::string& fallback : renderer.fallbacks()) why += fmt::format("; {}", fallback);
        throw deviceError(fmt::format("bench measures a device, and there is none: {}", why));
    }
    if (options.verbose != 0) say(options, fmt::format("device: {}", renderer.choice().reason));
    if (what == "claims") return benchClaimsCommand(options, renderer, rows);
    if (what == "plan") return benchPlanCommand(options, renderer, rows);
    if (what == "trace") return benchTraceCommand(options, renderer, rows);
    if (what == "raster") return benchRasterCommand(options, renderer, rows);
    if (what == "passes") return benchPassesCommand(options, renderer, rows);
    return benchMatrixCommand(options, renderer, rows);
}

}  // namespace plumb
