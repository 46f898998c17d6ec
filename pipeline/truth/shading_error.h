// SPDX-License-Identifier: MIT
// Bounds of the truth's own error in a colour: what binary64 makes of directions, powers and sums (docs/derivations.md, The truth's own error).
// Every bound holds for any error of its arguments, not to first order only.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

namespace plumb::truth {

inline constexpr double kDoubleUnit = 0x1p-53;  // u, unit round-off of binary64
// What the computation of a bound itself may lose: fewer than 2^20 roundings of positive terms.
inline constexpr double kOwnRounding = 1.0 + 0x1p-20;
// Error of a vector that was normalised, beside that of its direction: length, quotient and components, 6 u.
inline constexpr double kUnitVectorError = 8 * kDoubleUnit;
// Relative error of std::pow. glibc documents 1 ULP, which is 2 u at most.
inline constexpr double kPowError = 4 * kDoubleUnit;
// Absolute error of a colour from results that underflow.
inline constexpr double kUnderflow = 0x1p-900;

// Unit vector, and a bound of its distance to the true one. Both are of length 1, so 2 says nothing.
struct Direction {
    glm::dvec3 v{0};
    double error = 0;
};

// Bound of the distance of two unit vectors, along a vector of length `length` and along one that is within `off` of it.
inline double turnedBy(double off, double length) { return off < length / 2 ? off / (length - off) : 2.0; }

// Linear RGB, and a bound of each channel's error.
struct BoundedColour {
    glm::dvec3 value{0}, error{0};
};

// Power of the highlight.
struct Highlight {
    double value = 0, error = 0;
    double most() const { return std::min(1.0, value + error); }  // the true power is no larger
};

// Power x^n of a cosine that is within `error` of the true one, which is at most 1. A base at or below 0 gives 0, but n = 0 gives 1.
inline Highlight highlightOf(double x, double error, double n) {
    if (n == 0) return {1, 0};
    const double value = x > 0 ? std::pow(x, n) : 0;
    const double share = error / x;
    // |ln(1 - q)| <= q (1 + q) and e^r - 1 <= r (1 + 2 r) where both are at most 1/2.
    if (x > 0 && share <= 0.5) {
        const double exponent = n * share * (1 + share);
        if (exponent <= 0.5) return {value, value * (exponent * (1 + 2 * exponent) + kPowError) * kOwnRounding + kUnderflow};
    }
    // Elsewhere the powers at both ends bound it, since it rises between them.
    const double low = x > error ? std::pow(x - error, n) * (1 - kPowError) : 0;
    const double high = x + error > 0 ? std::min(1.0, std::pow(x + error, n) * (1 + kPowError)) : 0;
    return {value, std::max({0.0, value - low, high - value}) * kOwnRounding + kUnderflow};
}

// Adds one light's part to the colour, where N.L is above 0 and `lit` says so: fade I (Kd (N.L) + Ks (R.V)^n).
// `fadeError` is relative. The bound holds whichever way N.L lies that its error leaves open.
struct LightPart {
    double cosine = 0, cosineError = 0;
    Highlight shine;
    double fade = 1, fadeError = 0;
    bool lit() const { return cosine > 0; }
    bool dark() const { return cosine < -cosineError; }  // whatever the errors are
    bool open() const { return std::abs(cosine) <= cosineError; }
};
inline void addPart(const LightPart& part, const glm::dvec3& diffuse, const glm::dvec3& specular, const glm::dvec3& intensity,
                    BoundedColour& to) {
    if (part.dark()) return;
    for (int c = 0; c < 3; ++c) {
        const double amount = part.fade * intensity[c], kd = diffuse[c], ks = specular[c];
        const double term = kd * part.cosine + ks * part.shine.value;
        const double off = part.open() ? 2 * kd * part.cosineError + ks * part.shine.most() : kd * part.cosineError + ks * part.shine.error;
        if (term == 0 && off == 0) continue;
        if (part.lit()) to.value[c] += amount * term;
        // Four products and sums of the term, and the fading.
        to.error[c] += amount * (off * (1 + part.fadeError) + std::abs(term) * (part.fadeError + 8 * kDoubleUnit)) * kOwnRounding;
    }
}

// Cosine N.L, power of R.V with R = 2 (N.L) N - L, and their errors. Their bounds are those of the differences of directions, one after the other:
// N'.L' - N.L = (N' - N).L' + N.(L' - L).
inline LightPart lightPart(const Direction& n, const Direction& l, const Direction& v, double shininess) {
    LightPart part;
    part.cosine = n.v.x * l.v.x + n.v.y * l.v.y + n.v.z * l.v.z;
    part.cosineError = (n.error + l.error + 4 * kDoubleUnit) * kOwnRounding;
    if (part.dark()) return part;
    const glm::dvec3 r = 2 * part.cosine * n.v - l.v;
    const double along = r.x * v.v.x + r.y * v.v.y + r.z * v.v.z;
    const double error = (2 * (part.cosineError + n.error) + l.error + v.error + 12 * kDoubleUnit) * kOwnRounding;
    part.shine = highlightOf(along, error, shininess);
    return part;
}

}  // namespace plumb::truth
