// SPDX-License-Identifier: MIT
// Exact sums, differences and products of binary64 numbers: integers of any length times a power of two. Slow; for the few decisions that
// binary64 with its bound leaves open. They need no bound, because there is no error.
#pragma once

#include <cstdint>
#include <vector>

namespace plumb::truth {

class Exact {
public:
    Exact() = default;    // 0
    Exact(double value);  // NOLINT(google-explicit-constructor): a double is one of these; finite

    friend Exact operator+(const Exact& a, const Exact& b);
    friend Exact operator-(const Exact& a, const Exact& b) { return a + b.negated(); }
    friend Exact operator*(const Exact& a, const Exact& b);
    Exact negated() const;
    int sign() const { return limbs_.empty() ? 0 : negative_ ? -1 : 1; }
    double rounded() const;  // within a few units in the last place; for tests and messages

private:
    static int compareMagnitude(const Exact& a, const Exact& b);
    uint32_t limbAt(int64_t power) const;  // limb of 2^(32 power)
    void trim();

    bool negative_ = false;
    int64_t lowest_ = 0;           // power of limbs_[0]
    std::vector<uint32_t> limbs_;  // empty: 0; the first and the last limb are not 0
};

}  // namespace plumb::truth
