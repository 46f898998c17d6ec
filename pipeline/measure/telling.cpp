// SPDX-License-Identifier: MIT
#include "pipeline/measure/telling.h"

#include "host/error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumb {

double missOf(size_t comparisons) {
    return std::min(1 - kConfidenceOfRow, (1 - kConfidenceOfTable) / double(std::max<size_t>(1, comparisons)));
}

uint32_t rankOf(uint32_t count, double miss) {
    // Probability P(exactly `k` of `count` tosses) by recurrence. 2^-count underflows for counts that no one repeats; the sum then starts
    // at 0, which changes no decision in practice.
    double exactly = std::exp2(-double(count)), below = 0;
    uint32_t rank = 0;
    while (2 * (rank + 1) <= count + 1) {
        below += exactly;  // P(Binomial < rank + 1)
        if (2 * below > miss) break;
        exactly *= double(count - rank) / double(rank + 1);
        ++rank;
    }
    return rank;
}

uint32_t roundsToTell(double miss) {
    uint32_t count = 1;
    while (rankOf(count, miss) == 0) ++count;
    return count;
}

bool RatioInterval::bounded() const { return low > 0 && std::isfinite(high); }

double medianOf(std::vector<double> values) {
    PLUMB_ASSERT(!values.empty());
    std::sort(values.begin(), values.end());
    const size_t n = values.size();
    return n % 2 != 0 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

std::optional<RatioInterval> intervalOf(std::vector<double> ratios, double miss) {
    if (ratios.size() < kLeastForMedian) return std::nullopt;
    std::sort(ratios.begin(), ratios.end());
    RatioInterval interval{medianOf(ratios), 0, std::numeric_limits<double>::infinity()};
    if (const uint32_t rank = rankOf(uint32_t(ratios.size()), miss); rank > 0) {
        interval.low = ratios[rank - 1];
        interval.high = ratios[ratios.size() - rank];
    }
    return interval;
}

}  // namespace plumb
