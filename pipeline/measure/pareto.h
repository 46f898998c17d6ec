// SPDX-License-Identifier: MIT
// The front of a trade: what nothing else beats in both time and error.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace plumb {

struct TradePoint {
    double time = 0, error = 0;
};

// Indices of the points that no other beats (at most its time and its error, and less in one), by rising time. Of equal points all are in it.
std::vector<size_t> paretoFront(std::span<const TradePoint> points);

}  // namespace plumb
