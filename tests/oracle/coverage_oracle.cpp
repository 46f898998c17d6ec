// SPDX-License-Identifier: MIT
#include "tests/oracle/coverage_oracle.h"

#include <algorithm>

namespace plumb::oracle {
namespace {

using Wide = __int128;

// Least integer i with i * unit >= numerator / denominator - offset; denominator > 0.
Wide firstAtOrAfter(Wide numerator, Wide denominator, Wide unit, Wide offset) {
    const Wide n = numerator - offset * denominator, d = denominator * unit;
    const Wide quotient = n / d;
    return quotient + (n % d > 0 ? 1 : 0);
}

struct Fraction {
    Wide numerator, denominator;  // denominator > 0
};

// x of the edge from `a` down to `b` (a.y < b.y) on the line `y`.
Fraction crossing(const SubpixelPoint& a, const SubpixelPoint& b, int64_t y) {
    const Wide height = b.y - a.y;
    return {Wide(a.x) * height + Wide(b.x - a.x) * (y - a.y), height};
}

bool less(const Fraction& a, const Fraction& b) { return a.numerator * b.denominator < b.numerator * a.denominator; }

}  // namespace

std::vector<CoveredSpan> coveredSpans(const SubpixelTriangle& triangle, int width, int height) {
    SubpixelTriangle p = triangle;
    std::sort(p.begin(), p.end(), [](const SubpixelPoint& a, const SubpixelPoint& b) { return a.y < b.y; });
    std::vector<CoveredSpan> spans;
    if (p[0].y == p[2].y) return spans;
    const auto clamped = [](Wide value, int limit) { return int(std::clamp<Wide>(value, 0, limit)); };
    const int top = clamped(firstAtOrAfter(p[0].y, 1, 256, 128), height);
    const int bottom = clamped(firstAtOrAfter(p[2].y, 1, 256, 128), height);  // first row not above the bottom corner
    for (int row = top; row < bottom; ++row) {
        const int64_t y = int64_t(row) * 256 + 128;
        const Fraction across = crossing(p[0], p[2], y);
        const Fraction bent = y < p[1].y ? crossing(p[0], p[1], y) : crossing(p[1], p[2], y);
        const Fraction& left = less(across, bent) ? across : bent;
        const Fraction& right = less(across, bent) ? bent : across;
        const int first = clamped(firstAtOrAfter(left.numerator, left.denominator, 256, 128), width);
        const int end = clamped(firstAtOrAfter(right.numerator, right.denominator, 256, 128), width);
        if (first < end) spans.push_back({row, first, end});
    }
    return spans;
}

bool isNearBoundary(const SubpixelTriangle& triangle, int x, int y, int subpixels) {
    const Wide px = Wide(x) * 256 + 128, py = Wide(y) * 256 + 128, limit = Wide(subpixels) * subpixels;
    for (int i = 0; i < 3; ++i) {
        const SubpixelPoint &a = triangle[i], &b = triangle[(i + 1) % 3];
        const Wide ex = b.x - a.x, ey = b.y - a.y, dx = px - a.x, dy = py - a.y;
        const Wide length2 = ex * ex + ey * ey, along = dx * ex + dy * ey;
        if (along <= 0) {
            if (dx * dx + dy * dy <= limit) return true;
        } else if (along >= length2) {
            const Wide fx = px - b.x, fy = py - b.y;
            if (fx * fx + fy * fy <= limit) return true;
        } else {
            const Wide cross = dx * ey - dy * ex;
            if (cross * cross <= limit * length2) return true;
        }
    }
    return false;
}

}  // namespace plumb::oracle
