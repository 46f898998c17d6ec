// SPDX-License-Identifier: MIT
// Real numbers to more than a hundred bits, in integers alone: no compiler, option or library of mathematics can change a result. What a
// device gives is held against them.
#pragma once

#include <cstdint>

namespace plumb {

__extension__ using Wide = unsigned __int128;

// Number: mantissa 2^exponent, with the top bit of the mantissa set. What lies below the mantissa is cut off; `inexact` says that something
// did, less than one unit of the mantissa's last bit.
struct Exact {
    enum class Kind : uint8_t { zero, finite, infinite, nan };
    Kind kind = Kind::zero;
    bool negative = false;
    bool inexact = false;
    int exponent = 0;
    Wide mantissa = 0;

    static Exact zero(bool negative) { return {Kind::zero, negative}; }
    static Exact infinite(bool negative) { return {Kind::infinite, negative}; }
    static Exact nan() { return {Kind::nan}; }
    // `mantissa` 2^`exponent` of any size; 0 with `inexact` counts as the smallest mantissa.
    static Exact finite(bool negative, Wide mantissa, int exponent, bool inexact = false);

    bool isFinite() const { return kind == Kind::finite; }
    int topExponent() const { return exponent + 127; }  // floor(log2 |x|)
};

Exact exactOf(uint32_t bits);  // number that a float32 is
Exact exactOfInteger(bool negative, uint64_t magnitude);
Exact negated(Exact);

// Exact as IEEE 754 has them before it rounds: + and the product of numbers with at most 64 bits each, quotient and root of float32. The sum
// of numbers with more than 126 bits between them is cut off.
Exact plus(const Exact&, const Exact&);
Exact times(const Exact&, const Exact&);
Exact over(const Exact&, const Exact&);
Exact rootOf(const Exact&);
Exact inverseRootOf(const Exact&);
// x - y floor(x / y) for finite x, y with |x / y| below 2^90.
Exact modulo(const Exact& x, const Exact& y);

// Nearest float32, ties to even. A NaN is 0x7fc00000.
uint32_t nearestFloat(const Exact&);
// True where the number lies in the middle of two float32.
bool isTie(const Exact&);
// Neighbour of a tie, or of any number between two float32: away from zero, or toward it.
uint32_t floatBeyond(const Exact&);
uint32_t floatWithin(const Exact&);

// Distances are counted in 1/65536 of a unit in the last place (ULP) of float32.
inline constexpr uint64_t kUlp = 65536;
inline constexpr uint64_t kMostUlps = uint64_t(1) << 60;  // as far as any two numbers: other sign of infinity, NaN
// Distance of the float32 `got` from `exact`, in ULP of `scale`: units of the binade that `scale` lies in, 2^-149 at least.
uint64_t distance(const Exact& exact, uint32_t got, const Exact& scale);
inline uint64_t distance(const Exact& exact, uint32_t got) { return distance(exact, got, exact); }
// 2^`power` in the same units.
uint64_t ulpsOfPower(int power, const Exact& scale);

int leadingZeros(Wide);
Wide highProduct(Wide, Wide);  // floor(a b / 2^128)

}  // namespace plumb
