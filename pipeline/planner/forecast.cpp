// SPDX-License-Identifier: MIT
#include "pipeline/planner/forecast.h"

#include "pipeline/render/bounds/bound.h"
#include "pipeline/truth/truth.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace plumb {
namespace {

constexpr double kForecastRays = 5e5;
constexpr uint64_t kPilotPixels = 256;
// About a step of the code at full light.
constexpr float kCutoff = 1 / 256.0f;

// Largest change of a pixel by moves of its linear light, in steps.
double stepsOf(const Frame& frame, const BoundOfRays::Moves& moves) {
    double most = 0;
    for (size_t i = 0; i < frame.linear.size(); ++i) {
        const double light = double(frame.linear[i]), code = srgbCode(light);
        most = std::max({most, srgbCode(light + double(moves.brighter[i])) - code, code - srgbCode(light - double(moves.darker[i]))});
    }
    return most;
}

std::string timeText(double ms) {
    if (ms < 100e3) return fmt::format("{:.2g} s", ms / 1e3);
    return ms < 100 * 60e3 ? fmt::format("{:.0f} min", ms / 60e3) : fmt::format("{:.3g} h", ms / 3600e3);
}

}  // namespace

double mostRaysOf(const Scene& scene, const RenderRequest& request) {
    const bool both = std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) { return m.transmit > 0; });
    const double depth = request.maxDepth, tree = both ? std::exp2(depth) : depth;
    const double samples = request.rays.sampling == Sampling::adaptive ? 20 : request.samples;
    return double(request.width) * request.height * samples * tree * double(1 + scene.lights.size());
}

double pilotMs(const Scene& scene, const RenderRequest& request) {
    Probe pilot(scene, request, kPilotPixels, 1, [&request] { return !request.onProgress || request.onProgress(0); });
    return pilot.of({request, ""}, false).work[Unit::ray] * pilot.msPerRay();
}

RayForecast forecastRays(const Scene& scene, const PlannerRequest& request) {
    PlannerRequest forecast = request;
    forecast.probedRays = std::min(forecast.probedRays, kForecastRays);
    RayForecast f;
    f.picture = predictPicture(scene, forecast);
    f.rays = f.picture.weighed[0].work[Unit::ray];
    if (request.base.minWeight >= kCutoff || f.rays <= 0) return f;
    const uint64_t pixels = uint64_t(request.base.width) * request.base.height / (uint64_t(f.picture.shrink) * f.picture.shrink);
    Probe probe(scene, request.base, std::max<uint64_t>(pixels, 1), 1, [&request] { return !request.onProgress || request.onProgress(0); });
    RenderRequest whole = probe.smaller(request.base), cut = whole;
    whole.planes |= kPlaneLinear;
    cut.minWeight = kCutoff;
    const RenderResult base = renderCpu(probe.scene(), whole), fewer = renderCpu(probe.scene(), cut);
    RayForecast::Less less;
    less.minWeight = kCutoff;
    less.share = raysOf(fewer.counters) / std::max(1.0, raysOf(base.counters));
    if (less.share >= 1) return f;
    const BoundOfRays::Moves moves = BoundOfRays(probe.scene(), whole).of(cut);
    if (moves.proved)
        less.steps = stepsOf(base.frame, moves);
    else
        less.why = moves.why;
    f.less = less;
    return f;
}

std::string sentenceOf(const RayForecast& forecast) {
    std::string text = fmt::format("about {:.2g} rays, about {}", forecast.rays, timeText(forecast.picture.weighed[0].costMs));
    if (!forecast.less) return text;
    return text + fmt::format("; --min-weight 1/{:g} leaves {:.2g} % of them, {}", 1 / double(forecast.less->minWeight),
                              100 * forecast.less->share,
                              forecast.less->steps ? fmt::format("at most {:.2g} steps", *forecast.less->steps)
                                                   : "without a bound: " + forecast.less->why);
}

}  // namespace plumb
