// SPDX-License-Identifier: MIT
// Claims P1 to P4: the cost of transforming. The counters are those of pipeline/transform/chain.h, which count where the work is done.
#include "pipeline/bench/claims.h"
#include "pipeline/bench/products.h"
#include "pipeline/transform/steps.h"

#include "host/error.h"

#include <fmt/core.h>
#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace plumb {

namespace {

// Roundings between two ways to the same point, seven applications or one of a composite. Each coordinate passes at most 14 rounded sums of
// four products, four roundings a sum. The steps (rotations and shifts) keep their magnitudes below the largest one on the way.
constexpr double kRoundings = 2 * 14 * 4;
constexpr uint32_t kRepeats = 1000;  // repeats of work that takes microseconds

std::vector<glm::dvec3> pointsOf(size_t count) {
    std::vector<glm::dvec3> points(count);
    for (size_t i = 0; i < count; ++i) {
        const double a = double(i) * 2.399963229728653, z = 1 - (2.0 * double(i) + 1) / double(count);
        const double r = std::sqrt(1 - z * z);
        points[i] = glm::dvec3(r * std::cos(a), r * std::sin(a), z) * 10.0;
    }
    return points;
}

double largestDifference(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b) {
    double most = 0;
    for (size_t i = 0; i < a.size(); ++i)
        for (int k = 0; k < 3; ++k) {
            const double d = std::abs(a[i][k] - b[i][k]);
            if (!(d <= most)) most = d;  // NaN stays
        }
    return most;
}

// Largest magnitude that a point reaches on its way through the steps.
double largestOf(std::span<const Step3> chain, std::vector<glm::dvec3> points) {
    double most = 0;
    ChainCounters ignored;
    for (const Step3& step : chain) {
        for (const glm::dvec3& p : points) most = std::max({most, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        most = std::max({most, std::abs(step.matrix[3].x), std::abs(step.matrix[3].y), std::abs(step.matrix[3].z)});
        apply<glm::dmat4, glm::dvec3>(step.matrix, points, ignored);
    }
    return most;
}

gpu::Rows rowsOf(const glm::dmat4& m) {
    const glm::mat4 t = glm::transpose(glm::mat4(m));
    return {t[0], t[1], t[2], t[3]};
}

// Claim P1, section 10.1: every coordinate of every vertex is an equation of its own.
ClaimTable equationsAreIndependent(Device& device, const ClaimOptions& options) {
    constexpr uint32_t kVertices = 1000000, kNotesVertices = 1000;
    ClaimTable table{"P1",
                     "1000 vertices are 3000 equations, one after another; none waits for another, so they may all be solved at "
                     "once.",
                     "A million vertices by one matrix, float32, same bytes each way; the equations of 1000 are counted.",
                     {},
                     {}};
    ChainCounters counters;
    std::vector<glm::dvec3> counted = pointsOf(kNotesVertices);
    apply<glm::dmat4, glm::dvec3>(rotateZStep(30).matrix, counted, counters);
    const std::vector<gpu::Rows> matrix = {rowsOf(lineSteps({3, 3, 5}, {6, 6.4641, 7}, 30)[1].matrix)};
    std::vector<glm::vec4> in(kVertices);
    const std::vector<glm::dvec3> points = pointsOf(kVertices);
    std::transform(points.begin(), points.end(), in.begin(), [](const glm::dvec3& p) { return glm::vec4(p, 1); });
    std::vector<glm::vec4> one(kVertices), many(kVertices);
    const uint32_t threads = std::max(1u, std::thread::hardware_concurrency());
    Buffer<glm::vec4> from(device, kVertices, "vertices");
    Buffer<gpu::VertexPair> to(device, pairsOf(kVertices), "transformed");
    Buffer<gpu::Rows> by(device, 1, "matrix");
    from.upload(in);
    by.upload(matrix);
    Recorder recorder(device);
    const auto work =
        std::vector<std::pair<std::string, uint64_t>>{{"vertices", kVertices}, {"equations of 1000 vertices", counters.equations}};
    for (const std::string& name : {std::string("one thread"), fmt::format("{} threads", threads), std::string("device")})
        table.ways.push_back({name, work, {}, {}});
    takeTurns(table,
              {[&] { verticesCpu(matrix, in, one, 1); }, [&] { verticesCpu(matrix, in, many, threads); },
               [&] {
                   recordVertices(recorder, device.limits(), 1, kVertices, from, by, to);
                   recorder.run(options.watchdogMs);
               }},
              options);
    if (counters.equations != 3 * uint64_t(kNotesVertices)) table.failure = fmt::format("{} equations, not 3000", counters.equations);
    if (std::memcmp(one.data(), many.data(), one.size() * sizeof(glm::vec4)) != 0 ||
        std::memcmp(one.data(), to.data(), one.size() * sizeof(glm::vec4)) != 0)
        table.failure = "the vertices depend on how they were shared out";
    return table;
}

// Claims P2 and P3: `chain` step by step, or its composite once.
ClaimTable compositeIsCheaper(ClaimTable table, const std::vector<Step3>& chain, size_t vertices, uint32_t repeats,
                              const ClaimOptions& options) {
    const std::vector<glm::dvec3> start = pointsOf(vertices);
    std::vector<glm::dvec3> stepped, composed;
    ChainCounters byStep, byComposite;
    const auto stepByStep = [&] {
        stepped = start;
        for (const Step3& step : chain) apply<glm::dmat4, glm::dvec3>(step.matrix, stepped, byStep);
    };
    const auto once = [&] {
        composed = start;
        apply<glm::dmat4, glm::dvec3>(productsOf<glm::dmat4>(chain, byComposite).back(), composed, byComposite);
    };
    stepByStep();
    once();
    table.ways = {{"step by step", {{"applications", byStep.applications}, {"products", byStep.products}}, {}, {}},
                  {"one composite", {{"applications", byComposite.applications}, {"products", byComposite.products}}, {}, {}}};
    takeTurns(table,
              {[&] {
                   for (uint32_t i = 0; i < repeats; ++i) stepByStep();
               },
               [&] {
                   for (uint32_t i = 0; i < repeats; ++i) once();
               }},
              options);
    const auto& first = table.ways[0].counts;
    const auto& second = table.ways[1].counts;
    if (first[0].second != chain.size() * vertices || second[0].second != vertices || second[1].second != chain.size() - 1)
        table.failure = "the counts are not those of the chain";
    const double bound = kRoundings * DBL_EPSILON / 2 * 4 * largestOf(chain, start);
    if (const double off = largestDifference(stepped, composed); !(off <= bound))
        table.failure = fmt::format("composite and steps differ by {:g}, more than rounding allows ({:g})", off, bound);
    return table;
}

// Claim P4, section 10.2.2: products of pairs do not wait for one another.
ClaimTable treesAreShallow(const std::vector<Step3>& chain, const ClaimOptions& options) {
    ClaimTable table{"P4",
                     "The composite of seven matrices takes six products that wait for one another, or three levels of "
                     "products that do not; with "
                     "enough hardware the whole job is 3 + 1 time steps instead of 7 a vertex.",
                     fmt::format("The composite formed both ways by one thread, {} times. The products are as many, and the tree also "
                                 "keeps its nodes; what falls is how many wait for one another.",
                                 kRepeats),
                     {},
                     {}};
    ChainCounters inRow, inTree;
    const glm::dmat4 row = productsOf<glm::dmat4>(chain, inRow).back();
    const auto levels = treeOf<glm::dmat4>(chain, inTree);
    const glm::dmat4 tree = levels.back().front().matrix;
    table.ways = {{"one after another", {{"products", inRow.products}, {"waiting", inRow.products}}, {}, {}},
                  {"tree", {{"products", inTree.products}, {"waiting", levels.size()}}, {}, {}}};
    double kept = 0;
    takeTurns(table,
              {[&] {
                   for (uint32_t i = 0; i < kRepeats; ++i) kept += productsOf<glm::dmat4>(chain, inRow).back()[3][0];
               },
               [&] {
                   for (uint32_t i = 0; i < kRepeats; ++i) kept += treeOf<glm::dmat4>(chain, inTree).back().front().matrix[3][0];
               }},
              options);
    PLUMB_ASSERT(std::isfinite(kept));
    if (table.ways[0].counts[0].second != 6 || table.ways[1].counts[0].second != 6 || levels.size() != 3)
        table.failure = "not six products in three levels";
    double most = 0, off = 0;
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) {
            for (const Step3& step : chain) most = std::max(most, std::abs(step.matrix[c][r]));
            most = std::max(most, std::abs(row[c][r]));
            off = std::max(off, std::abs(row[c][r] - tree[c][r]));
        }
    const double bound = kRoundings * DBL_EPSILON / 2 * 4 * most;
    if (!(off <= bound)) table.failure = fmt::format("tree and row differ by {:g}, more than rounding allows ({:g})", off, bound);
    return table;
}

}  // namespace

std::vector<ClaimTable> benchTransformClaims(Device& device, const ClaimOptions& options) {
    const std::vector<Step3> inPlace = aboutSteps(glm::dvec3(4, -2, 7), rotateZStep(40));
    const std::vector<Step3> aboutLine = lineSteps({3, 3, 5}, {6, 6.4641, 7}, 90);
    return {equationsAreIndependent(device, options),
            compositeIsCheaper({"P2",
                                "Turning 10,000 vertices in place step by step applies 30,000 matrices; their "
                                "composite 10,000, after two products.",
                                "Binary64, one thread, ten times.",
                                {},
                                {}},
                               inPlace, 10000, 10, options),
            compositeIsCheaper({"P3",
                                "Turning 1000 vertices about a line takes 7000 products of a matrix and a point step "
                                "by step, 1000 by the composite.",
                                "Binary64, one thread, a hundred times.",
                                {},
                                {}},
                               aboutLine, 1000, 100, options),
            treesAreShallow(aboutLine, options)};
}

}  // namespace plumb
