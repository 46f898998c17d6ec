// SPDX-License-Identifier: MIT
#include "pipeline/command/request.h"

#include "host/error.h"
#include "pipeline/command/interrupt.h"
#include "pipeline/library/open_scene.h"
#include "pipeline/render/technique.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <utility>

namespace plumb {
namespace {

// IEC 61966-2-1 in binary64; encoding the rounded result gives the byte back.
float linearFromByte(uint8_t byte, Encoding encoding) {
    const double x = byte / 255.0;
    if (encoding == Encoding::linear) return float(x);
    return float(x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4));
}

uint32_t byteFromLinear(float linear, Encoding encoding) {
    const double x = std::clamp(double(linear), 0.0, 1.0);
    const double encoded = encoding == Encoding::linear ? x : x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    return uint32_t(std::lround(encoded * 255));
}

// Stated, or what the scene asks for; what is stated of a raster shading keeps the raster.
void chooseShading(const Options& options, const Scene& scene, RenderRequest& request) {
    std::string& asked = request.stated.shading;
    asked.clear();
    request.shading = options.shading ? *options.shading : shadingFor(scene, request.fill, asked);
    if (asked.empty()) return;
    asked += "; --shading overrides";
    if (onlyRaysDraw(scene) || options.traded.empty()) return;
    request.shading = Shading::phong;
    asked.clear();
}

// The flag, or else the scene.
template <class Value>
Value stated(const std::optional<Value>& flag, const std::optional<Value>& scene, Value fallback, const char* name, std::string& by) {
    if (flag)
        by = name;
    else if (scene)
        by = fmt::format("the scene; {} overrides", name);
    return flag ? *flag : scene.value_or(fallback);
}

void rayChoices(const Options& options, const Scene& scene, RenderRequest& request) {
    const std::pair<const char*, bool> flags[] = {
        {"--sampling", options.sampling.has_value()},
        {"--jitter", options.jitterReflect || options.jitterRefract || options.jitterShadow},
        {"--seed", options.seed && options.command != kMeasure},  // there it turns the order of rounds as well
        {"--levels", options.cutLevels.has_value()},
        {"--max-depth", options.maxDepth.has_value()},
        {"--min-weight", options.minWeight.has_value()}};
    const bool traced = isTraced(request);
    for (const auto& [flag, given] : flags)
        if (given && !traced) throw usageError(fmt::format("{} goes with --shading ray", flag));
    request.rays = {};
    if (!traced) return;
    RayChoices& rays = request.rays;
    Stated& by = request.stated;
    rays.sampling = stated(options.sampling, scene.sampling, Sampling::grid, "--sampling", by.sampling);
    if (!options.sampling && scene.sampling && options.samples.value_or(1) != 1 &&
        (rays.sampling == Sampling::corners || rays.sampling == Sampling::adaptive))
        throw usageError(
            fmt::format("--samples: the scene's sampling = \"{}\" has its own number of samples; leave --samples out, or state --sampling",
                        nameOf(rays.sampling)));
    // Each noise by itself: --jitter reflect=0 leaves the scene's others.
    std::string first, second, third;
    rays.jitterReflect = float(stated(options.jitterReflect, scene.jitterReflect, 0.0, "--jitter", first));
    rays.jitterRefract = float(stated(options.jitterRefract, scene.jitterRefract, 0.0, "--jitter", second));
    rays.jitterShadow = float(stated(options.jitterShadow, scene.jitterShadow, 0.0, "--jitter", third));
    for (const std::string& one : {first, second, third})
        if (!one.empty() && by.jitter.empty()) by.jitter = one;
    for (const std::string& one : {first, second, third})
        if (!one.empty() && one != by.jitter) by.jitter = "the scene and --jitter, which overrides";
    rays.seed = stated(options.seed, scene.seed, 0u, "--seed", by.seed);
    rays.cutLevels = stated(options.cutLevels, scene.cutLevels, false, "--levels", by.levels);
}

}  // namespace

LoadOptions loadOptionsOf(const Options& options, Progress* progress, double from, double to) {
    LoadOptions load;
    load.allowOutside = options.allowOutside;
    load.strict = options.strict;
    load.camera = options.camera;
    load.creaseDegrees = options.creaseDegrees;
    load.keepNumbers = options.withError || !options.error.empty() || options.timeMs || options.command == kPlan ||
                       options.command == kMeasure || options.command == kPixel || options.command == kInfo || options.command == kStress;
    load.format = options.format;
    load.onProgress = [progress, from, to, stage = ""](double done, const char* now) mutable {
        stopIfInterrupted();
        if (progress == nullptr) return;
        if (stage[0] == '\0') progress->begin("load", from, to, Progress::kMoment);
        if (stage != now) progress->rename(fmt::format("load {}", stage = now));
        progress->update(done);
    };
    return load;
}

DeviceRequest deviceRequestOf(const Options& options) {
    DeviceRequest request;
    request.prefer = options.device;
    request.require = options.requireDevice;
    request.memoryBudgetBytes = options.memoryBytes;
    return request;
}

RenderRequest requestOf(const Options& options, const Scene& scene, glm::uvec2 size) {
    RenderRequest request = requestFor(scene);
    request.width = size.x;
    request.height = size.y;
    request.fill = options.fill.value_or(request.fill);
    chooseShading(options, scene, request);
    request.wire = options.wire.value_or(request.wire);
    request.wirePerPolygon = options.wirePerPolygon.value_or(request.wirePerPolygon);
    if (request.shading != Shading::wire && (options.wire || options.wirePerPolygon))
        throw usageError("--wire and --edges go with --shading wire");
    request.distantViewer = options.distantViewer.value_or(request.distantViewer);
    request.maxDepth = options.maxDepth.value_or(request.maxDepth);
    if (options.minWeight) request.minWeight = float(*options.minWeight);
    rayChoices(options, scene, request);
    request.encoding = options.encoding.value_or(request.encoding);
    request.samples = options.samples.value_or(1);
    if (options.background) {
        request.transparent = options.background->transparent;
        for (int c = 0; c < 3; ++c)
            request.background[c] = request.transparent ? 0 : linearFromByte(options.background->rgb[size_t(c)], request.encoding);
    }
    request.trade = options.trade;
    request.threads = options.threads;
    request.knobs.chunkTriangles = options.limitChunk;
    request.knobs.bandRows = options.limitBand;
    request.watchdogMs = options.watchdogMs;
    return request;
}

const char* determinismOf(const RenderRequest& request) { return nameOf(verdictOf(request.trade)); }

uint32_t backgroundPixel(const RenderRequest& request) {
    uint32_t pixel = request.transparent ? 0 : 0xff000000u;
    for (int c = 0; c < 3; ++c) pixel |= byteFromLinear(request.background[c], request.encoding) << (8 * c);
    return pixel;
}

}  // namespace plumb
