// SPDX-License-Identifier: MIT
// Norms of the differences: how much, and where.
#include "pipeline/compare/metrics.h"
#include "pipeline/passes/parallel.h"

#include <half.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace plumb {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Difference of two samples, in codes or in units of the layer; two equal infinities do not differ.
double apart(double a, double b) { return a == b ? 0 : std::fabs(a - b); }

// Pixels of two layers; (x, y) of one against any of the other.
struct Pixels {
    const Layer& a;
    const Layer& b;
    uint32_t width, height, channels = a.channels;

    double largest(const double* p, const double* q) const {
        double most = 0;
        for (uint32_t c = 0; c < channels; ++c) {
            const double d = apart(p[c], q[c]);
            if (std::isnan(d)) return d;
            most = std::max(most, d);
        }
        return most;
    }
    // Pixel of `other` within `radius` of (x, y) that is nearest to p; on a tie the one at (x, y) itself, then the first.
    const double* nearest(const double* p, const Layer& other, uint32_t x, uint32_t y, uint32_t radius) const {
        const auto at = [&](uint32_t u, uint32_t v) { return other.samples.data() + (size_t(v) * width + u) * channels; };
        const double* best = at(x, y);
        double least = largest(p, best);
        if (std::isnan(least)) least = kInfinity;
        const uint32_t u0 = x - std::min(x, radius), u1 = std::min(width - 1, x + radius), v0 = y - std::min(y, radius),
                       v1 = std::min(height - 1, y + radius);
        for (uint32_t v = v0; v <= v1 && least > 0; ++v)
            for (uint32_t u = u0; u <= u1; ++u) {
                const double d = largest(p, at(u, v));
                if (d < least) least = d, best = at(u, v);
            }
        return best;
    }
};

void note(NotANumber& found, const double* p, uint32_t channels, Pixel pixel) {
    if (!std::any_of(p, p + channels, [](double s) { return std::isnan(s); })) return;
    if (found.pixels++ == 0) found.first = pixel;
}

template <class Float, class Bits>
double steps(double a, double b) {
    const auto ordered = [](double value) {  // integers in the order of the numbers, both zeros at 0
        const Bits bits = std::bit_cast<Bits>(Float(value));
        const Bits sign = Bits(1) << (sizeof(Bits) * 8 - 1);
        const auto magnitude = int64_t(bits & Bits(sign - 1));
        return (bits & sign) != 0 ? -magnitude : magnitude;
    };
    // Distance of up to 2^64, as a double that is rounded only beyond 2^53.
    return std::fabs(double(ordered(a)) - double(ordered(b))) < 0x1p53 ? double(std::abs(ordered(a) - ordered(b)))
                                                                       : std::fabs(double(ordered(a)) - double(ordered(b)));
}

double halfSteps(double a, double b) {
    const auto ordered = [](double value) {
        const int bits = Imath::half(float(value)).bits();
        return (bits & 0x8000) != 0 ? -(bits & 0x7fff) : bits;
    };
    return std::abs(ordered(a) - ordered(b));
}

}  // namespace

double ulpDistance(double a, double b, int bits) {
    return bits == 16 ? halfSteps(a, b) : bits == 32 ? steps<float, uint32_t>(a, b) : steps<double, uint64_t>(a, b);
}

void takeUlp(const Layer& a, const Layer& b, uint32_t width, LayerDifference& out) {
    out.ulpPrecision = std::max(a.precision, b.precision);
    double most = 0;
    for (size_t i = 0; i < a.samples.size(); ++i) {
        if (a.samples[i] == b.samples[i] || std::isnan(a.samples[i]) || std::isnan(b.samples[i])) continue;
        const double d = ulpDistance(a.samples[i], b.samples[i], out.ulpPrecision);
        if (d <= most) continue;
        most = d;
        const size_t pixel = i / a.channels;
        out.ulpAt = {uint32_t(pixel % width), uint32_t(pixel / width)};
    }
    out.ulp = most;
}

Region largestRegion(const std::vector<uint8_t>& differs, uint32_t width, uint32_t height) {
    Region best;
    std::vector<uint8_t> left = differs;
    std::vector<uint32_t> stack;
    for (size_t start = 0; start < left.size(); ++start) {
        if (left[start] == 0) continue;
        Region region{0, {width, height}, {0, 0}};
        left[start] = 0;
        stack.push_back(uint32_t(start));
        while (!stack.empty()) {
            const uint32_t at = stack.back(), x = at % width, y = at / width;
            stack.pop_back();
            ++region.pixels;
            region.least = {std::min(region.least.x, x), std::min(region.least.y, y)};
            region.most = {std::max(region.most.x, x), std::max(region.most.y, y)};
            for (uint32_t v = y - (y > 0); v <= std::min(height - 1, y + 1); ++v)
                for (uint32_t u = x - (x > 0); u <= std::min(width - 1, x + 1); ++u) {
                    const size_t next = size_t(v) * width + u;
                    if (left[next] == 0) continue;
                    left[next] = 0;
                    stack.push_back(uint32_t(next));
                }
        }
        if (region.pixels > best.pixels) best = region;
    }
    return best;
}

void takeNorms(const Layer& a, const Layer& b, uint32_t width, uint32_t height, const CompareOptions& options, LayerDifference& out) {
    const Pixels pixels{a, b, width, height};
    const uint32_t channels = a.channels;
    const size_t count = size_t(width) * height;
    const double scale = a.fullScale;
    const bool ids = a.kind == LayerKind::id;
    out.pixels = count;
    out.error.assign(count, 0);
    // Partner of each pixel on the other side, both ways: a thin line that one side lacks must match nothing.
    std::vector<std::array<const double*, 2>> partner(count);
    parallelBands(height, 8, threadCount(options.threads), [&](uint64_t begin, uint64_t end) {
        if (options.onStep) options.onStep();
        for (auto y = uint32_t(begin); y < end; ++y)
            for (uint32_t x = 0; x < width; ++x) {
                const size_t i = size_t(y) * width + x;
                const double *p = a.samples.data() + i * channels, *q = b.samples.data() + i * channels;
                partner[i] = {p, q};
                const double here = pixels.largest(p, q);
                if (here == 0 || std::isnan(here)) {
                    out.error[i] = here;
                    continue;
                }
                if (options.radius == 0) {
                    out.error[i] = here / scale;
                    continue;
                }
                const double* inB = pixels.nearest(p, b, x, y, options.radius);
                const double* inA = pixels.nearest(q, a, x, y, options.radius);
                const double forth = pixels.largest(p, inB), back = pixels.largest(q, inA);
                partner[i] = forth >= back ? std::array{p, inB} : std::array{inA, q};
                out.error[i] = std::max(forth, back) / scale;
            }
    });
    std::vector<uint8_t> differs(count);
    // Sums are taken in a fixed order, so that threads change no bit; rows first, so that they stay accurate.
    double sum = 0, squares = 0, most = -1;
    for (uint32_t y = 0; y < height; ++y) {
        double rowSum = 0, rowSquares = 0;
        for (uint32_t x = 0; x < width; ++x) {
            const size_t i = size_t(y) * width + x;
            const Pixel pixel{x, y};
            note(out.nanA, a.samples.data() + i * channels, channels, pixel);
            note(out.nanB, b.samples.data() + i * channels, channels, pixel);
            const double error = out.error[i];
            if (std::isnan(error)) {
                const bool both =
                    std::equal(a.samples.data() + i * channels, a.samples.data() + (i + 1) * channels, b.samples.data() + i * channels,
                               [](double p, double q) { return p == q || (std::isnan(p) && std::isnan(q)); });
                differs[i] = both ? 0 : 1;
            } else {
                ++out.compared;
                differs[i] = error != 0;
                for (size_t k = 0; k < kLevels.size(); ++k) out.over[k] += error > kLevels[k] / 255.0;
                for (uint32_t c = 0; c < channels && error != 0; ++c) {
                    const double d = apart(partner[i][0][c], partner[i][1][c]) / scale;
                    rowSum += d;
                    rowSquares += d * d;
                    if (d <= most) continue;
                    most = d;
                    out.maxAt = pixel;
                    out.maxChannel = c;
                    out.valueA = partner[i][0][c];
                    out.valueB = partner[i][1][c];
                }
            }
            if (differs[i] == 0) continue;
            if (out.differing++ == 0) out.firstDiffering = pixel;
        }
        sum += rowSum;
        squares += rowSquares;
    }
    out.region = largestRegion(differs, width, height);
    if (ids) {
        for (size_t i = 0; i < count; ++i) out.error[i] = differs[i];
        out.over = {};
        return;
    }
    if (out.compared == 0) return;  // all pixels have a NaN: there is no norm
    const double samples = double(out.compared) * channels;
    out.max = std::max(most, 0.0);
    out.mean = sum / samples;
    out.rmse = std::sqrt(squares / samples);
    if (a.colour) out.psnr = squares == 0 ? kInfinity : 10 * std::log10(samples / squares);
}

}  // namespace plumb
