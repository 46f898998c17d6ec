// SPDX-License-Identifier: MIT
// Small pictures made in memory, for the tests of pipeline/compare.
#pragma once

#include "pipeline/compare/compare.h"

#include <array>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace plumb {

// One colour layer of 8-bit codes; `code(x, y, channel)`.
inline Picture coded(uint32_t width, uint32_t height, uint32_t channels, const std::function<double(uint32_t, uint32_t, uint32_t)>& code) {
    Picture picture;
    picture.path = "made in memory";
    picture.format = "png";
    picture.width = width;
    picture.height = height;
    Layer layer;
    layer.name = "color";
    layer.kind = LayerKind::code;
    layer.colour = true;
    layer.alpha = channels == 2 || channels == 4;
    layer.channels = channels;
    layer.fullScale = 255;
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            for (uint32_t c = 0; c < channels; ++c) layer.samples.push_back(code(x, y, c));
    picture.layers.push_back(layer);
    return picture;
}
inline Picture uniform(uint32_t width, uint32_t height, std::array<double, 3> rgb) {
    return coded(width, height, 3, [&](uint32_t, uint32_t, uint32_t c) { return rgb[c]; });
}

// One plane of floats, not a colour.
inline Picture plane(uint32_t width, uint32_t height, std::vector<double> samples, int precision = 32, LayerKind kind = LayerKind::real) {
    Picture picture;
    picture.path = "made in memory";
    picture.format = "npy";
    picture.width = width;
    picture.height = height;
    Layer layer;
    layer.name = "array";
    layer.kind = kind;
    layer.precision = precision;
    layer.samples = std::move(samples);
    picture.layers.push_back(layer);
    return picture;
}

inline LayerDifference only(const Picture& a, const Picture& b, const CompareOptions& options = {}) {
    return compare(a, b, options).layers.at(0);
}

}  // namespace plumb
