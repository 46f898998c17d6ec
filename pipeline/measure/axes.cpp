// SPDX-License-Identifier: MIT
#include "pipeline/measure/axes.h"

#include "host/error.h"
#include "pipeline/choices/choices.h"
#include "pipeline/choices/trade.h"
#include "pipeline/render/technique.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string_view>

namespace plumb {

namespace {

// The choices of an axis from their rows; set(request, value) takes one.
template <class Rows, class Set>
std::vector<AxisChoice> choicesOf(const Rows& rows, Set set) {
    std::vector<AxisChoice> choices;
    for (const auto& row : rows)
        choices.push_back({row.word, row.verdict, [set, value = row.value](Setting& s) { set(s.request, value); }, helpOf(row)});
    return choices;
}

// An axis of --trade.
Axis traded(const char* name) {
    const TradeAxis* axis = tradeAxis(name);
    PLUMB_ASSERT(axis != nullptr);
    std::vector<AxisChoice> choices;
    for (const TradeChoice& row : axis->choices)
        choices.push_back({row.word, row.verdict, [&row](Setting& s) { row.choose(s.request.trade); }, helpOf(row)});
    return {axis->name, axis->what, choices};
}

// Where rays pass through a pixel, without what trades nothing: centre draws what one sample draws, and notes what another program draws.
std::vector<AxisChoice> samplings() {
    std::vector<AxisChoice> choices;
    for (const Choice<Sampling>& row : kSamplings)
        if (row.value != Sampling::centre && row.value != Sampling::notes)
            choices.push_back({row.word, row.verdict, [&row](Setting& s) { s.request.rays.sampling = row.value; }, helpOf(row)});
    return choices;
}

template <uint32_t value>
void useThreads(Setting& s) {
    s.twin = true;
    s.request.threads = value;
}
void useDevice(Setting& s) { s.twin = false; }
void useTwin(Setting& s) { s.twin = true; }

template <uint32_t value>
void followTo(Setting& s) {
    s.request.maxDepth = value;
}
// One part in `divisor`; 0: none.
template <uint32_t divisor>
void cutBelow(Setting& s) {
    s.request.minWeight = divisor == 0 ? 0.0f : 1.0f / float(divisor);
}

// What is stated stays.
void keep(Setting&) {}

void drawAgain(Setting& s) { s.again = true; }
void dropNothing(Setting& s) { s.request.knobs.keepEverything = true; }

template <uint32_t value>
void drawSegments(Setting& s) {
    s.segments = value;
}
// A deviation of numerator / divisor pixels.
template <uint32_t numerator, uint32_t divisor>
void keepDetail(Setting& s) {
    s.detail = double(numerator) / divisor;
}

// What people ask about a picture, first to last. What is missing here follows in the order of kAxes.
constexpr const char* kAsked[] = {"samples",      "shading", "trace-depth", "trace-cutoff", "ray-sampling",  "specular",
                                  "light-vector", "normals", "rate",        "fill",         "interpolation", "depth"};

// In the order in which a picture is made, after the row that no picture needs.
const std::vector<Axis> kAxes = {
    {"control",
     "how far apart two measurements of one work come out",
     {{"default again", Verdict::bits, drawAgain, "the default picture once more: nothing but noise"}},
     Scope::both},
    {"plan",
     "what a picture leaves out that it does not need; no byte changes",
     {{"lossless", Verdict::bits, keep, "as the scene asks for it"},
      {"full", Verdict::bits, dropNothing, "nothing is left out: every step, object, light and ray"}},
     Scope::both},
    {"shading", "how a surface is lit", choicesOf(kShadings, [](RenderRequest& r, Shading value) { r.shading = value; }), Scope::both},
    {"tessellation",
     "polygons once around a generated shape; the truth is the shape itself",
     {{"stated", Verdict::bits, keep, "as the scene has it"},
      {"8", Verdict::bits, drawSegments<8>, "8 segments, as the notes' cylinder"},
      {"16", Verdict::bits, drawSegments<16>, "16"},
      {"32", Verdict::bits, drawSegments<32>, "32"},
      {"64", Verdict::bits, drawSegments<64>, "64"},
      {"128", Verdict::bits, drawSegments<128>, "128"},
      {"256", Verdict::bits, drawSegments<256>, "256"},
      {"512", Verdict::bits, drawSegments<512>, "512; the teapot has 256 at most"}},
     Scope::both},
    {"detail",
     "meshes simplified, and shapes tessellated, for the camera; times are without that, which happens once",
     {{"whole", Verdict::bits, keep, "as the scene has it"},
      {"1/4", Verdict::bits, keepDetail<1, 4>, "outlines move by at most 1/4 px"},
      {"1/2", Verdict::bits, keepDetail<1, 2>, "1/2 px"},
      {"1", Verdict::bits, keepDetail<1, 1>, "1 px"},
      {"2", Verdict::bits, keepDetail<2, 1>, "2 px"},
      {"4", Verdict::bits, keepDetail<4, 1>, "4 px"}},
     Scope::both},
    traded("transform"),
    traded("subpixel"),
    {"fill", "which pixels a triangle covers", choicesOf(kFills, [](RenderRequest& r, Fill value) { r.fill = value; })},
    traded("interpolation"),
    traded("depth"),
    traded("normals"),
    traded("light-vector"),
    traded("specular"),
    traded("rate"),
    traded("encode"),
    {"encoding", "the curve of the bytes", choicesOf(kEncodings, [](RenderRequest& r, Encoding value) { r.encoding = value; }),
     Scope::both},
    {"samples", "samples a pixel", choicesOf(kSampleCounts, [](RenderRequest& r, uint32_t value) { r.samples = value; }), Scope::both},
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
    {"ray-sampling", "where rays pass through a pixel", samplings(), Scope::rays},
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

bool hasTruth(const RenderRequest& request) { return request.shading != Shading::wire; }

std::string wordsOf(const Setting& s) {
    const RenderRequest& r = s.request;
    const std::string machine = (s.twin ? fmt::format("renderer=twin threads={}", r.threads) : "renderer=device") +
                                (s.again ? " again" : "") + (s.segments != 0 ? fmt::format(" tessellation={}", s.segments) : "") +
                                (s.detail != 0 ? fmt::format(" detail={:g}", s.detail) : "") + (r.knobs.keepEverything ? " plan=full" : "");
    if (isTraced(r))
        return fmt::format("shading={} encoding={} samples={} trace-depth={} trace-cutoff={} ray-sampling={} {}", nameOf(r.shading),
                           nameOf(r.encoding), r.samples, r.maxDepth, r.minWeight, nameOf(r.rays.sampling), machine);
    return fmt::format("shading={} fill={} encoding={} samples={} {} {}", nameOf(r.shading), nameOf(r.fill), nameOf(r.encoding), r.samples,
                       wordsOf(r.trade), machine);
}

std::span<const Axis> axes() { return kAxes; }

size_t askedRank(const Axis& axis) {
    const auto asked = std::find(std::begin(kAsked), std::end(kAsked), std::string_view(axis.name));
    if (asked != std::end(kAsked)) return size_t(asked - std::begin(kAsked));
    const auto own = std::find_if(kAxes.begin(), kAxes.end(), [&](const Axis& one) { return &one == &axis; });
    return std::size(kAsked) + size_t(own - kAxes.begin());
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

const Axis& axisOf(const std::string& name) {
    std::string accepted;
    for (const Axis& axis : kAxes) {
        if (name == axis.name) return axis;
        accepted += (accepted.empty() ? "" : ", ") + std::string(axis.name);
    }
    throw usageError(fmt::format("--axis: '{}' is refused; accepted, by commas: {}", name, accepted));
}

}  // namespace plumb
