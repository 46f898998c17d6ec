// SPDX-License-Identifier: MIT
// plumb matrix: a chain of transforms, its matrix after each step, its composite, and the same chain as a tree of products.
#include "pipeline/command/command.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/command/matrix_steps.h"
#include "pipeline/command/report.h"
#include "pipeline/command/request.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/render/stopwatch.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using glm::dmat3;
using glm::dmat4;
using glm::dvec2;
using glm::dvec3;

template <class Matrix>
struct PointOf;
template <>
struct PointOf<dmat3> {
    using Type = dvec2;
};
template <>
struct PointOf<dmat4> {
    using Type = dvec3;
};

// Matrix as printed, in the requested notation and handedness.
template <class Matrix>
Matrix shown(const Options& options, const Matrix& m) {
    Matrix result = m;
    if constexpr (std::is_same_v<Matrix, dmat4>)
        if (options.zReversed) result = withZReversed(result);
    return options.rowNotation ? rowForm(result) : result;
}

template <class Matrix>
Json matrixJson(const Options& options, const Matrix& m) {
    const Matrix s = shown(options, m);
    Json rows = Json::array();
    for (int row = 0; row < Matrix::length(); ++row) {
        Json line = Json::array();
        for (int column = 0; column < Matrix::length(); ++column) line.push_back(s[column][row] + 0.0);  // -0 becomes 0
        rows.push_back(line);
    }
    return rows;
}

std::string textOfMatrix(const Json& rows) {
    std::string text;
    for (const Json& row : rows) {
        text += "   ";
        for (const Json& entry : row) text += fmt::format(" {:>12.7g}", entry.get<double>());
        text += "\n";
    }
    return text;
}

template <class Point>
Json pointJson(const Point& p) {
    Json json = Json::array();
    for (int i = 0; i < Point::length(); ++i) json.push_back(p[i] + 0.0);
    return json;
}

template <class Matrix>
double largestDifference(const Matrix& a, const Matrix& b) {
    double largest = 0;
    for (int column = 0; column < Matrix::length(); ++column)
        for (int row = 0; row < Matrix::length(); ++row) largest = std::max(largest, std::abs(a[column][row] - b[column][row]));
    return largest;
}

// Random points in [0, 1), the same on every machine.
template <class Point>
std::vector<Point> manyPoints(uint64_t count) {
    std::vector<Point> points(count);
    uint64_t state = 0x9e3779b97f4a7c15u;
    for (Point& point : points)
        for (int i = 0; i < Point::length(); ++i) {
            state ^= state << 13, state ^= state >> 7, state ^= state << 17;
            point[i] = double(state >> 11) * 0x1p-53;
        }
    return points;
}

Json chainCountersJson(const ChainCounters& counters, double timeMs) {
    return {
        {"products", counters.products}, {"applications", counters.applications}, {"equations", counters.equations}, {"time_ms", timeMs}};
}

// Vertices three ways, counted and timed: each step on its own, the composite, the composite on several threads.
template <class Matrix>
Json verticesJson(const Options& options, std::span<const Step<Matrix>> chain, size_t depth) {
    using Point = typename PointOf<Matrix>::Type;
    const std::vector<Point> start = manyPoints<Point>(options.vertices);
    std::vector<Point> separately = start, together = start, parallel = start;
    Json json;
    json["vertices"] = options.vertices;
    {
        ChainCounters counters;
        const Stopwatch watch(nullptr, "");
        for (const Step<Matrix>& step : chain) apply(step.matrix, std::span<Point>(separately), counters);
        json["separate"] = chainCountersJson(counters, watch.elapsedMs());
    }
    {
        ChainCounters counters;
        const Stopwatch watch(nullptr, "");
        apply(productsOf(chain, counters).back(), std::span<Point>(together), counters);
        json["composite"] = chainCountersJson(counters, watch.elapsedMs());
    }
    const uint32_t threads = threadCount(options.threads);
    {
        std::atomic<uint64_t> applications{0}, equations{0};
        ChainCounters counters;
        const Stopwatch watch(nullptr, "");
        const Matrix composite = productsOf(chain, counters).back();
        parallelBands(options.vertices, 256, threads, [&](uint64_t begin, uint64_t end) {
            ChainCounters mine;
            apply(composite, std::span<Point>(parallel).subspan(begin, end - begin), mine);
            applications += mine.applications;
            equations += mine.equations;
        });
        counters.applications = applications;
        counters.equations = equations;
        json["parallel"] = chainCountersJson(counters, watch.elapsedMs());
        json["parallel"]["threads"] = threads;
        json["parallel"]["same_bytes"] = std::memcmp(together.data(), parallel.data(), together.size() * sizeof(Point)) == 0;
    }
    double largest = 0;
    for (size_t i = 0; i < together.size(); ++i)
        for (int axis = 0; axis < Point::length(); ++axis) largest = std::max(largest, std::abs(together[i][axis] - separately[i][axis]));
    json["largest_difference"] = largest;
    json["dependent_steps"] = depth + 1;  // levels of products, then all points at once
    return json;
}

template <class Matrix>
Json chainJson(const Options& options, std::span<const Step<Matrix>> chain) {
    using Point = typename PointOf<Matrix>::Type;
    std::vector<Point> points;
    for (const dvec3& p : options.points) points.emplace_back(p);

    Json json;
    json["dimensions"] = Matrix::length() - 1;
    json["notation"] = options.rowNotation ? "row" : "column";
    json["z_reversed"] = options.zReversed;
    ChainCounters sequential;
    const std::vector<Matrix> products = productsOf(chain, sequential);
    const Matrix composite = products.empty() ? Matrix(1.0) : products.back();
    json["steps"] = Json::array();
    for (size_t i = 0; i < chain.size(); ++i) {
        Json step = {
            {"name", chain[i].name}, {"matrix", matrixJson(options, chain[i].matrix)}, {"product", matrixJson(options, products[i])}};
        if (!points.empty()) {
            ChainCounters counters;
            Matrix m = chain[i].matrix;
            if constexpr (std::is_same_v<Matrix, dmat4>)
                if (options.zReversed) m = withZReversed(m);
            apply(m, std::span<Point>(points), counters);
            step["points"] = Json::array();
            for (const Point& p : points) step["points"].push_back(pointJson(p));
        }
        json["steps"].push_back(step);
    }
    json["composite"] = matrixJson(options, composite);
    json["sequential"] = {{"products", sequential.products}, {"depth", sequential.products}};
    ChainCounters inTree;
    const auto levels = treeOf(chain, inTree);
    Json tree = {{"products", inTree.products}, {"depth", levels.size()}, {"levels", Json::array()}};
    for (const auto& level : levels) {
        Json nodes = Json::array();
        for (const TreeNode<Matrix>& node : level)
            nodes.push_back({{"first", node.first + 1},
                             {"last", node.last + 1},
                             {"product", node.product},
                             {"matrix", matrixJson(options, node.matrix)}});
        tree["levels"].push_back(nodes);
    }
    tree["largest_difference"] = levels.empty() ? 0.0 : largestDifference(composite, levels.back()[0].matrix);
    json["tree"] = tree;
    if (options.inverse) {
        const auto inverse = inverseOf(composite);
        if (!inverse) return json;  // the caller knows how to name what was refused
        json["inverse"] = matrixJson(options, *inverse);
    }
    if (options.vertices > 0 && !chain.empty()) json["run"] = verticesJson(options, chain, levels.size());
    return json;
}

std::string textOfChain(const Json& json) {
    std::string text = fmt::format("{}-D, {} ({} vectors){}\n", json["dimensions"].get<int>(),
                                   json["notation"] == "row" ? "point * matrix" : "matrix * point", json["notation"].get<std::string>(),
                                   json["z_reversed"].get<bool>() ? ", Z axis reversed" : "");
    size_t number = 0;
    for (const Json& step : json["steps"]) {
        text += fmt::format("step {}: {}\n{}", ++number, step["name"].get<std::string>(), textOfMatrix(step["matrix"]));
        if (number > 1) text += fmt::format("  steps 1 to {}:\n{}", number, textOfMatrix(step["product"]));
        if (step.contains("points"))
            for (const Json& point : step["points"]) {
                text += "  point:";
                for (const Json& x : point) text += fmt::format(" {:.12g}", x.get<double>());
                text += "\n";
            }
    }
    const auto products = [](const Json& of) {
        const auto n = of["products"].get<uint64_t>();
        return fmt::format("{} product{}", n, n == 1 ? "" : "s");
    };
    text += number == 1 ? "composite of 1 step:\n"
                        : fmt::format("composite of {} steps, {} one after the other:\n", number, products(json["sequential"]));
    text += textOfMatrix(json["composite"]);
    if (json.contains("inverse")) text += "inverse:\n" + textOfMatrix(json["inverse"]);
    const Json& tree = json["tree"];
    if (number > 1)
        text += fmt::format("as a tree: {}, {} deep; largest difference of an entry {:.3g}\n", products(tree),
                            tree["depth"].get<uint64_t>(), tree["largest_difference"].get<double>());
    size_t level = 0;
    for (const Json& nodes : tree["levels"]) {
        text += fmt::format("  level {}:", ++level);
        for (const Json& node : nodes)
            text += fmt::format(" {}-{}{}", node["first"].get<size_t>(), node["last"].get<size_t>(),
                                node["product"].get<bool>() ? "" : " (carried over)");
        text += "\n";
    }
    if (json.contains("run")) {
        const Json& run = json["run"];
        const auto line = [](const char* name, const Json& c) {
            return fmt::format("  {:<26}{:>4} products {:>9} matrix*point {:>9} equations {:>9.3f} ms\n", name,
                               c["products"].get<uint64_t>(), c["applications"].get<uint64_t>(), c["equations"].get<uint64_t>(),
                               c["time_ms"].get<double>());
        };
        text += fmt::format("{} vertices:\n", run["vertices"].get<uint64_t>()) + line("each step on its own", run["separate"]) +
                line("composite", run["composite"]) +
                line(fmt::format("composite, {} threads", run["parallel"]["threads"].get<uint32_t>()).c_str(), run["parallel"]);
        text += fmt::format(
            "  threads leave {} bytes; composite and single steps differ by at most {:.3g}; {} dependent steps with "
            "enough hardware\n",
            run["parallel"]["same_bytes"].get<bool>() ? "the same" : "OTHER", run["largest_difference"].get<double>(),
            run["dependent_steps"].get<uint64_t>());
    }
    return text;
}

bool isObject(const Options& options, const Scene& scene, size_t i) {
    return options.object.empty() || options.object == scene.objects[i].name || options.object == std::to_string(i);
}

std::vector<Json> ofScene(const Options& options, const std::string& path) {
    const LoadOptions load = loadOptionsOf(options);
    const Scene scene = loadScene({path}, load);
    std::vector<Json> reports;
    for (size_t i = 0; i < scene.objects.size(); ++i) {
        if (!isObject(options, scene, i)) continue;
        stopIfInterrupted();
        const Object& object = scene.objects[i];
        std::vector<Step3> chain = object.chain;
        if (chain.empty() && object.worldFromObject != dmat4(1.0)) chain.push_back(matrixStep(object.worldFromObject));
        Json json;
        json["tool"] = toolJson();
        json["scene"] = sceneJson(scene, sourcesOf({path}, load));
        json["object"] = {{"number", i}, {"name", object.name}};
        json.update(chainJson(options, std::span<const Step3>(chain)));
        if (options.inverse && !json.contains("inverse"))
            throw inputError(printablePath(path), fmt::format("object '{}': the composite has no inverse", printable(object.name, 64)));
        reports.push_back(std::move(json));
    }
    if (reports.empty()) {
        std::vector<std::string> names;
        for (size_t i = 0; i < std::min<size_t>(24, scene.objects.size()); ++i) names.push_back(printable(scene.objects[i].name, 40));
        throw usageError(fmt::format("--object: '{}' is none of the {} objects of {}: {}", printable(options.object, 64),
                                     scene.objects.size(), printable(path), fmt::join(names, ", ")));
    }
    return reports;
}

Json ofSteps(const Options& options) {
    Json json;
    json["tool"] = toolJson();
    if (options.dimensions == 2) {
        const std::vector<Step2> chain = stepsInPlane(options.inputs);
        json.update(chainJson(options, std::span<const Step2>(chain)));
    } else {
        const std::vector<Step3> chain = stepsInSpace(options.inputs);
        json.update(chainJson(options, std::span<const Step3>(chain)));
    }
    if (options.inverse && !json.contains("inverse"))
        throw usageError("matrix: the composite has no inverse: a scale is 0, or a matrix is singular");
    return json;
}

}  // namespace

Exit matrixCommand(const Options& options) {
    // True for a step, which has a '='. A scene is one file; a path with a '=' is written ./a=b.toml.
    const auto isStep = [](const std::string& word) { return word.find('=') != std::string::npos && word.find('/') == std::string::npos; };
    const bool steps = isStep(options.inputs[0]);
    if (!steps && options.inputs.size() > 1) throw usageError("matrix takes the steps of a chain (what=value), or one scene");
    if (steps && !options.object.empty()) throw usageError("--object names an object of a scene, and the operands are steps");
    if (!steps && options.dimensions == 2) throw usageError("--dimensions 2 goes with steps: scenes are in space");
    if (options.dimensions == 2 && options.zReversed) throw usageError("--reverse-z goes with three dimensions");
    const std::vector<Json> reports = steps ? std::vector<Json>{ofSteps(options)} : ofScene(options, options.inputs[0]);
    if (!options.json || !options.jsonFile.empty()) {
        std::string text;
        for (const Json& report : reports) {
            if (report.contains("object"))
                text += fmt::format("object {} '{}'\n", report["object"]["number"].get<size_t>(),
                                    printable(report["object"]["name"].get<std::string>(), 64));
            text += textOfChain(report);
        }
        printData(text);
    }
    writeJson(options, reports);
    return Exit::done;
}

}  // namespace plumb
