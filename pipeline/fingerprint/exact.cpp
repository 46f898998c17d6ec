// SPDX-License-Identifier: MIT
#include "pipeline/fingerprint/exact.h"

#include "host/error.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>

namespace plumb {

namespace {

constexpr int kLowestExponent = -126;  // of a normal float32
constexpr uint32_t kInfinityBits = 0x7f800000u, kNanBits = 0x7fc00000u;

// floor(x / 2^n) and whether anything was cut off.
Wide shiftedRight(Wide x, int n, bool& inexact) {
    if (n <= 0) return x;
    if (n >= 128) {
        inexact = inexact || x != 0;
        return 0;
    }
    inexact = inexact || (x & ((Wide(1) << n) - 1)) != 0;
    return x >> n;
}

// floor(sqrt(x)), one bit after the other.
uint64_t integerRoot(Wide x, bool& inexact) {
    uint64_t root = 0;
    for (int bit = 63; bit >= 0; --bit) {
        const uint64_t tried = root | uint64_t(1) << bit;
        if (Wide(tried) * tried <= x) root = tried;
    }
    inexact = Wide(root) * root != x;
    return root;
}

uint32_t significandOf(const Exact& x) { return uint32_t(x.mantissa >> 104); }  // of a float32: 24 bits

// A number of the kind that float32 has, cut to whole units of its last place.
struct Cut {
    Wide units = 0;   // whole units
    int shift = 0;    // the units are mantissa >> shift
    bool up = false;  // more than half of a unit was cut off, or half of one from an odd number
    bool tie = false, rest = false;
};

Cut cutToFloat(const Exact& x) {
    Cut cut;
    cut.shift = 104 + std::max(0, kLowestExponent - x.topExponent());
    if (cut.shift > 128) {
        cut.rest = true;
        return cut;
    }
    cut.units = cut.shift == 128 ? 0 : x.mantissa >> cut.shift;
    const Wide rest = cut.shift == 128 ? x.mantissa : x.mantissa & ((Wide(1) << cut.shift) - 1);
    const Wide half = Wide(1) << (cut.shift - 1);
    cut.tie = rest == half && !x.inexact;
    cut.rest = rest != 0 || x.inexact;
    cut.up = rest > half || (rest == half && (x.inexact || (cut.units & 1) != 0));
    return cut;
}

uint32_t floatOfUnits(const Exact& x, Wide units) {
    // A carry out of the significand runs into the exponent, which is the wanted result.
    const int field = std::max(0, x.topExponent() - kLowestExponent);
    const uint64_t bits = (uint64_t(field) << 23) + uint64_t(units);
    return uint32_t(std::min<uint64_t>(bits, kInfinityBits)) | (x.negative ? 0x80000000u : 0u);
}

uint32_t signBit(const Exact& x) { return x.negative ? 0x80000000u : 0u; }

}  // namespace

int leadingZeros(Wide x) {
    const uint64_t high = uint64_t(x >> 64);
    return high != 0 ? std::countl_zero(high) : 64 + std::countl_zero(uint64_t(x));
}

Wide highProduct(Wide a, Wide b) {
    const uint64_t a0 = uint64_t(a), a1 = uint64_t(a >> 64), b0 = uint64_t(b), b1 = uint64_t(b >> 64);
    const Wide low = Wide(a0) * b0, left = Wide(a1) * b0, right = Wide(a0) * b1;
    const Wide middle = (low >> 64) + uint64_t(left) + uint64_t(right);
    return Wide(a1) * b1 + (left >> 64) + (right >> 64) + (middle >> 64);
}

Exact Exact::finite(bool negative, Wide mantissa, int exponent, bool inexact) {
    if (mantissa == 0) {
        if (!inexact) return zero(negative);
        mantissa = 1;
    }
    const int zeros = leadingZeros(mantissa);
    return {Kind::finite, negative, inexact, exponent - zeros, mantissa << zeros};
}

Exact exactOf(uint32_t bits) {
    const bool negative = bits >> 31 != 0;
    const int field = int(bits >> 23 & 255u);
    const uint32_t fraction = bits & 0x7fffffu;
    if (field == 255) return fraction != 0 ? Exact::nan() : Exact::infinite(negative);
    return Exact::finite(negative, field == 0 ? fraction : fraction | 0x800000u, std::max(field, 1) - 150);
}

Exact exactOfInteger(bool negative, uint64_t magnitude) { return Exact::finite(negative, magnitude, 0); }

Exact negated(Exact x) {
    x.negative = !x.negative;
    return x;
}

Exact plus(const Exact& x, const Exact& y) {
    if (x.kind == Exact::Kind::nan || y.kind == Exact::Kind::nan) return Exact::nan();
    if (x.kind == Exact::Kind::infinite || y.kind == Exact::Kind::infinite) {
        if (x.kind == y.kind && x.negative != y.negative) return Exact::nan();
        return x.kind == Exact::Kind::infinite ? x : y;
    }
    if (!x.isFinite() && !y.isFinite()) return Exact::zero(x.negative && y.negative);
    if (!x.isFinite()) return y;
    if (!y.isFinite()) return x;
    Exact a = x, b = y;  // |a| >= |b|
    if (a.exponent < b.exponent || (a.exponent == b.exponent && a.mantissa < b.mantissa)) std::swap(a, b);
    bool largeCut = a.inexact, smallCut = b.inexact;
    const Wide large = shiftedRight(a.mantissa, 2, largeCut);
    const Wide small = shiftedRight(b.mantissa, std::min(2 + a.exponent - b.exponent, 200), smallCut);
    const bool inexact = largeCut || smallCut;
    if (a.negative == b.negative) return Exact::finite(a.negative, large + small, a.exponent + 2, inexact);
    if (large == small) return inexact ? Exact::finite(a.negative, 0, a.exponent + 2, true) : Exact::zero(false);
    return Exact::finite(a.negative, large - small - (smallCut ? 1 : 0), a.exponent + 2, inexact);
}

Exact times(const Exact& x, const Exact& y) {
    if (x.kind == Exact::Kind::nan || y.kind == Exact::Kind::nan) return Exact::nan();
    const bool negative = x.negative != y.negative;
    const bool zero = x.kind == Exact::Kind::zero || y.kind == Exact::Kind::zero;
    if (x.kind == Exact::Kind::infinite || y.kind == Exact::Kind::infinite) return zero ? Exact::nan() : Exact::infinite(negative);
    if (zero) return Exact::zero(negative);
    PLUMB_ASSERT(uint64_t(x.mantissa) == 0 && uint64_t(y.mantissa) == 0);
    return Exact::finite(negative, (x.mantissa >> 64) * (y.mantissa >> 64), x.exponent + y.exponent + 128);
}

Exact over(const Exact& x, const Exact& y) {
    if (x.kind == Exact::Kind::nan || y.kind == Exact::Kind::nan) return Exact::nan();
    const bool negative = x.negative != y.negative;
    if (x.kind == Exact::Kind::infinite) return y.kind == Exact::Kind::infinite ? Exact::nan() : Exact::infinite(negative);
    if (y.kind == Exact::Kind::zero) return x.kind == Exact::Kind::zero ? Exact::nan() : Exact::infinite(negative);
    if (y.kind == Exact::Kind::infinite || x.kind == Exact::Kind::zero) return Exact::zero(negative);
    const Wide numerator = Wide(significandOf(x)) << 100, denominator = significandOf(y);
    return Exact::finite(negative, numerator / denominator, x.exponent - y.exponent - 100, numerator % denominator != 0);
}

Exact rootOf(const Exact& x) {
    if (x.kind == Exact::Kind::zero) return x;
    if (x.kind == Exact::Kind::nan || x.negative) return Exact::nan();
    if (x.kind == Exact::Kind::infinite) return x;
    const int exponent = x.exponent + 104;  // of the 24-bit significand
    const bool odd = (exponent & 1) != 0;
    bool inexact = false;
    const uint64_t root = integerRoot(Wide(significandOf(x)) << (odd ? 103 : 102), inexact);
    return Exact::finite(false, root, (exponent - (odd ? 1 : 0) - 102) / 2, inexact);
}

Exact inverseRootOf(const Exact& x) {
    if (x.kind == Exact::Kind::zero) return Exact::infinite(x.negative);
    if (x.kind == Exact::Kind::nan || x.negative) return Exact::nan();
    if (x.kind == Exact::Kind::infinite) return Exact::zero(false);
    const int exponent = x.exponent + 104;
    const bool odd = (exponent & 1) != 0;
    const Wide significand = Wide(significandOf(x)) << (odd ? 1 : 0);
    bool inexact = false;
    const Wide quotient = (Wide(1) << 126) / significand;
    const uint64_t root = integerRoot(quotient, inexact);
    inexact = inexact || (Wide(1) << 126) % significand != 0;
    return Exact::finite(false, root, -63 - (exponent - (odd ? 1 : 0)) / 2, inexact);
}

Exact modulo(const Exact& x, const Exact& y) {
    if (!y.isFinite() || (!x.isFinite() && x.kind != Exact::Kind::zero)) return Exact::nan();
    if (x.kind == Exact::Kind::zero) return Exact::zero(y.negative);
    const int low = std::min(x.exponent, y.exponent) + 104;
    PLUMB_ASSERT(x.exponent - y.exponent < 100 && y.exponent - x.exponent < 100);
    const Wide a = Wide(significandOf(x)) << (x.exponent + 104 - low), b = Wide(significandOf(y)) << (y.exponent + 104 - low);
    Wide rest = a % b;
    if (rest != 0 && x.negative != y.negative) rest = b - rest;
    return Exact::finite(y.negative, rest, low);
}

uint32_t nearestFloat(const Exact& x) {
    if (x.kind == Exact::Kind::nan) return kNanBits;
    if (x.kind == Exact::Kind::zero) return signBit(x);
    if (x.kind == Exact::Kind::infinite || x.topExponent() > 127) return kInfinityBits | signBit(x);
    const Cut cut = cutToFloat(x);
    return floatOfUnits(x, cut.units + (cut.up ? 1 : 0));
}

bool isTie(const Exact& x) { return x.isFinite() && x.topExponent() <= 127 && cutToFloat(x).tie; }

uint32_t floatBeyond(const Exact& x) {
    if (!x.isFinite() || x.topExponent() > 127) return nearestFloat(x);
    const Cut cut = cutToFloat(x);
    return floatOfUnits(x, cut.units + (cut.rest ? 1 : 0));
}

uint32_t floatWithin(const Exact& x) {
    if (!x.isFinite()) return nearestFloat(x);
    if (x.topExponent() > 127) return 0x7f7fffffu | signBit(x);
    return floatOfUnits(x, cutToFloat(x).units);
}

uint64_t distance(const Exact& exact, uint32_t got, const Exact& scale) {
    const Exact g = exactOf(got);
    if (exact.kind == Exact::Kind::nan || g.kind == Exact::Kind::nan) return exact.kind == g.kind ? 0 : kMostUlps;
    // What rounds to an infinity is one.
    const bool overflows = exact.kind == Exact::Kind::infinite || (nearestFloat(exact) & 0x7fffffffu) == kInfinityBits;
    if (overflows || g.kind == Exact::Kind::infinite)
        return overflows && g.kind == Exact::Kind::infinite && g.negative == exact.negative ? 0 : kMostUlps;
    if (exact.kind == Exact::Kind::zero && g.kind == Exact::Kind::zero) return 0;
    const int unit = (scale.isFinite() ? std::max(scale.topExponent(), kLowestExponent) : kLowestExponent) - 23 - 16;
    const auto units = [&](const Exact& x) -> Wide {  // whole units of |x|, saturated
        if (!x.isFinite()) return 0;
        if (x.exponent - unit > -60) return kMostUlps;
        bool ignored = false;
        return shiftedRight(x.mantissa, unit - x.exponent, ignored);
    };
    const Wide a = units(exact), b = units(g);
    const Wide apart = exact.negative == g.negative ? (a > b ? a - b : b - a) : a + b;
    return uint64_t(std::min<Wide>(apart, kMostUlps));
}

uint64_t ulpsOfPower(int power, const Exact& scale) {
    const int unit = (scale.isFinite() ? std::max(scale.topExponent(), kLowestExponent) : kLowestExponent) - 23 - 16;
    if (power < unit) return 0;
    return power - unit >= 60 ? kMostUlps : uint64_t(1) << (power - unit);
}

}  // namespace plumb
