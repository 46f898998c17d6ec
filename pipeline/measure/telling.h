// SPDX-License-Identifier: MIT
// Telling paired times apart: each round gives one ratio of a run's time to the default's, and an interval of their median says whether
// noise explains it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace plumb {

// Share of measurements in which no row of a table is told apart wrongly.
inline constexpr double kConfidenceOfTable = 0.95;
// Share of measurements in which one row's interval holds its median, at least.
inline constexpr double kConfidenceOfRow = 0.99;
// Least number of times with a median that one stall cannot move.
inline constexpr uint32_t kLeastForMedian = 3;

// Chance that the interval of one of `comparisons` rows may miss: Bonferroni's share of the table's, and never above the row's own.
double missOf(size_t comparisons);

// Rank k of the order statistics that bound a median's interval: the largest k with 2 P(Binomial(count, 1/2) < k) <= miss. 0 where even the
// least and the largest of so few values miss more often: then no interval is bounded.
uint32_t rankOf(uint32_t count, double miss);

// Least number of rounds that can tell anything apart.
uint32_t roundsToTell(double miss);

// Median of the rounds' ratios and its interval by order statistics (the sign test inverted). It assumes nothing about the distribution of
// the noise. Each round's ratio lies above or below the true median by the toss of a coin, so the number above it is binomial.
struct RatioInterval {
    double median = 1;
    double low = 1, high = 1;  // 0 and infinity where the rounds are too few
    bool bounded() const;
    bool holdsOne() const { return low <= 1 && 1 <= high; }
};

// Interval of ratios; none below kLeastForMedian of them.
std::optional<RatioInterval> intervalOf(std::vector<double> ratios, double miss);

// Median of at least one value; an even count has the mean of its middle two.
double medianOf(std::vector<double> values);

}  // namespace plumb
