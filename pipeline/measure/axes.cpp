// SPDX-License-Identifier: MIT
#include "pipeline/measure/axes.h"

#include "host/error.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string_view>

namespace plumb {

namespace {

template <Shading value>
void shade(Setting& s) {
    s.request.shading = value;
}
template <Encoding value>
void encode(Setting& s) {
    s.request.encoding = value;
}
template <uint32_t value>
void sample(Setting& s) {
    s.request.samples = value;
}
template <uint32_t value>
void useThreads(Setting& s) {
    s.twin = true;
    s.request.threads = value;
}
void useDevice(Setting& s) { s.twin = false; }
void useTwin(Setting& s) { s.twin = true; }

template <Fill value>
void fillBy(Setting& s) {
    s.request.fill = value;
}

template <uint32_t value>
void followTo(Setting& s) {
    s.request.maxDepth = value;
}
// One part in `divisor`; 0: none.
template <uint32_t divisor>
void cutBelow(Setting& s) {
    s.request.minWeight = divisor == 0 ? 0.0f : 1.0f / float(divisor);
}
template <RayChoices::Sampling value>
void sampleRays(Setting& s) {
    s.request.rays.sampling = value;
}

using Specular = Trade::Specular;
using Vectors = Trade::Vectors;
// trade<&Trade::member, value>
template <auto member, auto value>
void trade(Setting& s) {
    s.request.trade.*member = value;
}
// What is stated stays.
void keep(Setting&) {}

void drawAgain(Setting& s) { s.again = true; }

// What people ask about a picture, first to last. What is missing here follows in the order of kAxes.
constexpr const char* kAsked[] = {"samples",      "shading", "trace-depth", "trace-cutoff", "ray-sampling",  "specular",
                                  "light-vector", "normals", "rate",        "fill",         "interpolation", "depth"};

// In the order in which a picture is made, after the row that no picture needs.
const std::vector<Axis> kAxes = {
    {"control",
     "how far apart two measurements of one work come out",
     {{"default again", Verdict::bits, drawAgain, "the default picture once more: nothing but noise"}},
     Scope::both},
    {"shading",
     "how a surface is lit",
     {{"wire", Verdict::bits, shade<Shading::wire>, "edges only"},
      {"unlit", Verdict::bits, shade<Shading::unlit>, "the material's own colour"},
      {"flat", Verdict::bits, shade<Shading::flat>, "one illumination a face"},
      {"gouraud", Verdict::bits, shade<Shading::gouraud>, "one illumination a vertex, interpolated"},
      {"phong", Verdict::bits, shade<Shading::phong>, "one illumination a pixel"},
      {"ray", Verdict::bits, shade<Shading::ray>, "rays from the eye: shadows, mirrors and glass"}},
     Scope::both},
    {"transform",
     "numbers in which vertices are projected",
     {{"fp32", Verdict::bits, trade<&Trade::numbers, Numbers::fp32>, "float32, from a composite matrix made in binary64"},
      {"fp64", Verdict::bits, trade<&Trade::numbers, Numbers::fp64>,
       "binary64, rounded to float32 at its end; only where the device has it"},
      {"block-integer", Verdict::bits, trade<&Trade::numbers, Numbers::blockInteger>,
       "integers with one exponent an object and a row, rounded to float32 at their end"}}},
    {"subpixel",
     "bits of a vertex below the pixel",
     {{"8", Verdict::bits, trade<&Trade::subpixelBits, 8>, "vertices snapped to 1/256 px: off by 1/512 px at most"},
      {"4", Verdict::bits, trade<&Trade::subpixelBits, 4>, "vertices snapped to 1/16 px: off by 1/32 px at most"}}},
    {"fill",
     "which pixels a triangle covers",
     {{"exact", Verdict::bits, fillBy<Fill::exact>, "exact edge values, top-left rule"},
      {"notes", Verdict::bits, fillBy<Fill::notes>, "the lecture notes' fill, against the truth at whole coordinates, which it samples"}}},
    {"interpolation",
     "how attributes run across a triangle",
     {{"perspective", Verdict::bits, trade<&Trade::affine, false>, "weighted by 1/w"},
      {"affine", Verdict::bits, trade<&Trade::affine, true>, "linear on the screen"}}},
    {"depth",
     "what the Z-buffer holds",
     {{"reversed-32", Verdict::bits, trade<&Trade::depthBits, 32>, "n/w as float32"},
      {"standard-32", Verdict::bits, trade<&Trade::depthBits, Trade::kStandardDepth>,
       "1 - n/w as float32, the usual way round: off by less than 2^-24"},
      {"24", Verdict::bits, trade<&Trade::depthBits, 24>, "n/w in fixed point: off by less than 2^-24"},
      {"16", Verdict::bits, trade<&Trade::depthBits, 16>, "n/w in fixed point: off by less than 2^-16"}}},
    {"normals",
     "length of interpolated normals",
     {{"normalised", Verdict::bits, trade<&Trade::unitNormals, true>, "made unit at every pixel"},
      {"as-interpolated", Verdict::bits, trade<&Trade::unitNormals, false>, "unit at vertices, shorter between them"}}},
    {"light-vector",
     "where the directions to lights and eye are computed",
     {{"pixel", Verdict::bits, trade<&Trade::vectors, Vectors::pixel>, "at every pixel"},
      {"vertex", Verdict::bits, trade<&Trade::vectors, Vectors::vertex>,
       "at the corners of what is drawn, interpolated, not made unit again"},
      {"face", Verdict::bits, trade<&Trade::vectors, Vectors::face>, "once a face, at its centre"},
      {"scene", Verdict::bits, trade<&Trade::vectors, Vectors::scene>, "one to the eye, and to each light from the framed centre"}}},
    {"specular",
     "the power of the highlight",
     {{"exact", Verdict::bits, trade<&Trade::specular, Specular::exact>, "polynomials of our own"},
      {"schlick", Verdict::bits, trade<&Trade::specular, Specular::schlick>,
       "a quotient: at most 0.2037 above the power for exponents from 1"},
      {"native", Verdict::bounded, trade<&Trade::specular, Specular::native>, "the device's own pow: within a bound of the exact one"}}},
    {"rate",
     "pixels that are shaded",
     {{"1", Verdict::bits, trade<&Trade::coarse, false>, "every one"},
      {"1/2", Verdict::bits, trade<&Trade::coarse, true>, "one in 2x2, whose colour the others take"}}},
    {"encode",
     "how light becomes bytes",
     {{"threshold", Verdict::bits, trade<&Trade::nativeEncode, false>, "the correctly rounded code, by 255 thresholds"},
      {"native", Verdict::bounded, trade<&Trade::nativeEncode, true>, "the device's own pow: at most one code off, next to a tie"}}},
    {"encoding",
     "the curve of the bytes",
     {{"srgb", Verdict::bits, encode<Encoding::srgb>, "IEC 61966-2-1"},
      {"linear", Verdict::bits, encode<Encoding::linear>, "bytes in proportion to light"}},
     Scope::both},
    {"samples",
     "samples a pixel",
     {{"1", Verdict::bits, sample<1>, "the pixel's centre"},
      {"4", Verdict::bits, sample<4>, "2x2, resolved in linear light"},
      {"16", Verdict::bits, sample<16>, "4x4, resolved in linear light"}},
     Scope::both},
    {"trace-depth",
     "rays one after another",
     {{"stated", Verdict::bits, keep, "as the scene or --max-depth has it"},
      {"1", Verdict::bits, followTo<1>, "from the eye only: mirrors and glass show their own colour"},
      {"2", Verdict::bits, followTo<2>, "what mirrors show is not mirrored again"},
      {"3", Verdict::bits, followTo<3>, "three"},
      {"5", Verdict::bits, followTo<5>, "five, as the notes' program"},
      {"10", Verdict::bits, followTo<10>, "ten"}},
     Scope::rays},
    {"trace-cutoff",
     "weight below which a ray is not followed",
     {{"stated", Verdict::bits, keep, "as the scene or --min-weight has it"},
      {"0", Verdict::bits, cutBelow<0>, "every ray is followed to the depth"},
      {"1/256", Verdict::bits, cutBelow<256>, "about a step of the code at full light"},
      {"1/100", Verdict::bits, cutBelow<100>, "1 %, as the notes have it"},
      {"1/10", Verdict::bits, cutBelow<10>, "10 %, as the notes have it"}},
     Scope::rays},
    {"ray-sampling",
     "where rays pass through a pixel",
     {{"grid", Verdict::bits, sampleRays<RayChoices::Sampling::grid>, "the middle of each sample's square"},
      {"random", Verdict::bits, sampleRays<RayChoices::Sampling::random>, "anywhere in each sample's square"},
      {"corners", Verdict::bits, sampleRays<RayChoices::Sampling::corners>, "the pixel's corners, each ray shared by four pixels"},
      {"adaptive", Verdict::bits, sampleRays<RayChoices::Sampling::adaptive>, "corners, and 16 samples where they differ"}},
     Scope::rays},
    {"renderer",
     "what draws",
     {{"device", Verdict::bits, useDevice, "the Vulkan device"}, {"twin", Verdict::bits, useTwin, "the CPU twin on all threads"}},
     Scope::both},
    {"threads",
     "threads of the CPU twin",
     {{"1", Verdict::bits, useThreads<1>, "one"}, {"2", Verdict::bits, useThreads<2>, "two"}, {"4", Verdict::bits, useThreads<4>, "four"}},
     Scope::both},
};

}  // namespace

std::string wordsOf(const Setting& s) {
    const RenderRequest& r = s.request;
    static constexpr const char* kShadings[] = {"wire", "unlit", "flat", "gouraud", "phong", "ray"};
    const Trade& t = r.trade;
    static constexpr const char* kNumbers[] = {"fp32", "block-integer", "fp64"};
    static constexpr const char* kVectors[] = {"pixel", "vertex", "face", "scene"};
    static constexpr const char* kSpeculars[] = {"exact", "schlick", "native"};
    const std::string depth = t.depthBits == 32                      ? "reversed-32"
                              : t.depthBits == Trade::kStandardDepth ? "standard-32"
                                                                     : std::to_string(t.depthBits);
    const std::string machine =
        (s.twin ? fmt::format("renderer=twin threads={}", r.threads) : "renderer=device") + (s.again ? " again" : "");
    if (r.shading == Shading::ray)
        return fmt::format("shading=ray encoding={} samples={} trace-depth={} trace-cutoff={} ray-sampling={} {}",
                           r.encoding == Encoding::srgb ? "srgb" : "linear", r.samples, r.maxDepth, r.minWeight, nameOf(r.rays.sampling),
                           machine);
    return fmt::format(
        "shading={} fill={} encoding={} samples={} specular={} light-vector={} interpolation={} depth={} subpixel={} transform={} "
        "normals={} rate={} encode={} {}",
        kShadings[size_t(r.shading)], r.fill == Fill::notes ? "notes" : "exact", r.encoding == Encoding::srgb ? "srgb" : "linear",
        r.samples, kSpeculars[size_t(t.specular)], kVectors[size_t(t.vectors)], t.affine ? "affine" : "perspective", depth, t.subpixelBits,
        kNumbers[size_t(t.numbers)], t.unitNormals ? "normalised" : "as-interpolated", t.coarse ? "1/2" : "1",
        t.nativeEncode ? "native" : "threshold", machine);
}

std::span<const Axis> axes() { return kAxes; }

size_t askedPlace(const Axis& axis) {
    const auto asked = std::find(std::begin(kAsked), std::end(kAsked), std::string_view(axis.name));
    return size_t(asked - std::begin(kAsked)) + (asked == std::end(kAsked) ? size_t(&axis - kAxes.data()) : 0);
}

const Axis& controlAxis() { return kAxes.front(); }

uint32_t mostSamples(const Setting& base) {
    // Adaptive sampling takes that many where corners differ.
    uint32_t most = std::max(base.request.samples, 16u);
    for (const Axis& axis : kAxes)
        for (const AxisChoice& choice : axis.choices) {
            if (choice.apply == nullptr) continue;
            Setting setting = base;
            choice.apply(setting);
            most = std::max(most, setting.request.samples);
        }
    return most;
}

void apply(Setting& setting, const std::string& axisName, const std::string& choiceName) {
    const Axis& axis = axisOf(axisName);
    std::string accepted;
    for (const AxisChoice& choice : axis.choices) {
        if (choice.apply != nullptr && choiceName == choice.name) return choice.apply(setting);
        if (choice.apply != nullptr) accepted += (accepted.empty() ? "" : ", ") + std::string(choice.name);
    }
    throw usageError(fmt::format("'{}={}' is refused; accepted for {}: {}", axisName, choiceName, axisName,
                                 accepted.empty() ? "nothing in this version" : accepted));
}

const Axis& axisOf(const std::string& name) {
    std::string accepted;
    for (const Axis& axis : kAxes) {
        if (name == axis.name) return axis;
        accepted += (accepted.empty() ? "" : ", ") + std::string(axis.name);
    }
    throw usageError(fmt::format("--axis: '{}' is refused; accepted, by commas: {}", name, accepted));
}

}  // namespace plumb
