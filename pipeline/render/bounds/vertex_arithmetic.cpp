// SPDX-License-Identifier: MIT
#include "pipeline/render/bounds/vertex_arithmetic.h"

#include "host/error.h"
#include "pipeline/render/bounds/vertex_error.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/plain_floats.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/gtc/type_ptr.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

namespace {

bool choosesPrecision(const Technique& technique) {
    return technique.vertices == Technique::Vertices::transformPass || technique.vertices == Technique::Vertices::linesPass;
}

// The cheapest format whose bound holds; where none does, the best one, or float32 where the others gain nothing.
VertexArithmetic cheapestOf(const Scene& scene, const RenderRequest& request, uint32_t object) {
    VertexArithmetic a;
    a.pixels = a.usualPixels = vertexPixels(scene, request, object, Precision::fp32, kRaisePixels);
    for (const Precision precision : {Precision::blockInteger, Precision::fp64}) {
        if (a.pixels <= kRaisePixels) break;
        const double pixels = vertexPixels(scene, request, object, precision, kRaisePixels);
        if (!(pixels < a.pixels)) continue;
        a.precision = precision;
        a.pixels = pixels;
        a.raised = true;
    }
    return a;
}

// Objects under one matrix may share edges, as the parts of one glTF mesh do. They take one format, so that no crack opens.
void raiseTogether(const Scene& scene, const RenderRequest& request, std::vector<VertexArithmetic>& all) {
    const auto matrixOf = [&scene](uint32_t object) {
        std::array<double, 16> matrix;
        std::copy_n(glm::value_ptr(scene.objects[object].worldFromObject), matrix.size(), matrix.begin());
        return matrix;
    };
    std::map<std::array<double, 16>, uint32_t> highest;  // of each matrix, the first object in the most precise format
    for (uint32_t i = 0; i < all.size(); ++i) {
        if (!all[i].raised) continue;
        const auto [at, fresh] = highest.try_emplace(matrixOf(i), i);
        if (!fresh && all[at->second].precision < all[i].precision) at->second = i;
    }
    if (highest.empty()) return;
    for (uint32_t i = 0; i < all.size(); ++i) {
        VertexArithmetic& other = all[i];
        const auto at = highest.find(matrixOf(i));
        if (at == highest.end() || other.precision >= all[at->second].precision) continue;
        other.precision = all[at->second].precision;
        other.pixels = vertexPixels(scene, request, i, other.precision, kRaisePixels);
        if (!other.raised) other.with = at->second;
        other.raised = true;
    }
}

}  // namespace

const char* wordOf(Precision precision) {
    return precision == Precision::fp64 ? "binary64" : precision == Precision::blockInteger ? "block-scaled integers" : "float32";
}

std::vector<VertexArithmetic> vertexArithmetic(const Scene& scene, const RenderRequest& request) {
    const PlainFloats plain;
    PLUMB_ASSERT(scene.camera.has_value());
    std::vector<VertexArithmetic> all(scene.objects.size());
    if (!choosesPrecision(techniqueOf(scene, request)) || request.knobs.float32Only) return all;
    if (request.trade.precision != Precision::fp32) {
        for (VertexArithmetic& a : all) a.precision = request.trade.precision;
        return all;
    }
    for (uint32_t i = 0; i < all.size(); ++i) all[i] = cheapestOf(scene, request, i);
    raiseTogether(scene, request, all);
    return all;
}

std::vector<Precision> precisionsOf(const std::vector<VertexArithmetic>& all) {
    std::vector<Precision> precisions;
    for (const VertexArithmetic& a : all) precisions.push_back(a.precision);
    return precisions;
}

Plan::Raise raiseOf(const Scene& scene, uint32_t object, const VertexArithmetic& chosen) {
    const std::string name = quotedObject(scene, object);
    std::string why = chosen.with == kNone
                          ? fmt::format("float32 would move a vertex by {}", upTo(chosen.usualPixels))
                          : fmt::format("it stands where {} does, and edges of both stay common", quotedObject(scene, chosen.with));
    return {"precision", name, wordOf(chosen.precision), std::move(why), chosen.usualPixels, chosen.pixels, "px"};
}

}  // namespace plumb
