// SPDX-License-Identifier: MIT
#include "pipeline/planner/candidates.h"

#include "host/error.h"
#include "pipeline/render/bounds/vertex_error.h"
#include "pipeline/render/technique.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace plumb {
namespace {

using Set = std::function<void(RenderRequest&)>;
using Axis = std::vector<Set>;

bool anyMaterial(const Scene& scene, glm::vec3 Material::*colour) {
    return std::any_of(scene.materials.begin(), scene.materials.end(), [&](const Material& m) { return m.*colour != glm::vec3(0); });
}

// What of a trade changes neither work nor bytes goes back to its default.
void makePlain(const Scene& scene, RenderRequest& request) {
    Trade& t = request.trade;
    const Trade plain;
    const bool lit = !scene.lights.empty() && request.shading != Shading::unlit, atPixels = request.shading == Shading::phong;
    const bool specular = lit && anyMaterial(scene, &Material::specular), diffuse = lit && anyMaterial(scene, &Material::diffuse);
    if (!specular) t.specular = plain.specular;
    if (!specular && !diffuse) t.vectors = plain.vectors;
    if (!atPixels && (t.vectors == Trade::Vectors::vertex || t.vectors == Trade::Vectors::face)) t.vectors = plain.vectors;
    if (!atPixels || (!specular && !diffuse)) t.unitNormals = plain.unitNormals;
    if (!atPixels) t.coarse = plain.coarse;
    if (!atPixels && request.shading != Shading::gouraud) t.affine = plain.affine;
}

bool isBinary64(const TradeChoice& choice) {
    Trade trade;
    choice.choose(trade);
    return trade.precision == Precision::fp64;
}

std::vector<Axis> rasterAxes(const Scene& scene, const RenderRequest& base, const Pinned& pinned) {
    std::vector<Axis> axes;
    const auto stated = [&](const TradeAxis* axis) {
        return std::find(pinned.trade.begin(), pinned.trade.end(), axis) != pinned.trade.end();
    };
    if (!pinned.shading) {
        Axis shading;
        for (const Choice<Shading>& row : kShadings)
            if (row.value != Shading::wire && row.value != Shading::ray)
                shading.push_back([value = row.value](RenderRequest& r) { r.shading = value; });
        axes.push_back(std::move(shading));
    }
    for (const TradeAxis& axis : kTradeAxes) {
        const std::string_view name = axis.name;
        if (stated(&axis) || name == "depth" || name == "subpixel") continue;
        if (name == "transform" && vertexErrors(scene, base).empty()) continue;
        Axis choices;
        for (const TradeChoice& choice : axis.choices)
            if (choice.verdict == Verdict::bits && (pinned.binary64 || !isBinary64(choice)))
                choices.push_back([&choice](RenderRequest& r) { choice.choose(r.trade); });
        axes.push_back(std::move(choices));
    }
    return axes;
}

// Least weights beyond a depth of kShallow, where a tree of rays may have no end within reach.
constexpr uint32_t kShallow = 10;

std::vector<Axis> rayAxes(const Scene& scene, const RenderRequest& base, const Pinned& pinned) {
    if (raysAskedBy(scene).empty()) return {};
    std::set<uint32_t> depths = {base.maxDepth};
    std::set<float> cutoffs = {base.minWeight};
    if (!pinned.maxDepth) depths.insert({1, 2, 3, 5, kShallow, 20, 64});
    if (!pinned.minWeight) cutoffs.insert({0.0f, 0x1p-16f, 0x1p-12f, 1 / 256.0f, 1 / 100.0f, 1 / 10.0f});
    Axis both;
    for (const uint32_t depth : depths)
        for (const float cutoff : cutoffs) {
            if (depth > std::max(kShallow, base.maxDepth) && cutoff == 0) continue;
            both.push_back([depth, cutoff](RenderRequest& r) { r.maxDepth = depth, r.minWeight = cutoff; });
        }
    return {std::move(both)};
}

std::string wordsFor(const RenderRequest& request, bool samples) {
    std::string words = nameOf(request.shading);
    if (samples) words += fmt::format(", samples={}", request.samples);
    if (isTraced(request)) {
        words += fmt::format(", max-depth={}", request.maxDepth);
        return words + (request.minWeight > 0 ? fmt::format(", min-weight=1/{:g}", 1 / double(request.minWeight)) : ", min-weight=0");
    }
    for (const TradeAxis& axis : kTradeAxes) {
        const TradeChoice& chosen = axis.chosen(request.trade);
        if (&chosen != &axis.choices[0]) words += fmt::format(", {}={}", axis.name, chosen.word);
    }
    return words;
}

}  // namespace

std::vector<Candidate> candidatesOf(const Scene& scene, const RenderRequest& base, const Pinned& pinned, bool samples) {
    const Technique& technique = techniqueOf(scene, base);
    if (!technique.showsSurfaces()) throw usageError("--error and --time: a wire frame has no truth that a budget could be held against");
    if (base.fill == Fill::notes)
        throw usageError("--error and --time: --fill notes draws as the lecture notes do, and has nothing to choose; leave it out");
    const bool traced = isTraced(base);
    std::vector<Axis> axes = traced ? rayAxes(scene, base, pinned) : rasterAxes(scene, base, pinned);
    if (samples && !pinned.samples && base.rays.sampling != Sampling::corners && base.rays.sampling != Sampling::adaptive) {
        Axis counts;
        for (const Choice<uint32_t>& row : kSampleCounts) counts.push_back([value = row.value](RenderRequest& r) { r.samples = value; });
        axes.push_back(std::move(counts));
    }
    std::vector<Candidate> candidates;
    std::set<std::string> known;
    std::vector<size_t> at(axes.size(), 0);
    for (;;) {
        RenderRequest request = base;
        for (size_t i = 0; i < axes.size(); ++i) axes[i][at[i]](request);
        if (!traced) makePlain(scene, request);
        const std::string words = wordsFor(request, samples);
        bool drawn = true;
        try {
            refuse(scene, request);
        } catch (const Error&) {
            drawn = false;  // a combination that does not exist
        }
        if (drawn && known.insert(words).second) candidates.push_back({std::move(request), words});
        size_t axis = 0;
        while (axis < axes.size() && ++at[axis] == axes[axis].size()) at[axis++] = 0;
        if (axis == axes.size()) break;
    }
    if (candidates.empty()) refuse(scene, base);  // says why
    return candidates;
}

}  // namespace plumb
