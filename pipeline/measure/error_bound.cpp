// SPDX-License-Identifier: MIT
#include "pipeline/measure/error_bound.h"

#include "host/error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

namespace plumb {

namespace {

constexpr double kFullScale = 255;  // steps
// Error of srgbCode() and the sums of steps in binary64: each is off by less than 2^-40 of full scale.
constexpr double kArithmeticError = 0x1p-32;
// Error of FrameError::perPixel, which holds float32.
constexpr double kStoredError = 0x1p-23;

struct PixelBound {
    double most = 0;              // of its channels, as FrameError::perPixel
    double sum = 0, squares = 0;  // of all channels
    bool any = false;             // the channel with the most may have any code
};

PixelBound boundAt(const Frame& base, const Truth& truth, bool transparent, const ColourMoves& moves, double last, size_t at) {
    PixelBound p;
    for (size_t c = 0; c < 3; ++c) {
        const double value = double(base.linear[3 * at + c]), exact = srgbCode(truth.linear[3 * at + c]);
        const double low = std::max(0.0, srgbCode(value - moves.darker(at, c)) - last),
                     high = std::min(kFullScale, srgbCode(value + moves.brighter(at, c)) + last);
        const double off = std::max({high - exact, exact - low, 0.0}) + kArithmeticError;
        if (off > p.most) {
            p.most = off;
            p.any = low <= 0 && high >= kFullScale;
        }
        p.sum += off;
        p.squares += off * off;
    }
    if (transparent) {
        const double alpha = std::abs(double(base.rgba[at] >> 24) - kFullScale * truth.alpha[at]);
        if (alpha > p.most) p.most = alpha, p.any = false;
        p.sum += alpha;
        p.squares += alpha * alpha;
    }
    return p;
}

}  // namespace

std::string ErrorBound::why() const {
    std::string names;
    for (const auto& [name, value] : {std::pair("max", max), std::pair("mean", mean), std::pair("rms", rms), std::pair("p99", p99),
                                      std::pair("choice.brighter", brighter), std::pair("choice.darker", darker)})
        if (value == kNoBound) names += (names.empty() ? "" : ", ") + std::string(name);
    return names.empty() ? "" : (empty() ? "" : names + ": ") + "no bound below full scale";
}

ErrorBound errorBoundOf(const Frame& base, const Truth& truth, bool transparent, const ColourMoves& moves, double steps) {
    const size_t pixels = size_t(truth.width) * truth.height;
    PLUMB_ASSERT(base.linear.size() == 3 * pixels && base.rgba.size() == pixels && base.object.size() == pixels);
    ErrorBound bound;
    bound.steps = steps;
    bound.perPixel.assign(pixels, 0.0);
    std::vector<std::pair<double, bool>> values;  // largest error of a pixel; true: it may have any code
    double squares = 0;
    bool anywhere = true;  // every pixel may have any code
    for (size_t at = 0; at < pixels; ++at) {
        if (!showsSomething(base, truth, at, transparent)) continue;
        const PixelBound p = boundAt(base, truth, transparent, moves, 0.5 + steps, at);
        for (size_t c = 0; c < 3; ++c) {
            bound.brighter = std::max(bound.brighter, moves.brighter(at, c));
            bound.darker = std::max(bound.darker, moves.darker(at, c));
        }
        bound.perPixel[at] = p.most;
        bound.mean += p.sum;
        squares += p.squares;
        anywhere &= p.any;
        values.emplace_back(p.most, p.any);
    }
    for (double* move : {&bound.brighter, &bound.darker})
        if (*move >= 1) *move = ErrorBound::kNoBound;
    if (values.empty()) return bound;
    const auto figure = [](const std::pair<double, bool>& v) { return v.second ? ErrorBound::kNoBound : v.first; };
    bound.max = figure(*std::max_element(values.begin(), values.end()));
    const size_t rank = (values.size() * 99 + 99) / 100 - 1;
    std::nth_element(values.begin(), values.begin() + ptrdiff_t(rank), values.end());
    bound.p99 = figure(values[rank]);
    const auto channels = double(values.size() * (transparent ? 4 : 3));
    bound.mean = anywhere ? ErrorBound::kNoBound : bound.mean / channels;
    bound.rms = anywhere ? ErrorBound::kNoBound : std::sqrt(squares / channels);
    return bound;
}

std::optional<BoundBreach> breachOf(const FrameError& error, const ErrorBound& bound, uint32_t width) {
    PLUMB_ASSERT(error.perPixel.size() == bound.perPixel.size());
    // `!(a <= b)` is true for what is not a number.
    std::optional<BoundBreach> worst;
    for (size_t at = 0; at < error.perPixel.size(); ++at) {
        const double off = kFullScale * double(error.perPixel[at]), most = bound.perPixel[at] * (1 + kStoredError) + kFullScale * 0x1p-149;
        if (off <= most) continue;
        const bool number = !std::isnan(off) && !std::isnan(most);
        if (!worst || !number || off - most > worst->error - worst->bound)
            worst = BoundBreach{"max", uint32_t(at % width), uint32_t(at / width), off, bound.perPixel[at]};
        if (!number) return worst;
    }
    const ErrorFigures& e = error.picture;
    const std::tuple<const char*, double, double> figures[] = {
        {"max", e.max, bound.max}, {"p99", e.p99, bound.p99}, {"mean", e.mean, bound.mean}, {"rms", e.rms, bound.rms}};
    for (const auto& [name, off, most] : figures)
        if ((std::isnan(off) || std::isnan(most)) || (!worst && !(off <= most))) return BoundBreach{name, e.x, e.y, off, most};
    return worst;
}

std::optional<BoundBreach> breachOfMoves(const Frame& base, const Frame& frame, const ColourMoves& moves) {
    PLUMB_ASSERT(base.linear.size() == frame.linear.size());
    std::optional<BoundBreach> worst;
    for (size_t i = 0; i < base.linear.size(); ++i) {
        const double off = double(frame.linear[i]) - double(base.linear[i]),
                     most = off < 0 ? moves.darker(i / 3, i % 3) : moves.brighter(i / 3, i % 3);
        if (std::abs(off) <= most) continue;
        const bool number = !std::isnan(off) && !std::isnan(most);
        if (!worst || !number || std::abs(off) - most > worst->error - worst->bound)
            worst =
                BoundBreach{"linear", uint32_t(i / 3 % frame.width), uint32_t(i / 3 / frame.width), std::abs(off), most, "of linear light"};
        if (!number) break;
    }
    return worst;
}

}  // namespace plumb
