// SPDX-License-Identifier: MIT
// Contract of the transforms that are more accurate than float32 (--trade transform=): a point times a row of the composite matrix, rounded
// to float32 once, at the end. In block-scaled integers (one exponent a row, one an object) everything before that rounding is exact, on
// every device. In binary64 each step rounds to nearest even (host/selftest.h tests the device for it). Later passes read the results as
// they read those of transform.h.
#ifndef PLUMB_LONG_TRANSFORM_H
#define PLUMB_LONG_TRANSFORM_H
#include "transform.h"
SHARED_BEGIN

// Integer high 2^32 + low, two's complement.
struct Word64 {
    int high;
    uint low;
};

// Row of a matrix in both number formats. Integers: (m.x X + m.y Y + m.z Z + last) 2^exponent for the point (X, Y, Z), |m| and |X| at most
// 2^30, |last| at most 2^61. Binary64: two numbers a vector, the low word of each first.
struct LongRow {
    ivec3 m;
    int exponent;
    Word64 last;
    uvec4 double01, double23;
};

// Record of one object, beside its ObjectRecord.
struct LongRecord {
    LongRow x, y, w;
    float scale;  // a power of two: X = x scale, rounded half to even
};

SHARED_FN Word64 sumOfWords(Word64 a, Word64 b) {
    Word64 sum;
    sum.low = a.low + b.low;
    sum.high = int(uint(a.high) + uint(b.high) + pick(sum.low < a.low, 1u, 0u));
    return sum;
}
SHARED_FN Word64 negatedWord(Word64 a) {
    Word64 negated;
    negated.low = ~a.low + 1u;
    negated.high = int(~uint(a.high) + pick(negated.low == 0u, 1u, 0u));
    return negated;
}
SHARED_FN Word64 productOfInts(int a, int b) {
    Word64 product;
    multiplyLong(a, b, product.high, product.low);
    return product;
}

// Nearest float32 to value 2^exponent, half to even; 0 where that would be subnormal. |value| < 2^63; the result must be finite.
SHARED_FN float realOfWord(Word64 value, int exponent) {
    bool negative = value.high < 0;
    Word64 magnitude = value;
    if (negative) magnitude = negatedWord(value);
    uint high = uint(magnitude.high);
    uint low = magnitude.low;
    int topBit = 63;  // that of the highest bit of `high`
    if (high == 0u) {
        high = low;
        low = 0u;
        topBit = 31;
    }
    int shift = 31 - highestBit(max(high, 1u));  // no plant: what comes of 0 is not read
    if (shift > 0) {
        high = (high << uint(shift)) | (low >> uint(32 - shift));
        low = low << uint(shift);
    }
    uint mantissa = high >> 8u;
    uint rest = high & 255u;
    bool up = rest > 128u || (rest == 128u && (low != 0u || (mantissa & 1u) != 0u));
    int field = topBit - shift + exponent + 127;
    // A carry out of the mantissa is one more in the exponent.
    // no plant: what comes of a field below 1 is not read
    int bits = (max(field, 1) << 23) + int(mantissa) - 8388608 + pick(up, 1, 0);
    return realOf(pick(high == 0u || field < 1, 0, pick(negative, bits | int(0x80000000u), bits)));
}

SHARED_FN float rowTimesBlock(LongRow row, ivec3 p) {
    Word64 sum = sumOfWords(productOfInts(row.m.x, p.x), productOfInts(row.m.y, p.y));
    return realOfWord(sumOfWords(sum, sumOfWords(productOfInts(row.m.z, p.z), row.last)), row.exponent);
}

SHARED_FN ivec3 blockPoint(vec3 p, float scale) {
    return ivec3(toInt(roundEvenReal(p.x * scale)), toInt(roundEvenReal(p.y * scale)), toInt(roundEvenReal(p.z * scale)));
}

// Clip-space x, y and w of a point. P (2^-96 to 2^126): the largest |coordinate| of the object. M: the largest |m_i| of a row. Half a unit
// of X is at most 2^-30 P. Half a unit of m is at most 2^-30 M or, where m_3 asks for larger units, 2^-31 |m_3| / P. So a result r is off
// by at most
//     u |r| + 6 2^-30 M P (1 + 2^-30) + 2^-29 |m_3|,     and in binary64 by  u |r| + 2^-103 + 4.01 2^-53 (sum |m_i p_i| + |m_3|).
// float32 may be off by 4.01 u (sum |m_i p_i| + |m_3|), and by half an ULP of each m_i besides.
SHARED_FN vec3 blockClip(LongRecord o, vec3 p) {
    ivec3 q = blockPoint(p, o.scale);
    return vec3(rowTimesBlock(o.x, q), rowTimesBlock(o.y, q), rowTimesBlock(o.w, q));
}
SHARED_FN vec3 doubleClip(LongRecord o, vec3 p) {
    return vec3(snapTiny(rowTimesDouble(o.x.double01, o.x.double23, p)), snapTiny(rowTimesDouble(o.y.double01, o.y.double23, p)),
                snapTiny(rowTimesDouble(o.w.double01, o.w.double23, p)));
}

SHARED_END
#endif
