// SPDX-License-Identifier: MIT
#include "pipeline/command/request.h"

#include "pipeline/command/interrupt.h"
#include "pipeline/measure/axes.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

LoadOptions loadOptionsOf(const Options& options) {
    LoadOptions load;
    load.allowOutside = options.allowOutside;
    load.strict = options.strict;
    load.creaseDegrees = options.creaseDegrees;
    load.onProgress = [](double) { stopIfInterrupted(); };
    return load;
}

RenderRequest requestOf(const Options& options, const Scene& scene, glm::uvec2 size) {
    RenderRequest request;
    request.width = size.x;
    request.height = size.y;
    request.shading = options.shading.value_or(scene.shading.value_or(onlyRaysDraw(scene) ? Shading::ray : Shading::phong));
    request.fill = options.fill.value_or(scene.fill.value_or(Fill::exact));
    request.maxDepth = options.maxDepth.value_or(scene.maxDepth);
    request.minWeight = float(options.minWeight.value_or(scene.minWeight));
    if (request.shading != Shading::ray && options.maxDepth) throw usageError("--max-depth goes with --shading ray");
    if (request.shading != Shading::ray && options.minWeight) throw usageError("--min-weight goes with --shading ray");
    if (request.shading == Shading::ray && request.fill == Fill::notes) throw usageError("--fill notes is a fill of the raster shadings; --shading ray has none");
    request.encoding = options.encoding.value_or(scene.encoding.value_or(Encoding::srgb));
    request.samples = options.samples;
    request.background = scene.background.value_or(glm::vec3(0));
    if (options.background) {
        request.transparent = options.background->transparent;
        for (int c = 0; c < 3; ++c) request.background[c] = request.transparent ? 0 : linearFromByte(options.background->rgb[size_t(c)], request.encoding);
    }
    Setting setting{request, false};
    for (const auto& [axis, choice] : options.trade) apply(setting, axis, choice);
    request.trade = setting.request.trade;
    if (request.shading == Shading::ray && request.trade != Trade{}) throw usageError("--trade is about the raster shadings; --shading ray has none of these choices");
    if (request.fill == Fill::notes) {
        Trade other = request.trade;
        other.specular = Trade().specular;
        if (other != Trade{}) throw usageError("--trade: --fill notes has the axis specular; the others are of --fill exact");
    }
    request.threads = options.threads;
    request.chunkTriangles = options.limitChunk;
    request.bandRows = options.limitBand;
    request.watchdogMs = options.watchdogMs;
    return request;
}

const char* determinismOf(const RenderRequest& request) { return request.trade.native() ? "bounded" : "bits"; }

uint32_t backgroundPixel(const RenderRequest& request) {
    uint32_t pixel = request.transparent ? 0 : 0xff000000u;
    for (int c = 0; c < 3; ++c) pixel |= byteFromLinear(request.background[c], request.encoding) << (8 * c);
    return pixel;
}

}  // namespace plumb
