// SPDX-License-Identifier: MIT
#include "pipeline/measure/pareto.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace plumb {

std::vector<size_t> paretoFront(std::span<const TradePoint> points) {
    std::vector<size_t> order(points.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
        return points[a].time != points[b].time ? points[a].time < points[b].time : points[a].error < points[b].error;
    });
    // By rising time a point is on the front when its error is below all before it, or it equals the last one that was.
    std::vector<size_t> front;
    double least = std::numeric_limits<double>::infinity();
    for (const size_t i : order) {
        const bool again = !front.empty() && points[i].time == points[front.back()].time &&
                           points[i].error == points[front.back()].error;
        if (!again && !(points[i].error < least)) continue;
        front.push_back(i);
        least = points[i].error;
    }
    return front;
}

}  // namespace plumb
