// SPDX-License-Identifier: MIT
// Series after a reduction of the argument. Fractions are 128 bits below the point; each product cuts off less than one unit, so a result of
// some twenty products is good to about 2^-122.
#include "pipeline/fingerprint/functions.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace plumb {

namespace {

// 2/pi, 32 bits a word, the first of weight 2^-1; tests/unit/fingerprint_exact_test.cpp computes them again.
constexpr std::array<uint32_t, 13> kTwoOverPi = {0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041, 0xfe5163ab,
                                                 0xdebbc561, 0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c};

// floor(2^128 a / b) for a < b.
Wide ratio(Wide a, Wide b) {
    Wide quotient = 0;
    for (int bit = 0; bit < 128; ++bit) {
        const bool carry = a >> 127 != 0;
        a <<= 1;
        quotient <<= 1;
        if (carry || a >= b) a -= b, quotient |= 1;
    }
    return quotient;
}

// atanh(s) = s + s^3/3 + s^5/5 + ..., or atan(s) with changing signs; s below 1/2.
Wide inverseTangent(Wide s, bool hyperbolic) {
    const Wide square = highProduct(s, s);
    Wide sum = s, power = s;
    bool subtract = !hyperbolic;
    for (uint32_t n = 3; (power = highProduct(power, square)) != 0; n += 2, subtract = !hyperbolic && !subtract)
        sum = subtract ? sum - power / n : sum + power / n;
    return sum;
}

constexpr int kPowers = 32;        // parts of [0, 1) with a power of two each
constexpr int kReciprocals = 128;  // parts of [1, 2) with a reciprocal each
constexpr size_t kTerms = 40;

struct Tables {
    Wide ln2, log2e;                                   // log2 e less 1
    Wide quarterPi;                                    // pi / 4
    std::array<Wide, kTerms> factorials{};             // 1 / n!; those of 0 and 1 are not used
    std::array<Wide, kTerms> inverses{};               // 1 / n, from 2 on
    std::array<Wide, kPowers> powers{};                // 2^(i/32) / 2
    std::array<uint32_t, kReciprocals> reciprocals{};  // 65536 / (1 + i/128), rounded up
    std::array<Wide, kReciprocals> logarithms{};       // log2 of 65536 / reciprocals[i]

    // e^t - 1 for t below 1, by `terms` terms.
    Wide growth(Wide t, size_t terms) const {
        Wide sum = 0;
        for (size_t n = terms; n >= 2; --n) sum = highProduct(factorials[n] + sum, t);
        return t + highProduct(t, sum);
    }
    Wide timesLog2e(Wide x) const { return x + highProduct(x, log2e); }

    Tables() {
        const Wide one = ~Wide(0);
        ln2 = 2 * inverseTangent(ratio(1, 3), true);
        log2e = ratio(Wide(0) - ln2, ln2);
        quarterPi = 4 * inverseTangent(ratio(1, 5), false) - inverseTangent(ratio(1, 239), false);
        Wide factorial = one / 2;
        for (size_t n = 2; n < kTerms; ++n) {
            inverses[n] = one / n;
            if (n > 2) factorial /= n;
            factorials[n] = factorial;
        }
        for (int i = 0; i < kPowers; ++i) {
            const Wide t = ln2 / kPowers * Wide(i);
            const Wide grown = growth(t, 38);  // below 1, since 2^(31/32) is below 2
            powers[size_t(i)] = (Wide(1) << 127) + grown / 2;
        }
        for (uint32_t i = 0; i < kReciprocals; ++i) {
            const uint32_t r = ((1u << 23) + 127u + i) / (128u + i);
            reciprocals[i] = r;
            logarithms[i] = r == 65536 ? 0 : timesLog2e(2 * inverseTangent(ratio(65536 - r, 65536 + r), true));
        }
    }
};

const Tables& tables() {
    static const Tables kTables;
    return kTables;
}

// whole + fraction / 2^128.
struct Fixed {
    int64_t whole = 0;
    Wide fraction = 0;
    bool inexact = false;
};

// (whole + fraction / 2^128) m 2^e, with a sign; beyond 2^20 it is 2^20.
Fixed scaled(uint64_t whole, Wide fraction, uint32_t m, int e, bool negative) {
    std::array<uint64_t, 5> limbs{};  // lowest first; the point stands above the first two
    const uint64_t in[3] = {uint64_t(fraction), uint64_t(fraction >> 64), whole};
    Wide carry = 0;
    for (size_t i = 0; i < 3; ++i) {
        carry += Wide(in[i]) * m;
        limbs[i] = uint64_t(carry);
        carry >>= 64;
    }
    limbs[3] = uint64_t(carry);
    Fixed result;
    constexpr int64_t kMost = 1 << 20;
    const auto large = [&] { return Fixed{negative ? -kMost : kMost, 0, true}; };
    for (; e > 0; --e) {
        if (limbs[3] != 0 || limbs[2] >= uint64_t(kMost)) return large();
        for (size_t i = 4; i-- > 1;) limbs[i] = limbs[i] << 1 | limbs[i - 1] >> 63;
        limbs[0] <<= 1;
    }
    while (e < 0) {
        const int step = std::min(-e, 63);
        result.inexact = result.inexact || (limbs[0] & ((uint64_t(1) << step) - 1)) != 0;
        for (size_t i = 0; i < 4; ++i) limbs[i] = limbs[i] >> step | (i < 3 ? limbs[i + 1] << (64 - step) : 0);
        e += step;
    }
    if (limbs[3] != 0 || limbs[2] >= uint64_t(kMost)) return large();
    result.whole = int64_t(limbs[2]);
    result.fraction = Wide(limbs[1]) << 64 | limbs[0];
    if (negative) {
        // What was cut off makes the negative number smaller still: one unit.
        const bool rest = result.fraction != 0 || result.inexact;
        result.whole = -result.whole - (rest ? 1 : 0);
        result.fraction = Wide(0) - result.fraction - (result.inexact ? 1 : 0);
    }
    return result;
}

// Parts of a finite float32 other than 0: m 2^e, m of 24 bits.
struct Parts {
    bool negative;
    uint32_t m;
    int e;
};
Parts partsOf(const Exact& x) { return {x.negative, uint32_t(x.mantissa >> 104), x.exponent + 104}; }

Exact powerOfTwo(const Fixed& x) {
    if (x.whole >= 4096) return Exact::infinite(false);
    const Tables& t = tables();
    const size_t part = size_t(x.fraction >> 123);
    const Wide rest = x.fraction & ((Wide(1) << 123) - 1);
    const Wide grown = t.growth(highProduct(rest, t.ln2), 18);
    const Wide power = t.powers[part];
    const bool inexact = x.fraction != 0 || x.inexact;
    return Exact::finite(false, power + highProduct(power, grown), int(std::max<int64_t>(x.whole, -4096)) - 127, inexact);
}

// log2 of a positive finite number, as whole and fraction.
Fixed logarithm(const Exact& x) {
    const Tables& t = tables();
    const uint32_t m = uint32_t(x.mantissa >> 104);  // [2^23, 2^24)
    const size_t part = (m >> 16) & 127u;
    const uint64_t product = uint64_t(m) * t.reciprocals[part];  // (1 + z) 2^39
    const Wide z = Wide(product - (uint64_t(1) << 39)) << 89;
    Wide sum = 0;  // z/2 - z^2/3 + ..., from the end
    for (size_t n = 20; n >= 2; --n) sum = highProduct(t.inverses[n] - sum, z);
    const Wide natural = z - highProduct(z, sum);
    return {x.topExponent(), t.logarithms[part] + t.timesLog2e(natural), m != 0x800000u};
}

Exact exactOfFixed(const Fixed& x) {
    const bool negative = x.whole < 0;
    uint64_t whole = uint64_t(x.whole);
    Wide fraction = x.fraction;
    if (negative) {
        whole = uint64_t(-x.whole) - (fraction != 0 ? 1 : 0);
        fraction = Wide(0) - fraction;
    }
    if (whole == 0) return Exact::finite(negative, fraction, -128, x.inexact);
    const int up = leadingZeros(Wide(whole));
    const Wide mantissa = Wide(whole) << up | (up == 0 ? 0 : fraction >> (128 - up));
    return Exact::finite(negative, mantissa, -up, x.inexact);
}

// Position of |x| on the circle: x = quadrant pi/2 + angle, |angle| at most pi/4 and a little.
struct Angle {
    uint32_t quadrant = 0;
    Exact angle;
};

Angle reduced(const Exact& x) {
    if (x.topExponent() < -1 || (x.topExponent() == -1 && uint32_t(x.mantissa >> 104) <= 0xc90fdau)) return {0, x};  // below pi/4
    const auto [negative, m, e] = partsOf(x);
    // 256 bits of 2/pi, from the first whose product with x is below 4.
    const int first = std::max(0, e - 2);
    std::array<uint64_t, 5> limbs{};
    Wide carry = 0;
    for (int i = 0; i < 4; ++i) {
        uint64_t bits = 0;  // bits first + 64 (3 - i) and the 63 after it
        for (int k = 0; k < 64; k += 32) {
            const int at = first + 64 * (3 - i) + k;
            const uint64_t two = uint64_t(kTwoOverPi[size_t(at / 32)]) << 32 |
                                 (size_t(at / 32) + 1 < kTwoOverPi.size() ? kTwoOverPi[size_t(at / 32) + 1] : 0);
            bits = bits << 32 | uint32_t(two >> (32 - at % 32));
        }
        carry += Wide(bits) * m;
        limbs[size_t(i)] = uint64_t(carry);
        carry >>= 64;
    }
    limbs[4] = uint64_t(carry);
    if (const int down = 2 - std::min(e, 2); down > 0)
        for (size_t i = 0; i < 5; ++i) limbs[i] = limbs[i] >> down | (i < 4 ? limbs[i + 1] << (64 - down) : 0);
    // Two bits of quadrant, then the fraction.
    uint32_t quadrant = uint32_t(limbs[3] >> 62);
    Wide high = (Wide(limbs[3]) << 64 | limbs[2]) << 2 | limbs[1] >> 62, low = (Wide(limbs[1]) << 64 | limbs[0]) << 2;
    const bool back = high >> 127 != 0;
    if (back) {
        high = ~high;
        low = Wide(0) - low;
        if (low == 0) ++high;
        quadrant = (quadrant + 1) & 3u;
    }
    const int up = high == 0 ? 127 : leadingZeros(high);
    const Wide fraction = up == 0 ? high : high << up | low >> (128 - up);
    Exact angle = Exact::finite(back, highProduct(fraction, tables().quarterPi), -127 - up, true);
    if (negative) {
        angle.negative = !angle.negative;
        quadrant = (4 - quadrant) & 3u;
    }
    return {quadrant, angle};
}

// Square of |angle| as a fraction.
Wide squareOf(const Exact& angle) {
    const Wide square = highProduct(angle.mantissa, angle.mantissa);
    const int down = -2 * angle.exponent - 256;
    return down >= 128 ? 0 : square >> down;
}

Exact sineNear0(const Exact& angle) {
    const Tables& t = tables();
    const Wide square = squareOf(angle);
    Wide sum = 0;  // square/3! - square^2/5! + ...
    for (size_t n = 35; n >= 3; n -= 2) sum = highProduct(t.factorials[n] - sum, square);
    const Wide less = highProduct(angle.mantissa, sum);
    return Exact::finite(angle.negative, angle.mantissa - less - (less == 0 ? 1 : 0), angle.exponent, true);
}

Exact cosineNear0(const Exact& angle) {
    const Tables& t = tables();
    const Wide square = squareOf(angle);
    Wide sum = 0;
    for (size_t n = 36; n >= 2; n -= 2) sum = highProduct(t.factorials[n] - sum, square);
    return Exact::finite(false, Wide(0) - std::max<Wide>(sum, 1), -128, true);
}

Exact wave(uint32_t bits, uint32_t ahead) {
    const Exact x = exactOf(bits);
    if (x.kind == Exact::Kind::zero) return ahead == 0 ? x : Exact::finite(false, 1, 0);
    if (!x.isFinite()) return Exact::nan();
    const Angle position = reduced(x);
    const uint32_t quadrant = (position.quadrant + ahead) & 3u;
    const Exact value = (quadrant & 1u) == 0 ? sineNear0(position.angle) : cosineNear0(position.angle);
    return quadrant >= 2 ? negated(value) : value;
}

}  // namespace

Exact exp2Of(uint32_t bits) {
    const Exact x = exactOf(bits);
    if (x.kind == Exact::Kind::nan) return x;
    if (x.kind == Exact::Kind::infinite) return x.negative ? Exact::zero(false) : x;
    if (!x.isFinite()) return Exact::finite(false, 1, 0);
    const auto [negative, m, e] = partsOf(x);
    return powerOfTwo(scaled(1, 0, m, e, negative));
}

Exact expOf(uint32_t bits) {
    const Exact x = exactOf(bits);
    if (x.kind == Exact::Kind::nan) return x;
    if (x.kind == Exact::Kind::infinite) return x.negative ? Exact::zero(false) : x;
    if (!x.isFinite()) return Exact::finite(false, 1, 0);
    const auto [negative, m, e] = partsOf(x);
    Fixed power = scaled(1, tables().log2e, m, e, negative);
    power.inexact = true;
    return powerOfTwo(power);
}

Exact log2Of(uint32_t bits) {
    const Exact x = exactOf(bits);
    if (x.kind == Exact::Kind::zero) return Exact::infinite(true);
    if (x.kind == Exact::Kind::nan || x.negative) return Exact::nan();
    if (x.kind == Exact::Kind::infinite) return x;
    return exactOfFixed(logarithm(x));
}

Exact logOf(uint32_t bits) {
    Exact two = log2Of(bits);
    if (!two.isFinite()) return two;
    return Exact::finite(two.negative, highProduct(two.mantissa, tables().ln2), two.exponent, true);
}

Exact powOf(uint32_t xBits, uint32_t yBits) {
    const Exact x = exactOf(xBits), y = exactOf(yBits);
    if (!x.isFinite() || x.negative) return Exact::nan();
    if (!y.isFinite()) return y.kind == Exact::Kind::zero ? Exact::finite(false, 1, 0) : Exact::nan();
    const Fixed log = logarithm(x);
    const auto [negative, m, e] = partsOf(y);
    const bool below = log.whole < 0;
    const uint64_t whole = below ? uint64_t(-log.whole) - (log.fraction != 0 ? 1 : 0) : uint64_t(log.whole);
    Fixed power = scaled(whole, below ? Wide(0) - log.fraction : log.fraction, m, e, negative != below);
    power.inexact = power.inexact || log.inexact;
    Exact result = powerOfTwo(power);
    // x^y may be a number of few bits: 9^0.5. Nothing else comes so near to one.
    if (result.isFinite() && log.inexact) {
        const Wide kept = (result.mantissa + (Wide(1) << 47)) >> 48 << 48;
        const Wide apart = kept > result.mantissa ? kept - result.mantissa : result.mantissa - kept;
        if (kept != 0 && apart < (Wide(1) << 40)) result.mantissa = kept, result.inexact = false;
    }
    return result;
}

Exact sinOf(uint32_t x) { return wave(x, 0); }
Exact cosOf(uint32_t x) { return wave(x, 1); }

}  // namespace plumb
