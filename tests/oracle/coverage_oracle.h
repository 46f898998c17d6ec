// SPDX-License-Identifier: MIT
// Coverage of a triangle by another method than edge functions: on each row of pixel centres the triangle is an interval with rational ends,
// computed from its sorted corners in 128-bit integers, without rounding. Top-left rule: of a row the left end belongs to the triangle and the
// right end does not; of the rows, the one through the top corner may and the one through the bottom corner does not.
// Winding does not matter; a triangle without area covers nothing.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace plumb::oracle {

// 1/256 px, y down; pixel (x, y) is sampled at (256 x + 128, 256 y + 128). |x|, |y| < 2^29.
struct SubpixelPoint {
    int64_t x, y;
};
using SubpixelTriangle = std::array<SubpixelPoint, 3>;

struct CoveredSpan {
    int row, first, end;  // pixels first <= x < end of the row
    bool operator==(const CoveredSpan&) const = default;
};

// Spans of the rows 0 to height - 1 cut to the columns 0 to width - 1; empty ones are left out.
std::vector<CoveredSpan> coveredSpans(const SubpixelTriangle& triangle, int width, int height);

// Is the centre of pixel (x, y) within `subpixels` / 256 px of the triangle's boundary? Exact.
bool isNearBoundary(const SubpixelTriangle& triangle, int x, int y, int subpixels = 1);

}  // namespace plumb::oracle
