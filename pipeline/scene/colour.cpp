// SPDX-License-Identifier: MIT
#include "pipeline/scene/colour.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

namespace plumb {

namespace {

int digitOf(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

// Quotient a b / c to the nearest, halves up; the greatest product is 255 * 255.
uint8_t share(uint32_t a, uint32_t b, uint32_t c) { return uint8_t((2 * a * b + c) / (2 * c)); }

}  // namespace

std::optional<Rgb8> rgbOfHex(std::string_view code) {
    if (code.size() != 7 || code[0] != '#') return std::nullopt;
    Rgb8 rgb{};
    for (size_t i = 0; i < 3; ++i) {
        const int high = digitOf(code[2 * i + 1]), low = digitOf(code[2 * i + 2]);
        if (high < 0 || low < 0) return std::nullopt;
        rgb[i] = uint8_t(16 * high + low);
    }
    return rgb;
}

std::string hexOf(const Rgb8& rgb) { return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]); }

std::string hexOf(const glm::dvec3& intensity) {
    Rgb8 rgb{};
    for (int i = 0; i < 3; ++i) {
        const double x = std::isnan(intensity[i]) ? 0 : std::clamp(intensity[i], 0.0, 1.0);
        rgb[size_t(i)] = uint8_t(std::nearbyint(255 * x));
    }
    return hexOf(rgb);
}

Cmyk cmykFromRgb(const glm::dvec3& rgb) {
    const double most = std::max({rgb.r, rgb.g, rgb.b});
    if (!(most > 0)) return {0, 0, 0, 1};
    return {(most - rgb.r) / most, (most - rgb.g) / most, (most - rgb.b) / most, 1 - most};
}

glm::dvec3 rgbFromCmyk(const Cmyk& ink) { return (1.0 - glm::dvec3(ink.c, ink.m, ink.y)) * (1.0 - ink.k); }

Cmyk8 cmykFromRgb(const Rgb8& rgb) {
    const uint32_t most = std::max({rgb[0], rgb[1], rgb[2]});
    if (most == 0) return {0, 0, 0, 255};
    return {share(255, most - rgb[0], most), share(255, most - rgb[1], most), share(255, most - rgb[2], most), uint8_t(255 - most)};
}

Rgb8 rgbFromCmyk(const Cmyk8& ink) {
    const uint32_t light = 255u - ink.k;
    return {share(255u - ink.c, light, 255), share(255u - ink.m, light, 255), share(255u - ink.y, light, 255)};
}

}  // namespace plumb
