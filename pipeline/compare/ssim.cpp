// SPDX-License-Identifier: MIT
#include "pipeline/compare/metrics.h"
#include "pipeline/passes/parallel.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace plumb {
namespace {

constexpr int kWindow = 11, kMiddle = 5;
constexpr double kSigma = 1.5, kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;  // with a dynamic range of 1

std::array<double, kWindow> window() {
    std::array<double, kWindow> weights{};
    double sum = 0;
    for (int i = 0; i < kWindow; ++i) sum += weights[size_t(i)] = std::exp(-0.5 * (i - kMiddle) * (i - kMiddle) / (kSigma * kSigma));
    for (double& w : weights) w /= sum;
    return weights;
}

std::vector<double> lumaOf(const Seen& picture) {
    std::vector<double> luma;
    luma.reserve(picture.red.size());
    for (size_t i = 0; i < picture.red.size(); ++i)
        luma.push_back(0.299 * srgbFromLinear(picture.red[i]) + 0.587 * srgbFromLinear(picture.green[i]) +
                       0.114 * srgbFromLinear(picture.blue[i]));
    return luma;
}

struct Moments {
    double a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    void add(double w, const Moments& m) { a += w * m.a, b += w * m.b, aa += w * m.aa, bb += w * m.bb, ab += w * m.ab; }
};

double similarity(const Moments& m) {
    const double varianceA = m.aa - m.a * m.a, varianceB = m.bb - m.b * m.b, covariance = m.ab - m.a * m.b;
    return (2 * m.a * m.b + kC1) * (2 * covariance + kC2) / ((m.a * m.a + m.b * m.b + kC1) * (varianceA + varianceB + kC2));
}

}  // namespace

std::optional<Perceived> ssimOf(const Seen& a, const Seen& b, const CompareOptions& options) {
    if (a.width < kWindow || a.height < kWindow) return std::nullopt;
    const std::array<double, kWindow> weights = window();
    const std::vector<double> lumaA = lumaOf(a), lumaB = lumaOf(b);
    const uint32_t columns = a.width - kWindow + 1, rows = a.height - kWindow + 1;
    std::vector<Perceived> ofRow(rows);
    parallelBands(rows, 16, threadCount(options.threads), [&](uint64_t begin, uint64_t end) {
        if (options.onStep) options.onStep();
        const size_t first = size_t(begin), bandRows = size_t(end - begin) + kWindow - 1;
        std::vector<Moments> across(bandRows * columns);  // moments along rows, then down columns
        for (size_t y = 0; y < bandRows; ++y)
            for (size_t x = 0; x < columns; ++x)
                for (size_t k = 0; k < kWindow; ++k) {
                    const size_t at = (first + y) * a.width + x + k;
                    const double p = lumaA[at], q = lumaB[at];
                    across[y * columns + x].add(weights[k], {p, q, p * p, q * q, p * q});
                }
        for (size_t y = 0; y + kWindow <= bandRows; ++y) {
            Perceived& row = ofRow[first + y];
            row.worst = 2;
            for (size_t x = 0; x < columns; ++x) {
                Moments m;
                for (size_t k = 0; k < kWindow; ++k) m.add(weights[k], across[(y + k) * columns + x]);
                const double s = similarity(m);
                row.mean += s;
                if (s < row.worst) row.worst = s, row.at = {uint32_t(x + kMiddle), uint32_t(first + y + kMiddle)};
            }
        }
    });
    Perceived all{0, 2, {}};
    for (const Perceived& row : ofRow) {
        all.mean += row.mean;
        if (row.worst < all.worst) all.worst = row.worst, all.at = row.at;
    }
    all.mean /= double(columns) * rows;
    return all;
}

}  // namespace plumb
