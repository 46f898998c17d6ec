// SPDX-License-Identifier: MIT
// Sine and cosine of angles in degrees that have the same bits with every C library.
#pragma once

#include <cmath>

namespace plumb {

struct SineCosine {
    double sine, cosine;
};

// Sine and cosine, exact at multiples of 90 degrees. Taylor's series on at most 45 degrees, where the first term left out is below 2^-63 of
// the sum: only + - * / and remquo, which IEEE 754 defines exactly.
inline SineCosine sineCosineOfDegrees(double degrees) {
    int quadrant = 0;
    const double x = std::remquo(degrees, 90.0, &quadrant) * (3.14159265358979323846 / 180);
    const double xx = x * x;
    double sineTail = 0, cosineTail = 0;
    for (int n = 18; n >= 2; n -= 2) {
        cosineTail = (1 - cosineTail) * xx / (n * (n - 1));
        sineTail = (1 - sineTail) * xx / (n * (n + 1));
    }
    const double s = x - x * sineTail, c = 1 - cosineTail;
    switch (unsigned(quadrant) & 3u) {
        case 0:
            return {s, c};
        case 1:
            return {c, -s};
        case 2:
            return {-s, -c};
        default:
            return {-c, s};
    }
}

}  // namespace plumb
