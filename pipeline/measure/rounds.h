// SPDX-License-Identifier: MIT
// Order in which the runs of a round are drawn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace plumb {

// Order of rounds. A run leaves its threads, caches and clock speed to the run after it, so each run must follow every other equally often.
// Rounds come in Williams squares: within one, each run follows each other exactly once (twice when their number is odd, since then no
// single square does it). Runs are permuted, and the square's rows too, anew for each square, from a seed.
class RoundOrder {
public:
    explicit RoundOrder(uint64_t seed) : state_(seed) {}
    // Next round of `count` runs: each of 0 to count - 1 once. Another count begins another square.
    std::vector<size_t> next(size_t count);

private:
    uint64_t random();
    void shuffle(std::vector<size_t>& values);
    void begin(size_t count);

    uint64_t state_;
    std::vector<std::vector<size_t>> square_;  // rounds to come, the last one first
    size_t count_ = 0;
};

}  // namespace plumb
