// SPDX-License-Identifier: MIT
#include "pipeline/measure/rounds.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace plumb {

// Random word by SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators): the same numbers on every machine, which
// std::shuffle does not promise.
uint64_t RoundOrder::random() {
    uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

void RoundOrder::shuffle(std::vector<size_t>& values) {
    // Shuffle. The remainder favours small indices by less than count / 2^64.
    for (size_t left = values.size(); left > 1; --left) std::swap(values[left - 1], values[random() % left]);
}

void RoundOrder::begin(size_t count) {
    count_ = count;
    std::vector<size_t> names(count), rows(count);
    std::iota(names.begin(), names.end(), size_t(0));
    std::iota(rows.begin(), rows.end(), size_t(0));
    shuffle(names);
    // Zigzag of the first row: 0, 1, n-1, 2, n-2, ...: neighbours differ by each number once. Row r adds r to all.
    std::vector<size_t> zigzag;
    for (size_t i = 0; i < count; ++i) zigzag.push_back(i % 2 != 0 ? (i + 1) / 2 : (count - i / 2) % count);
    square_.clear();
    for (const size_t row : rows) {
        std::vector<size_t> round;
        for (const size_t step : zigzag) round.push_back(names[(step + row) % count]);
        square_.push_back(round);
        if (count % 2 != 0) square_.emplace_back(round.rbegin(), round.rend());
    }
    std::vector<size_t> order(square_.size());
    std::iota(order.begin(), order.end(), size_t(0));
    shuffle(order);
    std::vector<std::vector<size_t>> shuffled;
    for (const size_t at : order) shuffled.push_back(std::move(square_[at]));
    square_ = std::move(shuffled);
}

std::vector<size_t> RoundOrder::next(size_t count) {
    if (count == 0) return {};
    if (square_.empty() || count != count_) begin(count);
    std::vector<size_t> round = std::move(square_.back());
    square_.pop_back();
    return round;
}

}  // namespace plumb
