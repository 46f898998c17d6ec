// SPDX-License-Identifier: MIT
#include "pipeline/compare/draw.h"

#include "host/error.h"
#include "pipeline/compare/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

namespace plumb {
namespace {

constexpr uint32_t kMagenta = 0xffff00ffu;

uint32_t packed(const std::array<double, 3>& rgb) {
    uint32_t pixel = 0xff000000u;
    for (size_t c = 0; c < 3; ++c) pixel |= uint32_t(std::lround(std::clamp(rgb[c], 0.0, 1.0) * 255)) << (8 * c);
    return pixel;
}

// Colour of the heat map: eleven points of matplotlib's "magma" (CC0), which grows evenly in lightness; straight lines between them.
uint32_t heat(double t) {
    constexpr std::array<std::array<uint8_t, 3>, 11> kPoints = {{{0, 0, 4},
                                                                 {20, 14, 54},
                                                                 {59, 15, 112},
                                                                 {100, 26, 128},
                                                                 {140, 41, 129},
                                                                 {183, 55, 121},
                                                                 {222, 73, 104},
                                                                 {247, 112, 92},
                                                                 {254, 159, 109},
                                                                 {254, 207, 146},
                                                                 {252, 253, 191}}};
    const double at = std::clamp(t, 0.0, 1.0) * (kPoints.size() - 1);
    const size_t k = std::min(size_t(at), kPoints.size() - 2);
    std::array<double, 3> rgb{};
    for (size_t c = 0; c < 3; ++c) rgb[c] = (kPoints[k][c] + (at - double(k)) * (double(kPoints[k + 1][c]) - kPoints[k][c])) / 255;
    return packed(rgb);
}

Frame frameOf(uint32_t width, uint32_t height) {
    Frame frame;
    frame.width = width;
    frame.height = height;
    frame.rgba.assign(size_t(width) * height, 0xff000000u);
    return frame;
}

const Layer& layerOf(const Picture& picture, const std::string& name) {
    const auto at = std::find_if(picture.layers.begin(), picture.layers.end(), [&](const Layer& l) { return l.name == name; });
    PLUMB_ASSERT(at != picture.layers.end());
    return *at;
}

}  // namespace

DifferencePicture drawDifference(const Picture& a, const Picture& b, const LayerDifference& layer) {
    DifferencePicture out{frameOf(a.width, a.height), 0};
    if (layer.a.kind == LayerKind::id) {
        for (size_t i = 0; i < layer.error.size(); ++i) out.frame.rgba[i] = layer.error[i] != 0 ? 0xffffffffu : 0xff000000u;
        return out;
    }
    Layer p = layerOf(a, layer.name), q = layerOf(b, layer.name);
    std::string why;
    PLUMB_ASSERT(bringTogether(p, q, why));
    // Difference of a channel; 0 where the search found a match.
    const auto apart = [&](size_t i, uint32_t c) {
        const double d = p.samples[i * p.channels + c], e = q.samples[i * p.channels + c];
        return d == e || layer.error[i] == 0 ? 0.0 : std::fabs(d - e) / p.fullScale;
    };
    double most = 0;
    for (size_t i = 0; i < layer.error.size(); ++i)
        for (uint32_t c = 0; c < p.channels; ++c)
            if (const double d = apart(i, c); std::isfinite(d)) most = std::max(most, d);
    if (most > 0) out.exponent = -int(std::ceil(std::log2(most * (255.0 / 256))));
    const double gain = std::ldexp(1.0, out.exponent);
    for (size_t i = 0; i < layer.error.size(); ++i) {
        if (std::isnan(layer.error[i])) {
            out.frame.rgba[i] = kMagenta;
            continue;
        }
        const uint32_t shown = p.channels - (p.alpha ? 1 : 0);
        std::array<double, 3> rgb{};
        for (uint32_t c = 0; c < 3 && (c < shown || shown == 1); ++c) rgb[c] = apart(i, shown == 1 ? 0 : c) * gain;
        if (p.alpha && rgb == std::array<double, 3>{}) rgb.fill(apart(i, shown) * gain);
        out.frame.rgba[i] = packed(rgb);
    }
    return out;
}

HeatPicture drawHeat(const LayerDifference& layer, uint32_t width, uint32_t height) {
    HeatPicture out{frameOf(width, height), 1, layer.flip.has_value()};
    if (!out.flip) {
        double most = 0;
        for (const double e : layer.error)
            if (std::isfinite(e)) most = std::max(most, e);
        if (most > 0) out.brightest = most;
    }
    for (size_t i = 0; i < layer.error.size(); ++i)
        out.frame.rgba[i] =
            std::isnan(layer.error[i]) ? kMagenta : heat(out.flip ? double(layer.flipMap[i]) : layer.error[i] / out.brightest);
    return out;
}

}  // namespace plumb
