// SPDX-License-Identifier: MIT
// Layers of two files in a common form, and colours as a display shows them.
#include "pipeline/compare/metrics.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// Expands grey to R G B, and adds an opaque alpha.
void expand(Layer& layer, bool rgb, bool alpha) {
    const uint32_t from = layer.channels - (layer.alpha ? 1 : 0), shown = rgb ? 3 : from, to = shown + (alpha ? 1 : 0);
    if (to == layer.channels && shown == from) return;
    const size_t pixels = layer.samples.size() / layer.channels;
    std::vector<double> samples;
    samples.reserve(pixels * to);
    for (size_t i = 0; i < pixels; ++i) {
        const double* s = layer.samples.data() + i * layer.channels;
        for (uint32_t c = 0; c < shown; ++c) samples.push_back(s[from == 1 ? 0 : c]);
        if (alpha) samples.push_back(layer.alpha ? s[from] : layer.fullScale);
    }
    layer.samples = std::move(samples);
    layer.channels = to;
    layer.alpha = alpha;
}

void toSixteenBits(Layer& layer) {
    if (layer.fullScale == 65535) return;
    for (double& s : layer.samples) s *= 257;  // 255 * 257 = 65535
    layer.fullScale = 65535;
}

}  // namespace

bool bringTogether(Layer& a, Layer& b, std::string& why) {
    if (a.kind != b.kind || a.colour != b.colour) {
        why = fmt::format("{} against {}", describe(a), describe(b));
        return false;
    }
    if (a.colour) {
        const bool rgb = std::max(a.channels - (a.alpha ? 1u : 0u), b.channels - (b.alpha ? 1u : 0u)) > 1, alpha = a.alpha || b.alpha;
        const bool associated = a.associated || b.associated;  // an opaque alpha counts as both
        for (Layer* layer : {&a, &b}) {
            expand(*layer, rgb, alpha);
            layer->associated = associated;
        }
    }
    if (a.channels != b.channels) {
        why = fmt::format("{} against {}", describe(a), describe(b));
        return false;
    }
    if (a.kind == LayerKind::code && a.fullScale != b.fullScale) {
        toSixteenBits(a);
        toSixteenBits(b);
    }
    return true;
}

double linearFromSrgb(double code) { return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4); }
double srgbFromLinear(double light) { return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055; }

Seen seen(const Layer& layer, uint32_t width, uint32_t height, double ground) {
    Seen out{width, height, {}, {}, {}};
    const size_t pixels = size_t(width) * height;
    for (auto* plane : {&out.red, &out.green, &out.blue}) plane->reserve(pixels);
    const uint32_t shown = layer.channels - (layer.alpha ? 1 : 0);
    std::vector<double> table;  // linear value of each code, since pow is slow
    if (layer.kind == LayerKind::code && !layer.linear)
        for (int code = 0; code <= int(layer.fullScale); ++code) table.push_back(linearFromSrgb(code / layer.fullScale));
    const auto light = [&](double s) { return !table.empty() ? table[size_t(s)] : s / layer.fullScale; };
    const auto clamped = [](double v) { return std::isnan(v) ? 0.0f : float(std::clamp(v, 0.0, 1.0)); };
    for (size_t i = 0; i < pixels; ++i) {
        const double* s = layer.samples.data() + i * layer.channels;
        Rgb c{light(s[0]), light(s[shown == 1 ? 0 : 1]), light(s[shown == 1 ? 0 : 2])};
        if (layer.alpha) {
            const double a = std::clamp(s[shown] / layer.fullScale, 0.0, 1.0), own = layer.associated ? 1 : a, under = (1 - a) * ground;
            c = {c.r * own + under, c.g * own + under, c.b * own + under};
        }
        out.red.push_back(clamped(c.r));
        out.green.push_back(clamped(c.g));
        out.blue.push_back(clamped(c.b));
    }
    return out;
}

}  // namespace plumb
