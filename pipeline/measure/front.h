// SPDX-License-Identifier: MIT
// Front of a trade: the points that no other beats in time and error, as far as times can be told apart.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace plumb {

// Resolution of errors, in steps of 1/255: a thousandth of a step, the last digit that the table prints. Less moves no byte of a picture.
inline constexpr double kErrorStep = 0.001;

struct FrontPoint {
    double low = 1, high = 1;       // interval of the ratio to the default's time; the default's own is [1, 1]
    double errorAtItsSamples = 0;   // rms against the truth at the picture's own samples
    double errorAtMostSamples = 0;  // rms against the truth of the most samples
    size_t samples = 0;             // pictures with equal numbers take the same samples
    size_t work = 0;                // pictures with equal numbers have equal bytes, passes and renderer: between them only noise decides
    bool again = false;             // the default once more: one with it whatever its interval says
};

// True for each point on the front. The first point is the default. One point is nearer to the truth than another when its error is less.
// With the same samples that is the error at these samples, with other samples the error against the truth of the most samples. There a
// point counts no less than any that is nearer at the same samples, because edges that happen to cancel are no merit. It is faster when its
// interval lies below the other's. It beats a point when it is faster and not further off, or nearer and not slower. Points of one work
// whose intervals overlap, one to the next, are one point: all of them are on the front, or none. So are the default and the points with
// its errors that are not told apart from it.
std::vector<bool> frontOf(std::span<const FrontPoint> points);

}  // namespace plumb
