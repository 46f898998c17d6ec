// SPDX-License-Identifier: MIT
#include "pipeline/truth/exact.h"

#include "host/error.h"

#include <algorithm>
#include <cmath>

namespace plumb::truth {

Exact::Exact(double value) {
    PLUMB_ASSERT(std::isfinite(value));
    if (value == 0) return;
    negative_ = value < 0;
    int exponent = 0;
    const double fraction = std::frexp(std::abs(value), &exponent);
    const auto significand = uint64_t(std::ldexp(fraction, 53));  // value = significand 2^(exponent - 53)
    const int64_t low = int64_t(exponent) - 53;
    lowest_ = low >= 0 ? low / 32 : -((-low + 31) / 32);
    const int shift = int(low - 32 * lowest_);  // 0 to 31
    const auto wide = static_cast<unsigned __int128>(significand) << shift;
    for (int i = 0; i < 3; ++i) limbs_.push_back(uint32_t(wide >> (32 * i)));
    trim();
}

void Exact::trim() {
    while (!limbs_.empty() && limbs_.back() == 0) limbs_.pop_back();
    size_t zeros = 0;
    while (zeros < limbs_.size() && limbs_[zeros] == 0) ++zeros;
    limbs_.erase(limbs_.begin(), limbs_.begin() + ptrdiff_t(zeros));
    lowest_ += int64_t(zeros);
    if (limbs_.empty()) negative_ = false, lowest_ = 0;
}

uint32_t Exact::limbAt(int64_t power) const {
    const int64_t i = power - lowest_;
    return i >= 0 && i < int64_t(limbs_.size()) ? limbs_[size_t(i)] : 0;
}

int Exact::compareMagnitude(const Exact& a, const Exact& b) {
    const int64_t aTop = a.lowest_ + int64_t(a.limbs_.size()), bTop = b.lowest_ + int64_t(b.limbs_.size());
    for (int64_t power = std::max(aTop, bTop) - 1; power >= std::min(a.lowest_, b.lowest_); --power) {
        const uint32_t x = a.limbAt(power), y = b.limbAt(power);
        if (x != y) return x > y ? 1 : -1;
    }
    return 0;
}

Exact Exact::negated() const {
    Exact r = *this;
    r.negative_ = !limbs_.empty() && !negative_;
    return r;
}

Exact operator+(const Exact& a, const Exact& b) {
    if (a.limbs_.empty()) return b;
    if (b.limbs_.empty()) return a;
    const bool subtract = a.negative_ != b.negative_;
    const bool swapped = subtract && Exact::compareMagnitude(a, b) < 0;
    const Exact& large = swapped ? b : a;
    const Exact& small = swapped ? a : b;
    const int64_t low = std::min(a.lowest_, b.lowest_);
    const int64_t top = std::max(a.lowest_ + int64_t(a.limbs_.size()), b.lowest_ + int64_t(b.limbs_.size())) + 1;
    Exact r;
    r.negative_ = large.negative_;
    r.lowest_ = low;
    r.limbs_.reserve(size_t(top - low));
    int64_t carry = 0;
    for (int64_t power = low; power < top; ++power) {
        const int64_t addend = small.limbAt(power);
        const int64_t sum = int64_t(large.limbAt(power)) + (subtract ? -addend : addend) + carry;
        r.limbs_.push_back(uint32_t(sum & 0xffffffff));
        carry = sum >> 32;
    }
    r.trim();
    return r;
}

Exact operator*(const Exact& a, const Exact& b) {
    Exact r;
    if (a.limbs_.empty() || b.limbs_.empty()) return r;
    r.negative_ = a.negative_ != b.negative_;
    r.lowest_ = a.lowest_ + b.lowest_;
    r.limbs_.assign(a.limbs_.size() + b.limbs_.size(), 0);
    for (size_t i = 0; i < a.limbs_.size(); ++i) {
        uint64_t carry = 0;
        for (size_t j = 0; j < b.limbs_.size(); ++j) {
            carry += uint64_t(a.limbs_[i]) * b.limbs_[j] + r.limbs_[i + j];
            r.limbs_[i + j] = uint32_t(carry);
            carry >>= 32;
        }
        r.limbs_[i + b.limbs_.size()] = uint32_t(carry);
    }
    r.trim();
    return r;
}

double Exact::rounded() const {
    double sum = 0;
    for (size_t i = 0; i < limbs_.size(); ++i) sum += std::ldexp(double(limbs_[i]), int(32 * (lowest_ + int64_t(i))));
    return negative_ ? -sum : sum;
}

}  // namespace plumb::truth
