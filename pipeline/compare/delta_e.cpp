// SPDX-License-Identifier: MIT
// CIEDE2000 as in Sharma, Wu, Dalal: "The CIEDE2000 Color-Difference Formula: Implementation Notes, Supplementary Test Data, and Mathematical
// Observations", 2005, whose equations the numbers name.
#include "pipeline/compare/metrics.h"
#include "pipeline/passes/parallel.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

namespace plumb {
namespace {

constexpr double kPi = std::numbers::pi;
double radians(double degrees) { return degrees * kPi / 180; }
double seventh(double c) { return std::sqrt(std::pow(c, 7) / (std::pow(c, 7) + std::pow(25.0, 7))); }
double hueOf(double b, double a) {  // (7), degrees in [0, 360)
    if (a == 0 && b == 0) return 0;
    const double h = std::atan2(b, a) * 180 / kPi;
    return h < 0 ? h + 360 : h;
}

}  // namespace

double ciede2000(const Lab& p, const Lab& q) {
    const double meanC = (std::hypot(p.a, p.b) + std::hypot(q.a, q.b)) / 2;  // (2), (3)
    const double stretch = 1.5 - 0.5 * seventh(meanC);                       // 1 + G of (4)
    const double a1 = stretch * p.a, a2 = stretch * q.a;                     // (5)
    const double c1 = std::hypot(a1, p.b), c2 = std::hypot(a2, q.b);         // (6)
    const double h1 = hueOf(p.b, a1), h2 = hueOf(q.b, a2);
    double dh = h2 - h1;  // (10)
    if (c1 * c2 == 0)
        dh = 0;
    else if (dh > 180)
        dh -= 360;
    else if (dh < -180)
        dh += 360;
    const double dL = q.l - p.l, dC = c2 - c1,
                 dH = 2 * std::sqrt(c1 * c2) * std::sin(radians(dh / 2));  // (8), (9), (11)
    const double meanL = (p.l + q.l) / 2, meanCp = (c1 + c2) / 2;          // (12), (13)
    double meanH = h1 + h2;                                                // (14)
    if (c1 * c2 != 0) {
        if (std::fabs(h1 - h2) > 180) meanH += meanH < 360 ? 360 : -360;
        meanH /= 2;
    }
    const double t = 1 - 0.17 * std::cos(radians(meanH - 30)) + 0.24 * std::cos(radians(2 * meanH)) +
                     0.32 * std::cos(radians(3 * meanH + 6)) - 0.20 * std::cos(radians(4 * meanH - 63));  // (15)
    const double turn = 30 * std::exp(-std::pow((meanH - 275) / 25, 2));                                  // (16)
    const double offset = (meanL - 50) * (meanL - 50);
    const double sL = 1 + 0.015 * offset / std::sqrt(20 + offset), sC = 1 + 0.045 * meanCp,
                 sH = 1 + 0.015 * meanCp * t;                              // (18) to (20)
    const double rT = -std::sin(radians(2 * turn)) * 2 * seventh(meanCp);  // (17), (21)
    const double l = dL / sL, c = dC / sC, h = dH / sH;
    return std::sqrt(l * l + c * c + h * h + rT * c * h);  // (22)
}

Lab labFromLinear(const Rgb& c) {
    // sRGB primaries to XYZ over the white of D65 (IEC 61966-2-1); each row sums to the white, so that white is L = 100, a = b = 0.
    constexpr double kX[3] = {0.4124564, 0.3575761, 0.1804375}, kY[3] = {0.2126729, 0.7151522, 0.0721750},
                     kZ[3] = {0.0193339, 0.1191920, 0.9503041};
    const auto f = [&](const double(&row)[3]) {
        const double t = (row[0] * c.r + row[1] * c.g + row[2] * c.b) / (row[0] + row[1] + row[2]);
        constexpr double kDelta = 6.0 / 29;
        return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
    };
    const double x = f(kX), y = f(kY), z = f(kZ);
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Perceived deltaEOf(const Seen& a, const Seen& b, const CompareOptions& options) {
    std::vector<Perceived> ofRow(a.height);
    parallelBands(a.height, 8, threadCount(options.threads), [&](uint64_t begin, uint64_t end) {
        if (options.onStep) options.onStep();
        for (auto y = uint32_t(begin); y < end; ++y) {
            Perceived& row = ofRow[y];
            for (uint32_t x = 0; x < a.width; ++x) {
                const size_t i = size_t(y) * a.width + x;
                if (a.red[i] == b.red[i] && a.green[i] == b.green[i] && a.blue[i] == b.blue[i]) continue;
                const double d =
                    ciede2000(labFromLinear({a.red[i], a.green[i], a.blue[i]}), labFromLinear({b.red[i], b.green[i], b.blue[i]}));
                row.mean += d;
                if (d > row.worst) row.worst = d, row.at = {x, y};
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
