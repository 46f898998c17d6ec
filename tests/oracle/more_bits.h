// SPDX-License-Identifier: MIT
// Numbers with more bits than binary64 for witnesses: the 64 of x87, and the 113 of binary128 with functions of its own. It shares no code with the
// truth.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb::oracle {

using Long = long double;
__extension__ typedef __float128 Wide;  // NOLINT(modernize-use-using): the keyword is the compiler's own

template <class N>
inline constexpr double kRoundOff = 0x1p-64;
template <>
inline constexpr double kRoundOff<Wide> = 0x1p-113;

template <class N>
N magnitude(N x) {
    return x < 0 ? -x : x;
}
inline Long squareRoot(Long x) { return std::sqrt(x); }
inline Wide squareRoot(Wide x) {
    if (!(x > 0)) return 0;
    Wide y = std::sqrt(Long(x));
    for (int i = 0; i < 2; ++i) y = (y + x / y) / 2;
    return y;
}
// Largest whole number not above |x|, for |x| < 2^63.
template <class N>
N wholeOf(N x) {
    return N(int64_t(magnitude(x)));
}

// ln((1 + s) / (1 - s)) by its series; |s| <= 1/3.
inline Wide logOfRatio(Wide s) {
    const Wide square = s * s;
    Wide power = s, sum = 0;
    for (int k = 1; k < 80; k += 2, power *= square) sum += power / k;
    return 2 * sum;
}
inline Wide logTwo() {
    static const Wide kValue = logOfRatio(Wide(1) / 3);
    return kValue;
}
inline Wide logarithm(Wide x) {
    int exponent = std::ilogb(Long(x));
    Wide m = x;
    for (int left = exponent; left != 0;) {  // steps that binary64 holds
        const int step = left > 1000 ? 1000 : left < -1000 ? -1000 : left;
        m *= Wide(std::ldexp(1.0, -step));
        left -= step;
    }
    if (m > Wide(1.5)) m /= 2, ++exponent;
    return logOfRatio((m - 1) / (m + 1)) + exponent * logTwo();
}
// e^y for y <= 0; 0 below 2^-4000.
inline Wide exponential(Wide y) {
    if (y < -2770) return 0;
    const int whole = int(double(y / logTwo()) - 0.5);
    const Wide r = y - whole * logTwo();
    Wide term = 1, sum = 1;
    for (int k = 1; k < 40; ++k) term *= r / k, sum += term;
    for (int left = whole; left != 0;) {
        const int step = left < -1000 ? -1000 : left;
        sum *= Wide(std::ldexp(1.0, step));
        left -= step;
    }
    return sum;
}

inline Long power(Long x, Long n) { return n == 0 ? 1 : x > 0 ? std::pow(x, n) : 0; }
inline Wide power(Wide x, Wide n) {
    if (n == 0) return 1;
    if (!(x > 0)) return 0;
    if (n == wholeOf(n) && n < 0x1p21) {
        Wide result = 1;
        for (auto left = uint32_t(n); left != 0; left >>= 1, x *= x)
            if (left & 1) result *= x;
        return result;
    }
    return exponential(n * logarithm(x));
}

template <class N>
struct Triple {
    N x = 0, y = 0, z = 0;
    Triple() = default;
    Triple(N a, N b, N c) : x(a), y(b), z(c) {}
    explicit Triple(const glm::dvec3& v) : x(v.x), y(v.y), z(v.z) {}
    explicit Triple(const glm::vec3& v) : x(v.x), y(v.y), z(v.z) {}
    friend Triple operator+(const Triple& a, const Triple& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Triple operator-(const Triple& a, const Triple& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Triple operator*(N s, const Triple& a) { return {s * a.x, s * a.y, s * a.z}; }
    friend Triple operator*(const Triple& a, const Triple& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
    N dot(const Triple& b) const { return x * b.x + y * b.y + z * b.z; }
    Triple cross(const Triple& b) const { return {y * b.z - z * b.y, z * b.x - x * b.z, x * b.y - y * b.x}; }
    N length() const { return squareRoot(dot(*this)); }
    // 0 for the zero vector.
    Triple unit() const {
        const N l = length();
        return l > 0 ? (1 / l) * *this : Triple();
    }
    N size() const { return magnitude(x) + magnitude(y) + magnitude(z); }
    N at(int i) const { return i == 0 ? x : i == 1 ? y : z; }
};

// Code of the curve of IEC 61966-2-1, 0 to 255, not rounded; its constants are the decimal numbers of the standard.
template <class N>
N codeOf(N linear) {
    const N x = linear < 0 ? N(0) : linear > 1 ? N(1) : linear;
    if (x <= N(31308) / 10000000) return 255 * (N(1292) / 100 * x);
    return 255 * (N(1055) / 1000 * power(x, N(5) / 12) - N(55) / 1000);
}

}  // namespace plumb::oracle
