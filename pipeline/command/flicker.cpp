// SPDX-License-Identifier: MIT
#include "pipeline/command/flicker.h"

#include "host/error.h"
#include "pipeline/scene/mesh.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

namespace plumb {

void Flicker::add(const Frame& frame) {
    PLUMB_ASSERT(seen_ < count_ && frame.object.size() == frame.rgba.size());
    Kept now{frame.rgba, frame.object, frame.width};
    if (seen_ > 0) compare(last_, seen_ - 1, now, seen_);
    if (seen_ == 0) first_ = now;
    last_ = std::move(now);
    if (++seen_ == count_ && count_ > 2) compare(last_, count_ - 1, first_, 0);  // of two pictures that step is the first one again
}

void Flicker::compare(const Kept& a, uint32_t from, const Kept& b, uint32_t to) {
    FlickerStep step;
    step.from = from;
    step.to = to;
    double squares = 0;
    for (size_t at = 0; at < a.rgba.size(); ++at) {
        if (a.object[at] == kNone || a.object[at] != b.object[at]) continue;
        ++step.pixels;
        int largest = 0;
        for (int shift = 0; shift < 24; shift += 8) {
            const int change = std::abs(int(a.rgba[at] >> shift & 0xff) - int(b.rgba[at] >> shift & 0xff));
            largest = std::max(largest, change);
            squares += double(change) * change;
        }
        if (largest > step.max) {
            step.max = largest;
            step.x = uint32_t(at % a.width);
            step.y = uint32_t(at / a.width);
        }
    }
    step.rms = step.pixels == 0 ? 0 : std::sqrt(squares / (3.0 * double(step.pixels)));
    steps_.push_back(step);
}

FlickerStep Flicker::largest() const {
    FlickerStep largest;
    for (const FlickerStep& step : steps_)
        if (step.max > largest.max || largest.pixels == 0) largest = step;
    return largest;
}

double Flicker::rms() const {
    double squares = 0, pixels = 0;
    for (const FlickerStep& step : steps_) squares += step.rms * step.rms * double(step.pixels), pixels += double(step.pixels);
    return pixels > 0 ? std::sqrt(squares / pixels) : 0;
}

Json Flicker::json() const {
    const FlickerStep worst = largest();
    Json json;
    json["max"] = worst.max / 255;
    json["rms"] = rms() / 255;
    json["at"] = {worst.x, worst.y};
    json["from"] = worst.from;
    json["to"] = worst.to;
    json["steps"] = Json::array();
    for (const FlickerStep& step : steps_)
        json["steps"].push_back({{"from", step.from},
                                 {"to", step.to},
                                 {"pixels", step.pixels},
                                 {"max", step.max / 255},
                                 {"rms", step.rms / 255},
                                 {"at", {step.x, step.y}}});
    return json;
}

std::string Flicker::line() const {
    const FlickerStep worst = largest();
    if (worst.pixels == 0) return "flicker: no pixel shows the same object in two pictures in a row";
    return fmt::format("flicker: a pixel changes by at most {:g} steps of 255, at ({}, {}) from picture {} to {}; rms {:.3f}", worst.max,
                       worst.x, worst.y, worst.from, worst.to, rms());
}

}  // namespace plumb
