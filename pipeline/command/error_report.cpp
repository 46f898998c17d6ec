// SPDX-License-Identifier: MIT
#include "pipeline/command/error_report.h"

#include <fmt/core.h>
#include <optional>
#include <string>

namespace plumb {
namespace {

constexpr double kSteps = 255;

Json figuresJson(const ErrorFigures& f, double unit) {
    return {{"max", f.max / unit}, {"maxAt", {f.x, f.y}}, {"mean", f.mean / unit}, {"rms", f.rms / unit}, {"p99", f.p99 / unit}};
}

}  // namespace

Json truthJson(const Truth& truth) {
    return {{"kind", "binary64 oracle"},
            {"samples", truth.samples},
            {"redone", truth.redone},
            {"timeMs", truth.timeMs},
            {"undecided", truth.undecided},
            {"leftOut", truth.leftOut},
            {"description", truth.traced ? "rays from the definitions in binary64, 64 deep and to a weight of 2^-20, without noise; "
                                           "samples whose decisions its bounds leave open are "
                                           "followed again in 64 bits and in binary128"
                                         : "Phong at every sample in binary64: perspective, exact specular power, vertices not snapped; "
                                           "decisions that binary64 leaves open are made "
                                           "without rounding"}};
}

Json errorJson(const FrameError& e, bool sampledAlike, const std::optional<Rounding>& rounding) {
    Json json = figuresJson(e.picture, kSteps);
    json["pixels"] = e.pixels;
    json["nan"] = 0;  // a NaN fails before this
    json["wrongPrimitive"] = sampledAlike ? Json(e.wrongPrimitive) : Json();
    json["wrongPrimitiveShare"] = sampledAlike ? Json(e.wrongShare()) : Json();
    json["wrongPrimitiveAt"] = sampledAlike && e.wrongPrimitive != 0 ? Json({e.wrongX, e.wrongY}) : Json();
    json["depthRelative"] = sampledAlike ? Json(e.depthRelative) : Json();
    json["unrounded"] = figuresJson(e.unrounded, kSteps);
    json["linear"] = figuresJson(e.linear, 1);
    json["rounding"] = Json();
    if (rounding)
        json["rounding"] = {{"max", rounding->max / kSteps}, {"maxAt", {rounding->x, rounding->y}}, {"mean", rounding->mean / kSteps},
                            {"rms", rounding->rms / kSteps}, {"p99", rounding->p99 / kSteps},       {"linearMax", rounding->linearMax},
                            {"pixels", rounding->pixels}};
    return json;
}

std::string errorLine(const FrameError& e, const Truth& truth, const std::optional<Rounding>& rounding) {
    return fmt::format(
        "error in steps of 1/255 over {} pixels: max {:.3f} at ({}, {}), p99 {:.3f}, rms {:.3f}; wrong primitive in {} "
        "({:.3f} %){}; truth in {:.0f} ms, {} {}",
        e.pixels, e.picture.max, e.picture.x, e.picture.y, e.picture.p99, e.picture.rms, e.wrongPrimitive, 100 * e.wrongShare(),
        rounding ? fmt::format("; float32 by itself: max {:.2g}, rms {:.2g}", rounding->max, rounding->rms) : "", truth.timeMs,
        truth.redone, truth.traced ? "samples followed again in more bits" : "decisions redone exactly");
}

Json certificateJson(const Certificate& c) {
    return {{"pixels", c.pixels},
            {"halfStep", c.halfStep},
            {"halfStepShare", c.shareOf(c.halfStep)},
            {"oneStep", c.oneStep},
            {"oneStepShare", c.shareOf(c.oneStep)},
            {"open", c.open},
            {"max", c.max / kSteps},
            {"maxAt", {c.x, c.y}}};
}

std::string certificateLine(const Certificate& c) {
    return fmt::format("certified to half a step: {:.3f} % of {} pixels, to a step: {:.3f} %; open: {}", 100 * c.shareOf(c.halfStep),
                       c.pixels, 100 * c.shareOf(c.oneStep), c.open);
}

}  // namespace plumb
