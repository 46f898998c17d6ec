// SPDX-License-Identifier: MIT
#include "pipeline/measure/axes.h"

#include "host/error.h"

#include <fmt/format.h>

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

// In the order in which a picture is made.
const std::vector<Axis> kAxes = {
    {"shading",
     "how a surface is lit",
     {{"wire", Verdict::bits, shade<Shading::wire>, "edges only"},
      {"unlit", Verdict::bits, shade<Shading::unlit>, "the material's own colour"},
      {"flat", Verdict::bits, shade<Shading::flat>, "one illumination a face"},
      {"gouraud", Verdict::bits, shade<Shading::gouraud>, "one illumination a vertex, interpolated"},
      {"phong", Verdict::bits, shade<Shading::phong>, "one illumination a pixel"}}},
    {"transform",
     "numbers in which vertices are projected",
     {{"fp64", Verdict::bits, nullptr, "vertices are projected in float32; a binary64 kernel does not exist yet"},
      {"block-integer", Verdict::bits, nullptr, "a block-scaled integer kernel does not exist yet"}}},
    {"subpixel",
     "bits of a vertex below the pixel",
     {{"8", Verdict::bits, [](Setting&) {}, "vertices snapped to 1/256 px"},
      {"4", Verdict::bits, nullptr, "the screen grid has 8 bits throughout"}}},
    {"fill",
     "which pixels a triangle covers",
     {{"exact", Verdict::bits, [](Setting&) {}, "exact edge values, top-left rule"},
      {"notes", Verdict::bits, nullptr, "the lecture notes' span filler is not a choice of this version"}}},
    {"interpolation",
     "how attributes run across a triangle",
     {{"perspective", Verdict::bits, [](Setting&) {}, "weighted by 1/w"},
      {"affine", Verdict::bits, nullptr, "there is no affine kernel yet"}}},
    {"depth",
     "what the Z-buffer holds",
     {{"reversed-float32", Verdict::bits, [](Setting&) {}, "n/w as float32"},
      {"16", Verdict::bits, nullptr, "there is no 16-bit depth yet"},
      {"24", Verdict::bits, nullptr, "there is no 24-bit depth yet"}}},
    {"normals",
     "length of interpolated normals",
     {{"normalised", Verdict::bits, [](Setting&) {}, "made unit at every pixel"},
      {"as-interpolated", Verdict::bits, nullptr, "there is no kernel without it yet"}}},
    {"light-vector",
     "where the directions to lights and eye are computed",
     {{"pixel", Verdict::bits, [](Setting&) {}, "at every pixel"},
      {"scene", Verdict::bits, nullptr, "there is no kernel with one direction a scene yet"}}},
    {"specular",
     "the power of the highlight",
     {{"exact", Verdict::bits, [](Setting&) {}, "polynomials of our own"},
      {"native", Verdict::bounded, nullptr, "the device's pow is not used yet"},
      {"schlick", Verdict::bits, nullptr, "Schlick's quotient is not written yet"}}},
    {"rate",
     "pixels that are shaded",
     {{"1", Verdict::bits, [](Setting&) {}, "every one"},
      {"1/2", Verdict::bits, nullptr, "there is no coarser shading yet"}}},
    {"encode",
     "how light becomes bytes",
     {{"threshold", Verdict::bits, [](Setting&) {}, "the correctly rounded code, by 255 thresholds"},
      {"native", Verdict::bounded, nullptr, "the device's pow is not used yet"}}},
    {"encoding",
     "the curve of the bytes",
     {{"srgb", Verdict::bits, encode<Encoding::srgb>, "IEC 61966-2-1"},
      {"linear", Verdict::bits, encode<Encoding::linear>, "bytes in proportion to light"}}},
    {"samples",
     "samples a pixel",
     {{"1", Verdict::bits, sample<1>, "the pixel's centre"},
      {"4", Verdict::bits, sample<4>, "2x2, resolved in linear light"},
      {"16", Verdict::bits, sample<16>, "4x4, resolved in linear light"}}},
    {"trace",
     "rays after the first",
     {{"depth", Verdict::bits, nullptr, "nothing is traced in this version"},
      {"cutoff", Verdict::bits, nullptr, "nothing is traced in this version"}}},
    {"renderer",
     "what draws",
     {{"device", Verdict::bits, useDevice, "the Vulkan device"},
      {"twin", Verdict::bits, useTwin, "the CPU twin on all threads"}}},
    {"threads",
     "threads of the CPU twin",
     {{"1", Verdict::bits, useThreads<1>, "one"},
      {"2", Verdict::bits, useThreads<2>, "two"},
      {"4", Verdict::bits, useThreads<4>, "four"}}},
};

}  // namespace

const char* nameOf(Verdict verdict) {
    static constexpr const char* kNames[] = {"bits", "bounded", "free"};
    return kNames[size_t(verdict)];
}

std::string wordsOf(const Setting& s) {
    const RenderRequest& r = s.request;
    return fmt::format("shading={} encoding={} samples={} renderer={}{}", int(r.shading), int(r.encoding), r.samples,
                       s.twin ? "twin" : "device", s.twin ? fmt::format(" threads={}", r.threads) : "");
}

std::span<const Axis> axes() { return kAxes; }

const Axis& axisOf(const std::string& name) {
    std::string accepted;
    for (const Axis& axis : kAxes) {
        if (name == axis.name) return axis;
        accepted += (accepted.empty() ? "" : ", ") + std::string(axis.name);
    }
    throw usageError(fmt::format("--axis: '{}' is refused; accepted, by commas: {}", name, accepted));
}

}  // namespace plumb
