// SPDX-License-Identifier: MIT
#include "pipeline/compare/compare.h"

#include "host/error.h"
#include "pipeline/compare/metrics.h"
#include "pipeline/scene/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

const Layer* find(const Picture& picture, const std::string& name) {
    for (const Layer& layer : picture.layers)
        if (layer.name == name) return &layer;
    return nullptr;
}

Layer withoutSamples(const Layer& layer) {
    Layer copy;
    copy.name = layer.name, copy.kind = layer.kind, copy.colour = layer.colour, copy.linear = layer.linear, copy.alpha = layer.alpha;
    copy.associated = layer.associated, copy.channels = layer.channels, copy.fullScale = layer.fullScale, copy.precision = layer.precision;
    return copy;
}

std::string viewOf(const Picture& p) {
    std::string text = fmt::format("{}x{}", p.width, p.height);
    if (p.left != 0 || p.top != 0) text += fmt::format(" from ({}, {})", p.left, p.top);
    return text;
}

bool seesThrough(const Layer& layer) {
    if (!layer.alpha) return false;
    for (size_t i = layer.channels - 1; i < layer.samples.size(); i += layer.channels)
        if (!(layer.samples[i] >= layer.fullScale)) return true;
    return false;
}

void keepWorse(std::optional<Perceived>& kept, const std::optional<Perceived>& other, bool largerIsWorse) {
    if (!other) return;
    if (!kept || (largerIsWorse ? other->mean > kept->mean : other->mean < kept->mean)) kept = other;
}

void takePerceived(const Layer& a, const Layer& b, uint32_t width, uint32_t height, const CompareOptions& options, LayerDifference& out) {
    std::vector<double> grounds = {0};
    if (seesThrough(a) || seesThrough(b)) grounds.push_back(1);
    for (const double ground : grounds) {
        const Seen p = seen(a, width, height, ground), q = seen(b, width, height, ground);
        keepWorse(out.ssim, ssimOf(p, q, options), false);
        std::vector<float> map;
        const Perceived flip = flipOf(p, q, options, map);
        if (!out.flip || flip.mean > out.flip->mean) out.flip = flip, out.flipMap = std::move(map);
        keepWorse(out.deltaE, deltaEOf(p, q, options), true);
    }
}

LayerDifference compareLayer(const Picture& a, const Picture& b, const Layer& inA, const Layer& inB, const CompareOptions& options) {
    LayerDifference out;
    out.name = inA.name;
    out.a = withoutSamples(inA);
    out.b = withoutSamples(inB);
    Layer p = inA, q = inB;
    std::string why;
    if (!bringTogether(p, q, why))
        throw inputError(fmt::format("{} and {}", printable(a.path), printable(b.path)),
                         fmt::format("'{}' has no common form: {}", inA.name, why));
    takeNorms(p, q, a.width, a.height, options, out);
    if (p.kind == LayerKind::real) takeUlp(p, q, a.width, out);
    if (p.colour) takePerceived(p, q, a.width, a.height, options, out);
    return out;
}

}  // namespace

bool Comparison::equal() const {
    return sameSize && onlyA.empty() && onlyB.empty() &&
           std::all_of(layers.begin(), layers.end(), [](const LayerDifference& layer) { return layer.differing == 0 && !layer.hasNan(); });
}

Comparison compare(const Picture& a, const Picture& b, const CompareOptions& options) {
    Comparison out;
    for (const std::string& name : options.layers)
        if (find(a, name) == nullptr && find(b, name) == nullptr) {
            std::vector<std::string> names;
            for (const Layer& layer : a.layers) names.push_back(layer.name);
            throw usageError(fmt::format("neither picture has a plane '{}'; the first has {}", printable(name), fmt::join(names, ", ")));
        }
    if (a.width != b.width || a.height != b.height || a.left != b.left || a.top != b.top) {
        out.sameSize = false;
        out.sizeDifference = fmt::format("{} against {}", viewOf(a), viewOf(b));
        return out;
    }
    const auto wanted = [&](const Layer& layer) {
        return options.layers.empty() || std::find(options.layers.begin(), options.layers.end(), layer.name) != options.layers.end();
    };
    for (const Layer& layer : b.layers)
        if (wanted(layer) && find(a, layer.name) == nullptr) out.onlyB.push_back(layer.name);
    for (const Layer& layer : a.layers) {
        if (!wanted(layer)) continue;
        const Layer* other = find(b, layer.name);
        if (other == nullptr)
            out.onlyA.push_back(layer.name);
        else
            out.layers.push_back(compareLayer(a, b, layer, *other, options));
    }
    return out;
}

}  // namespace plumb
