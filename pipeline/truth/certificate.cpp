// SPDX-License-Identifier: MIT
#include "pipeline/truth/certificate.h"

#include "host/error.h"
#include "pipeline/truth/frame_error.h"
#include "pipeline/truth/shading_error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace plumb {

namespace {

constexpr double kUnit = truth::kDoubleUnit;

// Distance of a stored byte to the code of a linear value that is known within `error`, in steps, rounded up.
double stepsOf(uint32_t byte, Encoding encoding, double linear, double error) {
    double code = double(byte), codeError = 0;
    if (encoding == Encoding::linear) {
        const double light = double(byte) / 255;
        code = srgbCode(light);
        codeError = srgbCodeError(light, kUnit * light);
    }
    // Difference and two sums, a rounding each.
    return (std::abs(code - srgbCode(linear)) + srgbCodeError(linear, error) + codeError) * (1 + 4 * kUnit);
}

float upward(double x) {
    const auto nearest = float(x);
    return double(nearest) < x ? std::nextafter(nearest, std::numeric_limits<float>::infinity()) : nearest;
}

Grade gradeOf(float steps) {
    if (!std::isfinite(steps)) return Grade::open;
    return steps <= 0.5f ? Grade::halfStep : steps <= 1.0f ? Grade::oneStep : Grade::decided;
}

}  // namespace

Certificate certificateOf(const Frame& frame, const Truth& truth, Encoding encoding, bool transparent) {
    const size_t pixels = size_t(truth.width) * truth.height;
    PLUMB_ASSERT(frame.width == truth.width && frame.height == truth.height && frame.rgba.size() == pixels &&
                 frame.object.size() == pixels);
    Certificate out;
    out.steps.resize(pixels);
    out.grades.resize(pixels);
    for (size_t at = 0; at < pixels; ++at) {
        const uint32_t word = frame.rgba[at];
        // Alpha of the truth is a number of samples over a power of two, so it has no error where what is seen is decided.
        double steps = transparent ? std::abs(double(word >> 24) - 255 * truth.alpha[at]) * (1 + 4 * kUnit) : 0;
        bool known = truth.decided[at] != 0;
        for (size_t c = 0; c < 3 && known; ++c) {
            known = std::isfinite(truth.bound[3 * at + c]);
            if (known)
                steps = std::max(steps, stepsOf(word >> (8 * c) & 0xff, encoding, truth.linear[3 * at + c], truth.bound[3 * at + c]));
        }
        out.steps[at] = known ? upward(steps) : std::numeric_limits<float>::infinity();
        const Grade grade = gradeOf(out.steps[at]);
        out.grades[at] = uint32_t(grade);
        if (!showsSomething(frame, truth, at, transparent)) continue;
        ++out.pixels;
        out.open += grade == Grade::open;
        out.oneStep += grade >= Grade::oneStep;
        out.halfStep += grade == Grade::halfStep;
        if (grade == Grade::open || double(out.steps[at]) <= out.max) continue;
        out.max = double(out.steps[at]);
        out.x = uint32_t(at % truth.width);
        out.y = uint32_t(at / truth.width);
    }
    return out;
}

}  // namespace plumb
