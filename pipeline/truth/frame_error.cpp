// SPDX-License-Identifier: MIT
#include "pipeline/truth/frame_error.h"

#include "host/error.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace plumb {

namespace {

// Collects one value a pixel (the largest of its channels), and sum and squares of all channels.
class Collector {
public:
    explicit Collector(uint32_t width) : width_(width) {}
    void add(size_t pixel, std::initializer_list<double> channels) {
        const double worst = std::max(channels);
        if (values_.empty() || worst > figures_.max) {
            figures_.max = worst;
            figures_.x = uint32_t(pixel % width_);
            figures_.y = uint32_t(pixel / width_);
        }
        values_.push_back(worst);
        for (const double c : channels) sum_ += c, squares_ += c * c, ++count_;
    }
    ErrorFigures figures() {
        if (values_.empty()) return {};
        figures_.mean = sum_ / double(count_);
        figures_.rms = std::sqrt(squares_ / double(count_));
        // Percentile: the least value that at least 99 % of the pixels do not exceed.
        const size_t rank = (values_.size() * 99 + 99) / 100 - 1;
        std::nth_element(values_.begin(), values_.begin() + ptrdiff_t(rank), values_.end());
        figures_.p99 = values_[rank];
        return figures_;
    }

private:
    const uint32_t width_;
    ErrorFigures figures_;
    std::vector<double> values_;
    double sum_ = 0, squares_ = 0;
    uint64_t count_ = 0;
};

// Code in sRGB of a stored byte.
double codeOfByte(uint32_t byte, Encoding encoding) { return encoding == Encoding::srgb ? double(byte) : srgbCode(byte / 255.0); }

}  // namespace

bool showsSomething(const Frame& frame, const Truth& truth, size_t at, bool transparent) {
    return frame.object[at] != kNone || truth.alpha[at] > 0 || truth.object[at] != kNone || (transparent && frame.rgba[at] >> 24 != 0);
}

FrameError errorOf(const Frame& frame, const Truth& truth, Encoding encoding, bool transparent, const PixelChoice& choice) {
    const size_t pixels = size_t(truth.width) * truth.height;
    PLUMB_ASSERT(frame.width == truth.width && frame.height == truth.height && frame.rgba.size() == pixels &&
                 frame.linear.size() == 3 * pixels && frame.depth.size() == pixels && frame.object.size() == pixels &&
                 frame.primitive.size() == pixels);
    for (size_t at = 0; at < pixels; ++at)
        for (size_t c = 0; c < 4; ++c) {
            const float v = c == 3 ? frame.depth[at] : frame.linear[3 * at + c];
            const bool nothing = c == 3 && frame.object[at] == kNone;
            if (!std::isfinite(v) && !nothing)
                throw renderError(fmt::format("{} at pixel ({}, {}) is {}: no error is measured", c == 3 ? "depth" : "linear",
                                              at % frame.width, at / frame.width, v));
        }
    FrameError error;
    Collector picture(truth.width), unrounded(truth.width), linear(truth.width);
    error.perPixel.assign(pixels, 0.0f);
    error.unroundedPerPixel.assign(pixels, 0.0f);
    for (size_t at = 0; at < pixels; ++at) {
        const uint32_t word = frame.rgba[at];
        const bool faceless = truth.object[at] != kNone && truth.primitive[at] == kNone;  // the object alone counts
        const bool sameFace = frame.object[at] == truth.object[at] && (faceless || frame.primitive[at] == truth.primitive[at]);
        if (!choice.wanted.empty() && choice.wanted[at] == 0) continue;
        if (!showsSomething(frame, truth, at, transparent)) continue;
        ++error.pixels;
        if (!sameFace && error.wrongPrimitive++ == 0) error.wrongX = uint32_t(at % truth.width), error.wrongY = uint32_t(at / truth.width);
        if (sameFace && truth.object[at] != kNone)
            error.depthRelative = std::max(error.depthRelative, std::abs(double(frame.depth[at]) - truth.depth[at]) / truth.depth[at]);
        double bytes[4], codes[3], light[3];
        for (size_t c = 0; c < 3; ++c) {
            const double exact = truth.linear[3 * at + c], code = srgbCode(exact), value = frame.linear[3 * at + c];
            bytes[c] = std::abs(codeOfByte(word >> (8 * c) & 0xff, encoding) - code);
            codes[c] = std::abs(srgbCode(value) - code);
            light[c] = std::abs(value - exact);
        }
        bytes[3] = transparent ? std::abs(double(word >> 24) - 255 * truth.alpha[at]) : 0;
        if (transparent)
            picture.add(at, {bytes[0], bytes[1], bytes[2], bytes[3]});
        else
            picture.add(at, {bytes[0], bytes[1], bytes[2]});
        const double worst = std::max({bytes[0], bytes[1], bytes[2], bytes[3]});
        error.perPixel[at] = float(worst / 255);
        if (!choice.decided.empty() && choice.decided[at] == 0)
            ++error.undecided;
        else if (worst > error.decidedMax)
            error.decidedMax = worst, error.decidedX = uint32_t(at % truth.width), error.decidedY = uint32_t(at / truth.width);
        error.unroundedPerPixel[at] = float(std::max({codes[0], codes[1], codes[2]}));
        unrounded.add(at, {codes[0], codes[1], codes[2]});
        linear.add(at, {light[0], light[1], light[2]});
    }
    error.picture = picture.figures();
    error.unrounded = unrounded.figures();
    error.linear = linear.figures();
    return error;
}

}  // namespace plumb
