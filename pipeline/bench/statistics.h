// SPDX-License-Identifier: MIT
// Statistics of repeated measurements: no mean, since a machine under load has outliers to one side only.
#pragma once

#include "host/error.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace plumb {

// Wall time of one call.
inline double msOf(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

struct Spread {
    double median = 0, p10 = 0, p90 = 0, least = 0;
    uint32_t count = 0;
};

// Spread of values: quantiles by linear interpolation between order statistics.
inline Spread spreadOf(std::vector<double> values) {
    PLUMB_ASSERT(!values.empty());
    std::sort(values.begin(), values.end());
    const auto quantile = [&](double q) {
        const double at = q * double(values.size() - 1);
        const size_t below = size_t(at);
        const size_t above = std::min(below + 1, values.size() - 1);
        return values[below] + (values[above] - values[below]) * (at - double(below));
    };
    return {quantile(0.5), quantile(0.1), quantile(0.9), values.front(), uint32_t(values.size())};
}

// Spread of the quotients of pairs that were measured side by side: a drift of the machine cancels in each.
inline Spread ratioOf(const std::vector<double>& numerators, const std::vector<double>& denominators) {
    PLUMB_ASSERT(numerators.size() == denominators.size());
    std::vector<double> quotients;
    for (size_t i = 0; i < numerators.size(); ++i) quotients.push_back(numerators[i] / denominators[i]);
    return spreadOf(std::move(quotients));
}

}  // namespace plumb
