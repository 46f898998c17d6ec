// SPDX-License-Identifier: MIT
// LDR-FLIP: Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem, Fairchild: "FLIP: A Difference Evaluator for Alternating Images",
// 2020. Section numbers are the paper's. Everything runs in bands of rows with a margin as wide as the filters, so that memory does not
// grow with the picture.
#include "pipeline/compare/metrics.h"
#include "pipeline/passes/parallel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace plumb {
namespace {

constexpr double kPi = std::numbers::pi;

using Triple = std::array<double, 3>;

// Matrix from linear sRGB to XYZ as the paper has it, and its inverse; the white is the image of (1, 1, 1).
constexpr double kXyzFromRgb[3][3] = {{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                                      {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                                      {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};

struct Inverse {
    double m[3][3];
    constexpr Inverse() : m{} {
        const auto& a = kXyzFromRgb;
        const auto minor = [&](int r, int c) {
            return a[(r + 1) % 3][(c + 1) % 3] * a[(r + 2) % 3][(c + 2) % 3] - a[(r + 1) % 3][(c + 2) % 3] * a[(r + 2) % 3][(c + 1) % 3];
        };
        const double determinant = a[0][0] * minor(0, 0) + a[0][1] * minor(0, 1) + a[0][2] * minor(0, 2);
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) m[r][c] = minor(c, r) / determinant;
    }
};
constexpr Inverse kRgbFromXyz;

Triple times(const double (&m)[3][3], const Triple& v) {
    Triple out{};
    for (size_t r = 0; r < 3; ++r) out[r] = m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2];
    return out;
}
Triple white() { return times(kXyzFromRgb, {1, 1, 1}); }

// Linearised Lab (Y, Cx, Cz), in which contrast sensitivity is modelled (4.1).
Triple opponentOf(const Triple& rgb) {
    const Triple xyz = times(kXyzFromRgb, rgb), w = white();
    const double x = xyz[0] / w[0], y = xyz[1] / w[1], z = xyz[2] / w[2];
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}
Triple rgbFromOpponent(const Triple& o) {
    const Triple w = white();
    const double y = (o[0] + 16) / 116;
    return times(kRgbFromXyz.m, {(o[1] / 500 + y) * w[0], y * w[1], (y - o[2] / 200) * w[2]});
}

// L*a*b* with the Hunt effect: chroma counts in proportion to lightness (4.2).
Triple huntLab(const Triple& rgb) {
    const Triple xyz = times(kXyzFromRgb, rgb), w = white();
    const auto f = [](double t) {
        constexpr double kDelta = 6.0 / 29;
        return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
    };
    const double x = f(xyz[0] / w[0]), y = f(xyz[1] / w[1]), z = f(xyz[2] / w[2]), l = 116 * y - 16;
    return {l, 0.01 * l * 500 * (x - y), 0.01 * l * 200 * (y - z)};
}
double hyAb(const Triple& p, const Triple& q) { return std::fabs(p[0] - q[0]) + std::hypot(p[1] - q[1], p[2] - q[2]); }

// Exponent, and the part of the range up to which differences are spread over the first 0.95 (4.2).
constexpr double kQc = 0.7, kPc = 0.4, kPt = 0.95;
double redistributed(double difference) {
    static const double kMost = std::pow(hyAb(huntLab({0, 1, 0}), huntLab({0, 0, 1})), kQc);  // green against blue
    const double d = std::pow(difference, kQc), knee = kPc * kMost;
    return d < knee ? kPt / knee * d : kPt + (d - knee) / (kMost - knee) * (1 - kPt);
}

struct Filters {
    int radius = 0;  // radius of the contrast filters, in pixels
    std::vector<double> achromatic, redGreen, blueYellow[2];
    double blueYellowWeight[2] = {};  // the two Gaussians of blue-yellow: a sum of two separable filters
    int featureRadius = 0;
    std::vector<double> smooth, edge, point;  // a Gaussian and its normalised derivatives (4.3)
};

std::vector<double> gaussian(int radius, double falloff) {  // exp(-falloff x^2), sum 1
    std::vector<double> weights;
    double sum = 0;
    for (int x = -radius; x <= radius; ++x) sum += weights.emplace_back(std::exp(-falloff * x * x));
    for (double& w : weights) w /= sum;
    return weights;
}
double sumOf(int radius, double falloff) {
    double sum = 0;
    for (int x = -radius; x <= radius; ++x) sum += std::exp(-falloff * x * x);
    return sum;
}
// Normalises weights so that the positive and the negative ones each sum to 1.
void normaliseSigns(std::vector<double>& weights) {
    double positive = 0, negative = 0;
    for (const double w : weights) (w > 0 ? positive : negative) += std::fabs(w);
    for (double& w : weights) w /= w > 0 ? positive : negative;
}

Filters filtersFor(double pixelsPerDegree) {
    // Contrast filters (4.1, table 1): E(x) = a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees; the blue-yellow one is a sum of two.
    constexpr double kAchromatic = 0.0047, kRedGreen = 0.0053, kBlueYellow[2] = {0.04, 0.025}, kAmount[2] = {34.1, 13.5};
    Filters f;
    f.radius = int(std::ceil(3 * std::sqrt(kBlueYellow[0] / (2 * kPi * kPi)) * pixelsPerDegree));
    const auto falloff = [&](double b) { return kPi * kPi / b / (pixelsPerDegree * pixelsPerDegree); };
    f.achromatic = gaussian(f.radius, falloff(kAchromatic));
    f.redGreen = gaussian(f.radius, falloff(kRedGreen));
    double total = 0;
    for (size_t k = 0; k < 2; ++k) {
        const double s = sumOf(f.radius, falloff(kBlueYellow[k]));
        f.blueYellow[k] = gaussian(f.radius, falloff(kBlueYellow[k]));
        total += f.blueYellowWeight[k] = kAmount[k] * std::sqrt(kPi / kBlueYellow[k]) * s * s;
    }
    for (double& w : f.blueYellowWeight) w /= total;

    constexpr double kFeatureDegrees = 0.082;
    const double sigma = 0.5 * kFeatureDegrees * pixelsPerDegree;
    f.featureRadius = int(std::ceil(3 * sigma));
    f.smooth = gaussian(f.featureRadius, 1 / (2 * sigma * sigma));
    for (int x = -f.featureRadius; x <= f.featureRadius; ++x) {
        const double g = std::exp(-x * x / (2 * sigma * sigma));
        f.edge.push_back(-x * g);
        f.point.push_back((x * x / (sigma * sigma) - 1) * g);
    }
    normaliseSigns(f.edge);
    normaliseSigns(f.point);
    return f;
}

// One channel of a band with a margin on all sides; the picture's border is repeated outwards.
struct Patch {
    size_t width = 0, height = 0;
    std::vector<double> values;
};

// Filters along rows with `across`, then down columns with `down`; the result has the band's size.
std::vector<double> filtered(const Patch& patch, size_t margin, const std::vector<double>& across, const std::vector<double>& down) {
    const size_t reach = across.size() / 2, bandWidth = patch.width - 2 * margin, bandHeight = patch.height - 2 * margin;
    std::vector<double> rows(patch.height * bandWidth);
    for (size_t y = margin - reach; y < patch.height - margin + reach; ++y) {
        double* to = rows.data() + y * bandWidth;
        for (size_t k = 0; k < across.size(); ++k) {
            const double w = across[k];
            const double* from = patch.values.data() + y * patch.width + margin - reach + k;
            for (size_t x = 0; x < bandWidth; ++x) to[x] += w * from[x];
        }
    }
    std::vector<double> out(bandWidth * bandHeight);
    for (size_t y = 0; y < bandHeight; ++y)
        for (size_t k = 0; k < down.size(); ++k) {
            const double w = down[k];
            const double* from = rows.data() + (y + margin - reach + k) * bandWidth;
            for (size_t x = 0; x < bandWidth; ++x) out[y * bandWidth + x] += w * from[x];
        }
    return out;
}

struct Band {
    std::vector<Triple> colour;       // filtered, clamped, as Hunt-adjusted Lab
    std::vector<double> edge, point;  // strength of features
};

Band bandOf(const Seen& picture, const Filters& filters, uint32_t firstRow, uint32_t rows) {
    const auto margin = size_t(std::max(filters.radius, filters.featureRadius));
    std::array<Patch, 3> opponent;
    Patch lightness;
    for (Patch* patch : {opponent.data(), opponent.data() + 1, opponent.data() + 2, &lightness}) {
        patch->width = picture.width + 2 * margin;
        patch->height = rows + 2 * margin;
        patch->values.resize(patch->width * patch->height);
    }
    for (size_t j = 0; j < lightness.height; ++j) {
        const int64_t y = std::clamp<int64_t>(int64_t(firstRow) + int64_t(j) - int64_t(margin), 0, picture.height - 1);
        for (size_t i = 0; i < lightness.width; ++i) {
            const int64_t x = std::clamp<int64_t>(int64_t(i) - int64_t(margin), 0, picture.width - 1);
            const size_t from = size_t(y) * picture.width + size_t(x), to = j * lightness.width + i;
            const Triple o = opponentOf({picture.red[from], picture.green[from], picture.blue[from]});
            for (size_t c = 0; c < 3; ++c) opponent[c].values[to] = o[c];
            lightness.values[to] = (o[0] + 16) / 116;
        }
    }
    const std::vector<double> y = filtered(opponent[0], margin, filters.achromatic, filters.achromatic);
    const std::vector<double> cx = filtered(opponent[1], margin, filters.redGreen, filters.redGreen);
    const std::vector<double> wide = filtered(opponent[2], margin, filters.blueYellow[0], filters.blueYellow[0]);
    const std::vector<double> narrow = filtered(opponent[2], margin, filters.blueYellow[1], filters.blueYellow[1]);
    Band band;
    band.colour.reserve(y.size());
    for (size_t i = 0; i < y.size(); ++i) {
        const double cz = filters.blueYellowWeight[0] * wide[i] + filters.blueYellowWeight[1] * narrow[i];
        Triple rgb = rgbFromOpponent({y[i], cx[i], cz});
        for (double& v : rgb) v = std::clamp(v, 0.0, 1.0);
        band.colour.push_back(huntLab(rgb));
    }
    const auto strength = [&](const std::vector<double>& derivative) {
        std::vector<double> along = filtered(lightness, margin, derivative, filters.smooth);
        const std::vector<double> down = filtered(lightness, margin, filters.smooth, derivative);
        for (size_t i = 0; i < along.size(); ++i) along[i] = std::hypot(along[i], down[i]);
        return along;
    };
    band.edge = strength(filters.edge);
    band.point = strength(filters.point);
    return band;
}

constexpr double kQf = 0.5;  // 4.3

}  // namespace

Perceived flipOf(const Seen& a, const Seen& b, const CompareOptions& options, std::vector<float>& map) {
    const Filters filters = filtersFor(options.pixelsPerDegree > 0 ? options.pixelsPerDegree : kDefaultPixelsPerDegree);
    const auto margin = uint32_t(std::max(filters.radius, filters.featureRadius));
    map.assign(size_t(a.width) * a.height, 0);
    std::vector<Perceived> ofRow(a.height);
    // Bands of twice the margin: each row is filtered twice at most, and a thread holds two bands.
    parallelBands(a.height, 2 * margin, threadCount(options.threads), [&](uint64_t begin, uint64_t end) {
        for (auto first = uint32_t(begin); first < end; first += 2 * margin) {
            if (options.onStep) options.onStep();
            const uint32_t rows = std::min(2 * margin, uint32_t(end) - first);
            const Band bandA = bandOf(a, filters, first, rows), bandB = bandOf(b, filters, first, rows);
            for (size_t i = 0; i < bandA.colour.size(); ++i) {
                const uint32_t x = uint32_t(i % a.width), y = first + uint32_t(i / a.width);
                const double colour = redistributed(hyAb(bandA.colour[i], bandB.colour[i]));
                const double features = std::max(std::fabs(bandA.edge[i] - bandB.edge[i]), std::fabs(bandA.point[i] - bandB.point[i]));
                const double feature = std::clamp(std::pow(features / std::numbers::sqrt2, kQf), 0.0, 1.0);
                const double error = std::pow(colour, 1 - feature);  // 4.4
                map[size_t(y) * a.width + x] = float(error);
                Perceived& row = ofRow[y];
                row.mean += error;
                if (error > row.worst) row.worst = error, row.at = {x, y};
            }
        }
    });
    Perceived all;
    for (const Perceived& row : ofRow) {
        all.mean += row.mean;
        if (row.worst > all.worst) all.worst = row.worst, all.at = row.at;
    }
    all.mean /= double(a.width) * a.height;
    return all;
}

}  // namespace plumb
