// SPDX-License-Identifier: MIT
// Columns that a line of a convex polygon paints, in fractions of whole numbers from the corners alone: no table, no step, no float.
// The rule is the notes': the line's ends are X of the edges that cross it (13.1), X runs leftX, leftX + 1, ... <= rightX and paints
// floor(X + 1/2).
#pragma once

#include "shaders/shared/scanline.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace plumb::test {

// numerator / denominator, denominator > 0.
struct Fraction {
    __int128 numerator, denominator;
    friend bool operator<(const Fraction& a, const Fraction& b) { return a.numerator * b.denominator < b.numerator * a.denominator; }
    friend Fraction operator-(const Fraction& a, const Fraction& b) {
        return {a.numerator * b.denominator - b.numerator * a.denominator, a.denominator * b.denominator};
    }
    __int128 floor() const { return numerator / denominator - (numerator % denominator < 0 ? 1 : 0); }
};

struct PaintedLine {
    int64_t first, last;  // columns
};

// X of the edge a-b on line y: a.x + (y - a.y) (b.x - a.x) / (b.y - a.y).
inline Fraction crossing(const gpu::ScanCorner& a, const gpu::ScanCorner& b, int64_t y) {
    const __int128 height = __int128(b.y) - a.y;
    return {a.x * height + (y - a.y) * (__int128(b.x) - a.x), height};
}

// None where the polygon has no line y, or is less than a line high.
inline std::optional<PaintedLine> paintedLine(std::span<const gpu::ScanCorner> polygon, int64_t y) {
    const auto byY = [](const gpu::ScanCorner& a, const gpu::ScanCorner& b) { return a.y < b.y; };
    const int64_t top = std::min_element(polygon.begin(), polygon.end(), byY)->y;
    std::optional<Fraction> left, right;
    for (size_t i = 0; i < polygon.size(); ++i) {
        const auto [upper, lower] = std::minmax(polygon[i], polygon[(i + 1) % polygon.size()], byY);
        // A corner's line belongs to the edge above it (A4), the first line to the edges below.
        if (upper.y == lower.y || y > lower.y || (y == top ? y < upper.y : y <= upper.y)) continue;
        const Fraction x = crossing(upper, lower, y);
        if (!left || x < *left) left = x;
        if (!right || *right < x) right = x;
    }
    if (!left) return std::nullopt;
    const int64_t first = int64_t(Fraction{2 * left->numerator + left->denominator, 2 * left->denominator}.floor());
    return PaintedLine{first, first + int64_t((*right - *left).floor())};
}

}  // namespace plumb::test
