// SPDX-License-Identifier: MIT
// Colour systems of the lecture notes (15.3, 15.4, 16.5): RGB and its hexadecimal code, CMY, CMYK.
// RGB here is what a picture holds: shares of full light as encoded, 0 to 1 or 0 to 255. Inks are shares of full coverage. Nothing depends
// on a printer's inks: R = (1 - C) (1 - K) and so on, so that a mixture reflects what every ink of it reflects.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace plumb {

using Rgb8 = std::array<uint8_t, 3>;

// Colour of the code "#rrggbb", digits of either case; nothing else is a code.
std::optional<Rgb8> rgbOfHex(std::string_view code);
std::string hexOf(const Rgb8&);  // lower-case digits
// Colour code of section 16.5: 255 times the intensity, halves to even, clamped to [0, 255] at both ends (erratum A14); NaN is 0.
std::string hexOf(const glm::dvec3& intensity);

inline glm::dvec3 cmyFromRgb(const glm::dvec3& rgb) { return 1.0 - rgb; }
inline glm::dvec3 rgbFromCmy(const glm::dvec3& cmy) { return 1.0 - cmy; }
inline glm::dvec3 mixed(const glm::dvec3& rgb, const glm::dvec3& other) { return rgb * other; }  // light left by one ink over another

struct Cmyk {
    double c = 0, m = 0, y = 0, k = 0;
};
// CMYK with full black generation: K is all that C, M and Y have in common, K = 1 - max(R, G, B) and C = (1 - R - K) / (1 - K); black is K
// alone.
Cmyk cmykFromRgb(const glm::dvec3& rgb);
glm::dvec3 rgbFromCmyk(const Cmyk&);

// CMYK of bytes, each the nearest to the exact quotient (halves up). cmykFromRgb followed by rgbFromCmyk gives every one of the 2^24
// colours back.
struct Cmyk8 {
    uint8_t c = 0, m = 0, y = 0, k = 0;
};
Cmyk8 cmykFromRgb(const Rgb8&);
Rgb8 rgbFromCmyk(const Cmyk8&);

}  // namespace plumb
