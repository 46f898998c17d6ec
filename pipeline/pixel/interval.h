// SPDX-License-Identifier: MIT
// Interval: the real result of a formula lies in it. Each operation widens by one binary64 number at most, and only where it rounds, so
// that whole numbers stay exact. `plumb pixel` evaluates the notes' formulas in it for the column of the truth.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumb {

struct Interval {
    double low = 0, high = 0;

    Interval() = default;
    Interval(double value) : low(value), high(value) {}  // NOLINT(google-explicit-constructor): a double is an interval
    Interval(double least, double most) : low(least), high(most) {}

    double middle() const { return low + (high - low) / 2; }
    // Distance of the farther end from middle(), rounded up.
    double bound() const {
        return low == high ? 0 : std::nextafter(std::max(high - middle(), middle() - low), std::numeric_limits<double>::infinity());
    }
    bool hasZero() const { return low <= 0 && high >= 0; }
};

namespace interval {

inline double below(double x) { return std::nextafter(x, -std::numeric_limits<double>::infinity()); }
inline double above(double x) { return std::nextafter(x, std::numeric_limits<double>::infinity()); }
// Result `rounded` whose error has the sign of `rest` = exact - rounded. Near the smallest numbers the rest itself rounds.
inline double lower(double rounded, double rest) { return rest < 0 || std::abs(rounded) < 0x1p-960 ? below(rounded) : rounded; }
inline double upper(double rounded, double rest) { return rest > 0 || std::abs(rounded) < 0x1p-960 ? above(rounded) : rounded; }
// Error of a + b (Knuth) and of a b (fused).
inline double restOfSum(double a, double b, double sum) {
    const double part = sum - a;
    return (a - (sum - part)) + (b - part);
}
inline double restOfProduct(double a, double b, double product) { return std::fma(a, b, -product); }

struct Product {
    double low, high;
};
inline Product product(double a, double b) {
    if (a == 0 || b == 0) return {0, 0};
    const double p = a * b, rest = restOfProduct(a, b, p);
    return {lower(p, rest), upper(p, rest)};
}
inline Product quotient(double a, double b) {
    if (a == 0) return {0, 0};
    const double q = a / b, rest = std::fma(-q, b, a) / b;
    return {lower(q, rest), upper(q, rest)};
}

}  // namespace interval

inline Interval operator-(const Interval& a) { return {-a.high, -a.low}; }
inline Interval operator+(const Interval& a, const Interval& b) {
    using namespace interval;
    const double low = a.low + b.low, high = a.high + b.high;
    const double restLow = restOfSum(a.low, b.low, low), restHigh = restOfSum(a.high, b.high, high);
    return {restLow < 0 ? below(low) : low, restHigh > 0 ? above(high) : high};
}
inline Interval operator-(const Interval& a, const Interval& b) { return a + (-b); }
inline Interval operator*(const Interval& a, const Interval& b) {
    using namespace interval;
    const Product p[] = {product(a.low, b.low), product(a.low, b.high), product(a.high, b.low), product(a.high, b.high)};
    return {std::min({p[0].low, p[1].low, p[2].low, p[3].low}), std::max({p[0].high, p[1].high, p[2].high, p[3].high})};
}
inline Interval operator/(const Interval& a, const Interval& b) {
    using namespace interval;
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    if (b.hasZero()) return {-kInfinite, kInfinite};
    const Product q[] = {quotient(a.low, b.low), quotient(a.low, b.high), quotient(a.high, b.low), quotient(a.high, b.high)};
    return {std::min({q[0].low, q[1].low, q[2].low, q[3].low}), std::max({q[0].high, q[1].high, q[2].high, q[3].high})};
}

// Functions that the notes' formulas use, in float32 and as intervals.
inline float rootOf(float x) { return std::sqrt(x); }
inline Interval rootOf(const Interval& x) {
    using namespace interval;
    const double low = std::sqrt(std::max(x.low, 0.0)), high = std::sqrt(std::max(x.high, 0.0));
    return {std::max(0.0, lower(low, std::fma(-low, low, std::max(x.low, 0.0)))),
            upper(high, std::fma(-high, high, std::max(x.high, 0.0)))};
}
inline float atLeast0(float x) { return std::max(x, 0.0f); }
inline Interval atLeast0(const Interval& x) { return {std::max(x.low, 0.0), std::max(x.high, 0.0)}; }
// x^n for x >= 0. The library's power is within 1 ULP (glibc), so two binary64 numbers on either side hold the real one.
inline float powerOf(float x, double n) { return std::pow(x, float(n)); }
inline Interval powerOf(const Interval& x, double n) {
    using namespace interval;
    if (n == 0) return 1.0;
    if (n == 1) return x;
    const double low = std::pow(x.low, n), high = std::pow(x.high, n);
    return {std::max(0.0, below(below(low))), high == 0 && x.high == 0 ? 0.0 : above(above(high))};
}
// 1 where x > 0, 0 where x <= 0, and between where the interval does not decide.
inline float isPositive(float x) { return x > 0 ? 1.0f : 0.0f; }
inline Interval isPositive(const Interval& x) { return {x.low > 0 ? 1.0 : 0.0, x.high > 0 ? 1.0 : 0.0}; }
inline float nearestWhole(float x) { return std::nearbyint(x); }
inline Interval nearestWhole(const Interval& x) { return {std::nearbyint(x.low), std::nearbyint(x.high)}; }
// Code 0 to 255 of a linear value, not rounded: IEC 61966-2-1, or 255 times the value.
inline double codeOf(double linear, bool srgb) {
    const double x = std::clamp(linear, 0.0, 1.0);
    if (!srgb) return 255 * x;
    return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
}
inline float codeOf(float linear, bool srgb) {
    const float x = std::clamp(linear, 0.0f, 1.0f);
    if (!srgb) return 255 * x;
    return 255 * (x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f);
}
// Eight roundings of at most 2^-52 of 269 lie between the power and the code; 2^-40 covers them and the rounded exponent.
inline Interval codeOf(const Interval& linear, bool srgb) {
    const double low = codeOf(linear.low, srgb), high = codeOf(linear.high, srgb);
    return {std::max(0.0, low - 0x1p-40), std::min(255.0, high + 0x1p-40)};
}

inline double valueOf(float x) { return double(x); }
inline double valueOf(const Interval& x) { return x.middle(); }
inline double boundOf(float) { return 0; }
inline double boundOf(const Interval& x) { return x.bound(); }

}  // namespace plumb
