// SPDX-License-Identifier: MIT
#include "pipeline/measure/front.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace plumb {

namespace {

struct Unit {
    double low, high;
    std::pair<long long, long long> error;  // against the truth of the most samples, then at its own
    std::vector<size_t> points;
};

long long stepsOf(double error) { return std::llround(error / kErrorStep); }

// Errors of both kinds in steps. Within pictures of the same samples the first rises with the second.
std::vector<std::pair<long long, long long>> errorsOf(std::span<const FrontPoint> points) {
    std::vector<std::pair<long long, long long>> errors;
    for (const FrontPoint& point : points) {
        const long long own = stepsOf(point.errorAtItsSamples);
        long long most = stepsOf(point.errorAtMostSamples);
        for (const FrontPoint& other : points)
            if (other.samples == point.samples && stepsOf(other.errorAtItsSamples) <= own)
                most = std::max(most, stepsOf(other.errorAtMostSamples));
        errors.emplace_back(most, own);
    }
    return errors;
}

// Units: chains of overlapping intervals within one work.
std::vector<Unit> unitsOf(std::span<const FrontPoint> points) {
    const auto errors = errorsOf(points);
    std::vector<size_t> order(points.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
        return points[a].work != points[b].work ? points[a].work < points[b].work : points[a].low < points[b].low;
    });
    std::vector<Unit> units;
    size_t work = 0;
    for (const size_t i : order) {
        const FrontPoint& point = points[i];
        if (units.empty() || point.work != work || point.low > units.back().high) units.push_back({point.low, point.high, errors[i], {}});
        work = point.work;
        units.back().high = std::max(units.back().high, point.high);
        units.back().points.push_back(i);
    }
    // Points with the default's errors that are not told apart from it join its unit.
    const auto holds = [](const Unit& unit, size_t i) { return std::find(unit.points.begin(), unit.points.end(), i) != unit.points.end(); };
    const auto own = std::find_if(units.begin(), units.end(), [&](const Unit& unit) { return holds(unit, 0); });
    if (own == units.end()) return units;
    Unit base{1, 1, own->error, {}};
    std::vector<Unit> others;
    for (Unit& unit : units) {
        const bool again = std::any_of(unit.points.begin(), unit.points.end(), [&](size_t i) { return points[i].again; });
        if (holds(unit, 0) || again || (unit.error == base.error && unit.low <= 1 && 1 <= unit.high))
            base.points.insert(base.points.end(), unit.points.begin(), unit.points.end());
        else
            others.push_back(std::move(unit));
    }
    others.push_back(std::move(base));
    return others;
}

bool beats(const Unit& a, const Unit& b) {
    const bool faster = a.high < b.low, slower = b.high < a.low;
    return (faster && a.error <= b.error) || (!slower && a.error < b.error);
}

}  // namespace

std::vector<bool> frontOf(std::span<const FrontPoint> points) {
    const std::vector<Unit> units = unitsOf(points);
    std::vector<bool> front(points.size(), false);
    for (const Unit& unit : units) {
        const bool beaten = std::any_of(units.begin(), units.end(), [&](const Unit& other) { return beats(other, unit); });
        for (const size_t i : unit.points) front[i] = !beaten;
    }
    return front;
}

}  // namespace plumb
