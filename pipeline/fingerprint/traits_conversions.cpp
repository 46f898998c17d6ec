// SPDX-License-Identifier: MIT
// Conversions between float32, integers, halves and whole numbers.
#include "pipeline/fingerprint/traits.h"
#include "shared/fingerprint.h"

#include <cstdint>
#include <iterator>
#include <vector>

namespace plumb::fingerprint {

namespace {

constexpr const char* kJudged = "none: the self-test refuses a device that does not convert exactly, and the twin draws";
constexpr const char* kUnused = "none: no pass has this operation";

// Whole part of |x| for |x| < 2^64, and what the fraction is: 0 none, 1 below half, 2 half, 3 above.
struct WholePart {
    uint64_t whole;
    int fraction;
};
WholePart wholePartOf(uint32_t bits) {
    const int shift = 23 - exponentOf(bits);
    const uint64_t significand = (bits & 0x7fffffu) | 0x800000u;
    if (shift <= 0) return {significand << -shift, 0};
    if (shift > 24) return {0, 1};
    const uint64_t rest = significand & ((uint64_t(1) << shift) - 1), half = uint64_t(1) << (shift - 1);
    return {significand >> shift, rest == 0 ? 0 : rest < half ? 1 : rest == half ? 2 : 3};
}

uint32_t wholeFloat(const Question& q) {
    const bool negative = q[0] >> 31 != 0;
    auto [whole, fraction] = wholePartOf(q[0]);
    const bool up = q[3] == 0   ? negative && fraction != 0
                    : q[3] == 1 ? !negative && fraction != 0
                    : q[3] == 2 ? false
                                : fraction == 3 || (fraction == 2 && (whole & 1) != 0);
    return nearestFloat(exactOfInteger(negative, whole + (up ? 1 : 0)));
}

uint32_t intOf(const Question& q) {
    const uint64_t whole = wholePartOf(q[0]).whole;
    return q[0] >> 31 != 0 ? uint32_t(0 - whole) : uint32_t(whole);
}

// Half of a float32 whose half is normal: cut off, or to nearest even.
uint32_t halfOf(uint32_t bits, bool nearest) {
    const uint32_t kept = bits & 0x7fffffffu;
    const uint32_t half = (kept - (112u << 23)) >> 13, rest = kept & 0x1fffu;
    const bool up = nearest && (rest > 0x1000u || (rest == 0x1000u && (half & 1u) != 0));
    return (bits >> 16 & 0x8000u) | (half + (up ? 1u : 0u));
}

// Float32 of a half that is not a NaN.
uint32_t floatOfHalf(uint32_t half) {
    const uint32_t exponent = half >> 10 & 31u, fraction = half & 1023u;
    const bool negative = half >> 15 != 0;
    if (exponent == 31) return nearestFloat(Exact::infinite(negative));
    if (exponent == 0) return nearestFloat(Exact::finite(negative, fraction, -24));
    return nearestFloat(Exact::finite(negative, fraction | 1024u, int(exponent) - 25));
}

void addIntegersToFloat(std::vector<Trait>& list) {
    const auto integers = [](const char* trait) {
        return [trait](uint32_t i) {
            Draw d(trait, i);
            const uint32_t bits = d.word();
            return Question{d.below(2) == 0 ? bits >> d.below(32) : 0u - (bits >> d.below(32)), 0, 0, 0};
        };
    };
    const auto allowed = [](const Question&, const Exact&) { return kUlp; };
    const char* const promise = "correctly rounded: either neighbour";
    list.push_back({.name = "int-to-float",
                    .group = "conversion",
                    .what = "float(int)",
                    .allowance = promise,
                    .planes = kJudged,
                    .operation = gpu::kAskIntToFloat,
                    .operands = Operands::oneWord,
                    .question = integers("int-to-float"),
                    .exact = [](const Question& q) { return exactOfInteger(q[0] >> 31 != 0, q[0] >> 31 != 0 ? 0u - q[0] : q[0]); },
                    .allowed = allowed});
    list.push_back({.name = "uint-to-float",
                    .group = "conversion",
                    .what = "float(uint)",
                    .allowance = promise,
                    .planes = kJudged,
                    .operation = gpu::kAskUintToFloat,
                    .operands = Operands::oneWord,
                    .question = integers("uint-to-float"),
                    .exact = [](const Question& q) { return exactOfInteger(false, q[0]); },
                    .allowed = allowed});
}

void addFloatsToInteger(std::vector<Trait>& list) {
    list.push_back({.name = "float-to-int",
                    .group = "conversion",
                    .what = "int(float) within the range of an int",
                    .allowance = "the fraction is cut off",
                    .planes = kJudged,
                    .operation = gpu::kAskFloatToInt,
                    .reads = Reads::number,
                    .question =
                        [](uint32_t i) {
                            return Question{Draw("float-to-int", i).real(-3, 30), 0, 0, 0};
                        },
                    .alternatives = {{"cut off", true, intOf}}});
    list.push_back({.name = "float-to-uint",
                    .group = "conversion",
                    .what = "uint(float) within the range of a uint",
                    .allowance = "the fraction is cut off",
                    .planes = kJudged,
                    .operation = gpu::kAskFloatToUint,
                    .reads = Reads::number,
                    .question =
                        [](uint32_t i) {
                            return Question{Draw("float-to-uint", i).positive(-3, 31), 0, 0, 0};
                        },
                    .alternatives = {{"cut off", true, intOf}}});
    const auto outside = [](uint32_t i) {
        constexpr uint32_t kSpecial[] = {0x7f800000u, 0xff800000u, 0x7fc00000u, 0x4f000000u, 0xcf000001u};
        if (i < std::size(kSpecial)) return Question{kSpecial[i], 0, 0, 0};
        return Question{Draw("float-to-int-outside", i).real(32, 127), 0, 0, 0};
    };
    const auto saturated = [](const Question& q) { return q[0] << 1 > 0xff000000u ? 0u : q[0] >> 31 != 0 ? 0x80000000u : 0x7fffffffu; };
    list.push_back({.name = "float-to-int-outside",
                    .group = "conversion",
                    .what = "int(float) beyond the range of an int, and of a NaN",
                    .allowance = "undefined",
                    .planes = "none: passes clamp before they convert",
                    .operation = gpu::kAskFloatToInt,
                    .reads = Reads::number,
                    .items = 256,
                    .question = outside,
                    .alternatives = {{"the smallest int", true, [](const Question&) { return 0x80000000u; }},
                                     {"the nearest int, and 0", true, saturated}},
                    .free = true});
}

void addOthers(std::vector<Trait>& list) {
    const auto halves = [](uint32_t i) {
        Draw d("pack-half", i);
        const uint32_t x = d.real(-14, 14), y = d.real(-14, 14);
        return Question{d.below(4) == 0 ? (x & ~0x1fffu) | 0x1000u : x, y, 0, 0};
    };
    const auto pack = [](bool nearest) {
        return [nearest](const Question& q) { return halfOf(q[0], nearest) | halfOf(q[1], nearest) << 16; };
    };
    list.push_back({.name = "pack-half",
                    .group = "conversion",
                    .what = "packHalf2x16(x, y) of normal halves",
                    .allowance = "either neighbour",
                    .planes = kUnused,
                    .operation = gpu::kAskPackHalf,
                    .operands = Operands::two,
                    .reads = Reads::number,
                    .question = halves,
                    .alternatives = {{"to nearest even", true, pack(true)}, {"toward zero", true, pack(false)}}});
    // The upper half of the word; NaNs are left out.
    const auto unpack = [](uint32_t i) {
        const bool nan = (i >> 10 & 31u) == 31 && (i & 1023u) != 0;
        return Question{(nan ? i & 0xfc00u : i) << 16 | (~i & 0xffffu), 0, 0, 0};
    };
    list.push_back({.name = "unpack-half",
                    .group = "conversion",
                    .what = "unpackHalf2x16: every half that is no NaN",
                    .allowance = "exact; subnormal halves may become 0",
                    .planes = kUnused,
                    .operation = gpu::kAskUnpackHalf,
                    .operands = Operands::oneWord,
                    .reads = Reads::real,
                    .items = 65536,
                    .question = unpack,
                    .alternatives = {{"exact", true, [](const Question& q) { return floatOfHalf(q[0] >> 16); }},
                                     {"subnormal halves become 0", true, [](const Question& q) {
                                          return floatOfHalf((q[0] >> 26 & 31u) == 0 ? q[0] >> 16 & 0x8000u : q[0] >> 16);
                                      }}}});
    const auto wholes = [](uint32_t i) {
        Draw d("whole-numbers", i);
        const uint32_t x = d.real(1, 25), way = d.below(4);
        const int shift = 22 - exponentOf(x);  // of the bit that is a half
        return Question{shift >= 0 && d.below(2) == 0 ? (x >> (shift + 1) << (shift + 1)) | 1u << shift : x, 0, 0, way};
    };
    list.push_back({.name = "whole-numbers",
                    .group = "conversion",
                    .what = "w: 0 floor, 1 ceil, 2 trunc, 3 roundEven",
                    .allowance = "exact",
                    .planes = "none: the self-test and the twin tests hold them",
                    .operation = gpu::kAskWholeNumbers,
                    .operands = Operands::four,
                    .question = wholes,
                    .alternatives = {{"exact", true, wholeFloat}}});
}

}  // namespace

void addConversions(std::vector<Trait>& list) {
    addIntegersToFloat(list);
    addFloatsToInteger(list);
    addOthers(list);
}

}  // namespace plumb::fingerprint
