// SPDX-License-Identifier: MIT
// What a picture may trade: accuracy for speed, and time for accuracy. One axis a member of Trade, with its rows (docs/measure.md, The axes).
#pragma once

#include "pipeline/choices/choice.h"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace plumb {

// Number format in which vertices are transformed; the last two are more accurate than float32 (shaders/shared/long_transform.h).
enum class Precision { fp32, blockInteger, fp64 };

// What a picture may do faster and less accurately, beside its shading and samples (docs/measure.md). The defaults are the most accurate.
struct Trade {
    enum class Specular { exact, schlick, native };
    enum class Vectors { pixel, vertex, face, scene };

    static constexpr uint32_t kStandardDepth = 33;  // as depthBits

    Specular specular = Specular::exact;
    Vectors vectors = Vectors::pixel;       // Phong: where directions to the eye and to each light are made; scene: at the framed centre
    Precision precision = Precision::fp32;  // of the vertex transform; the other two are more accurate
    bool affine = false;                    // attributes interpolated without perspective
    uint32_t depthBits = 32;                // 32: n/w as float32; kStandardDepth: float32 of 1 - n/w; 16, 24: n/w as fixed point
    uint32_t subpixelBits = 8;              // 8, 4: what vertices are snapped to
    bool unitNormals = true;                // false: interpolated normals are not made unit at pixels (Phong)
    bool coarse = false;                    // one pixel in 2 x 2 is shaded (Phong)
    bool nativeEncode = false;              // sRGB by the device's pow
    // The device's own functions, whose last bits are its own: the twin is not equal to the device, but within a bound (bound.h).
    bool native() const { return specular == Specular::native || nativeEncode; }
    bool operator==(const Trade&) const = default;
};

// A row of an axis: a Choice whose value is one member of a Trade.
struct TradeChoice {
    const char* word;
    void (*choose)(Trade&);
    bool (*isChosen)(const Trade&);
    const char* help;
    const char* bound;
    Verdict verdict;
    const char* alias = "";  // none: every word of an axis is its own
};

template <auto member, auto value>
constexpr TradeChoice tradeChoice(const char* word, const char* help, const char* bound = "", Verdict verdict = Verdict::bits) {
    return {word, [](Trade& t) { t.*member = value; }, [](const Trade& t) { return t.*member == value; }, help, bound, verdict};
}

struct TradeAxis {
    const char* name;
    const char* what;                      // one line for people
    std::span<const TradeChoice> choices;  // the first is the default
    bool givesMore = false;                // the others are more accurate than the default

    const TradeChoice& chosen(const Trade&) const;
};

inline constexpr TradeChoice kSpecularChoices[] = {
    tradeChoice<&Trade::specular, Trade::Specular::exact>("exact", "polynomials of our own"),
    tradeChoice<&Trade::specular, Trade::Specular::schlick>("schlick", "a quotient", "at most 0.2037 above the power for exponents from 1"),
    tradeChoice<&Trade::specular, Trade::Specular::native>("native", "the device's own pow", "within a bound of the exact one",
                                                           Verdict::bounded),
};
inline constexpr TradeChoice kVectorsChoices[] = {
    tradeChoice<&Trade::vectors, Trade::Vectors::pixel>("pixel", "at every pixel"),
    tradeChoice<&Trade::vectors, Trade::Vectors::vertex>("vertex", "at the corners of what is drawn, interpolated, not made unit again"),
    tradeChoice<&Trade::vectors, Trade::Vectors::face>("face", "once a face, at its centre"),
    tradeChoice<&Trade::vectors, Trade::Vectors::scene>("scene", "one to the eye, and to each light from the framed centre"),
};
inline constexpr TradeChoice kInterpolationChoices[] = {
    tradeChoice<&Trade::affine, false>("perspective", "weighted by 1/w"),
    tradeChoice<&Trade::affine, true>("affine", "linear on the screen"),
};
inline constexpr TradeChoice kDepthChoices[] = {
    tradeChoice<&Trade::depthBits, 32u>("reversed-32", "n/w as float32"),
    tradeChoice<&Trade::depthBits, Trade::kStandardDepth>("standard-32", "1 - n/w as float32, the usual way round",
                                                          "off by less than 2^-24"),
    tradeChoice<&Trade::depthBits, 24u>("24", "n/w in fixed point", "off by less than 2^-24"),
    tradeChoice<&Trade::depthBits, 16u>("16", "n/w in fixed point", "off by less than 2^-16"),
};
inline constexpr TradeChoice kSubpixelChoices[] = {
    tradeChoice<&Trade::subpixelBits, 8u>("8", "vertices snapped to 1/256 px", "off by 1/512 px at most"),
    tradeChoice<&Trade::subpixelBits, 4u>("4", "vertices snapped to 1/16 px", "off by 1/32 px at most"),
};
inline constexpr TradeChoice kTransformChoices[] = {
    tradeChoice<&Trade::precision, Precision::fp32>("fp32", "float32, from a composite matrix made in binary64"),
    tradeChoice<&Trade::precision, Precision::fp64>("fp64", "binary64, rounded to float32 at its end; only where the device has it"),
    tradeChoice<&Trade::precision, Precision::blockInteger>(
        "block-integer", "integers with one exponent an object and a row, rounded to float32 at their end"),
};
inline constexpr TradeChoice kNormalsChoices[] = {
    tradeChoice<&Trade::unitNormals, true>("normalised", "made unit at every pixel"),
    tradeChoice<&Trade::unitNormals, false>("as-interpolated", "unit at vertices, shorter between them"),
};
inline constexpr TradeChoice kRateChoices[] = {
    tradeChoice<&Trade::coarse, false>("1", "every one"),
    tradeChoice<&Trade::coarse, true>("1/2", "one in 2x2, whose colour the others take"),
};
inline constexpr TradeChoice kEncodeChoices[] = {
    tradeChoice<&Trade::nativeEncode, false>("threshold", "the correctly rounded code, by 255 thresholds"),
    tradeChoice<&Trade::nativeEncode, true>("native", "the device's own pow", "at most one code off, next to a tie", Verdict::bounded),
};

// In the order in which help and messages name them.
inline constexpr TradeAxis kTradeAxes[] = {
    {"specular", "the power of the highlight", kSpecularChoices},
    {"light-vector", "where the directions to lights and eye are computed", kVectorsChoices},
    {"interpolation", "how attributes run across a triangle", kInterpolationChoices},
    {"depth", "what the Z-buffer holds", kDepthChoices},
    {"subpixel", "bits of a vertex below the pixel", kSubpixelChoices},
    {"transform", "numbers in which vertices are projected", kTransformChoices, true},
    {"normals", "length of interpolated normals", kNormalsChoices},
    {"rate", "pixels that are shaded", kRateChoices},
    {"encode", "how light becomes bytes", kEncodeChoices},
};

// Null: no axis has the name.
const TradeAxis* tradeAxis(std::string_view name);
// "specular=exact light-vector=pixel ...", every axis.
std::string wordsOf(const Trade& trade);
// The weakest of the verdicts of what is chosen.
Verdict verdictOf(const Trade& trade);

}  // namespace plumb
