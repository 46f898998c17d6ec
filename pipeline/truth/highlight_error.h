// SPDX-License-Identifier: MIT
// Bound of the highlight's error, for every exponent (docs/derivations.md, The power of the highlight).
#pragma once

#include <cmath>

namespace plumb::truth {

// Bound of |x'^n - x^n| where x = 1 - c^2 / 2 and x' = 1 - c'^2 / 2 are at least 0 or taken as 0, and the lengths c, c' of R - V are within
// `chordError` of each other. `floor`: x' below it may be taken as it. n > 0.
template <class Real>
Real highlightError(Real n, Real chordError, Real floor) {
    if (n < 1) return std::pow(std::sqrt(Real(2)) * chordError + floor, n);
    // The largest slope of x^n by c is at c^2 = 2 / (2 n - 1).
    const Real steepest = n / std::sqrt(n - Real(0.5)) * std::pow((n - 1) / (n - Real(0.5)), n - 1);
    return steepest * chordError + floor;
}

}  // namespace plumb::truth
