#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Results of powers, logarithms, sine and cosine, correctly rounded to float32, by Python's own integers with 400 bits below the point: series without any
table, and pi by Machin's formula. Searches for arguments whose result lies near the middle of two float32.

usage: fingerprint_witness.py > tests/unit/fingerprint_hard_cases.inc    the rows of fingerprint_exact_test.cpp
"""
import random
import struct
import sys
from fractions import Fraction

BITS = 400
ONE = 1 << BITS


def value(bits):
    return Fraction(*struct.unpack("<f", struct.pack("<I", bits))[0].as_integer_ratio())


def bits_of(x):
    return struct.unpack("<I", struct.pack("<f", x))[0]


def fixed(x):
    return (x.numerator << BITS) // x.denominator


def atan_inverse(n):
    total, term, k, sign = 0, ONE // n, 1, 1
    while term:
        total += sign * (term // k)
        term //= n * n
        k, sign = k + 2, -sign
    return total


PI = 4 * (4 * atan_inverse(5) - atan_inverse(239))


def exp_fixed(t):
    """e^t of a fixed number, t below 400 in size."""
    halves = 0
    while abs(t) > ONE >> 4:
        t, halves = t >> 1, halves + 1
    total, term, k = ONE, ONE, 1
    while term:
        term = term * t // ONE // k if t >= 0 else -((term * -t // ONE) // k)
        total += term
        k += 1
        if k > 400:
            break
    for _ in range(halves):
        total = total * total // ONE
    return total


def log_fixed(x):
    """ln x of a Fraction: atanh of the reduced number, and ln 2."""
    e = 0
    while x >= 2:
        x, e = x / 2, e + 1
    while x < 1:
        x, e = x * 2, e - 1

    def atanh(s):
        s = fixed(s)
        total, power, k, square = 0, s, 1, s * s // ONE
        while power:
            total += power // k
            power = power * square // ONE
            k += 2
        return total

    return 2 * atanh((x - 1) / (x + 1)) + e * LN2


def atanh_third():
    total, term, k = 0, ONE // 3, 1
    while term:
        total += term // k
        term //= 9
        k += 2
    return total


LN2 = 2 * atanh_third()


def sine_fixed(x, ahead):
    wide = (x.numerator << BITS) // x.denominator
    half = PI // 2
    turns = (wide + half // 2) // half
    # PI has about 390 good bits; an angle of 2^128 takes 128 of them.
    r = wide - turns * half
    q = (turns + ahead) % 4
    square = r * r // ONE
    total, term, k = 0, (r if q % 2 == 0 else ONE), (1 if q % 2 == 0 else 0)
    while term:
        total += term
        term = -(term * square // ONE) // ((k + 1) * (k + 2)) if term > 0 else (-term * square // ONE) // ((k + 1) * (k + 2))
        k += 2
    return -total if q >= 2 else total


def rounded(fixed_value):
    """(bits of the nearest float32, how near the middle of two it lies: 0 is the middle)."""
    sign = 0x80000000 if fixed_value < 0 else 0
    n = abs(fixed_value)
    e = n.bit_length() - 1 - BITS
    shift = max(e, -126) - 23 + BITS
    units, rest = n >> shift, n & ((1 << shift) - 1)
    half = 1 << (shift - 1)
    up = rest > half or (rest == half and units & 1)
    word = (max(0, e + 126) << 23) + units + (1 if up else 0)
    return sign | min(word, 0x7F800000), abs(rest - half) / float(1 << shift) if shift < 1000 else abs(Fraction(rest - half, 1 << shift))


def result(name, x, y):
    v = value(x)
    if name == "exp2":
        return exp_fixed(fixed(v) * LN2 // ONE)
    if name == "exp":
        return exp_fixed(fixed(v))
    if name == "log":
        return log_fixed(v)
    if name == "log2":
        return log_fixed(v) * ONE // LN2
    if name == "sin":
        return sine_fixed(v, 0)
    if name == "cos":
        return sine_fixed(v, 1)
    if name == "pow":
        w = value(y)
        return exp_fixed(log_fixed(v) * w.numerator // w.denominator)
    raise ValueError(name)


def draw(random_, name):
    exponent, sign = 127, random_.getrandbits(1) << 31
    if name in ("exp2", "exp"):
        exponent = 127 + random_.randint(-12, 6 if name == "exp2" else 5)
    elif name in ("log2", "log"):
        exponent, sign = random_.choice([126, 127, random_.randint(1, 254)]), 0
    elif name in ("sin", "cos"):
        exponent = random_.choice([random_.randint(100, 128), random_.randint(127, 254)])
    elif name == "pow":
        exponent, sign = 127 + random_.randint(-4, 4), 0
    return sign | exponent << 23 | random_.getrandbits(23)


def main():
    random_ = random.Random(22695477)
    for name, tries in (("exp2", 1500), ("exp", 1500), ("log2", 1200), ("log", 1200), ("sin", 1500), ("cos", 1500), ("pow", 1200)):
        rows = []
        for _ in range(tries):
            x = draw(random_, name)
            y = (random_.getrandbits(1) << 31 | (127 + random_.randint(-3, 3)) << 23 | random_.getrandbits(23)) if name == "pow" else 0
            word, near = rounded(result(name, x, y))
            if 0 < word & 0x7FFFFFFF < 0x7F800000:
                rows.append((near, x, y, word))
        rows.sort()
        for _, x, y, word in rows[:50] + rows[-5:]:
            print(f'    {{"{name}", 0x{x:08x}u, 0x{y:08x}u, 0x{word:08x}u}},')


if __name__ == "__main__":
    sys.exit(main())
