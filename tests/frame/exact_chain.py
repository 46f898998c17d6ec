#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Recomputes the chain that `plumb pixel --json` prints, line by line, with exact fractions: the witness of what it prints.

A line's `how` is an expression in names of lines before it. Each +, -, *, / is done exactly and rounded once to float32, to nearest, ties to even.
Inside exact(...) nothing is rounded; its result is rounded where a float32 operation takes it, and kept where it is the line's value. The functions
are those of docs/accuracy.md (rsqrt, inverse, power) and IEC 61966-2-1 (srgb). Shares no code with the product.
"""
import ast
import math
from decimal import Decimal, getcontext
from fractions import Fraction

getcontext().prec = 60
LEAST = -149  # exponent of the least float32


def rounded(x):
    """Nearest float32 of a fraction, ties to even."""
    if x == 0:
        return x
    a = abs(x)
    e = a.numerator.bit_length() - a.denominator.bit_length()
    if Fraction(2) ** e > a:
        e -= 1
    step = max(e - 23, LEAST)
    scale = Fraction(2) ** -step
    n = a * scale
    whole = n.numerator // n.denominator
    rest = n - whole
    if rest > Fraction(1, 2) or (rest == Fraction(1, 2) and whole & 1):
        whole += 1
    value = Fraction(whole) / scale
    return value if x > 0 else -value


def bits_of(x):
    """Bits of a float32 >= 0."""
    if x == 0:
        return 0
    e = x.numerator.bit_length() - x.denominator.bit_length()
    if Fraction(2) ** e > x:
        e -= 1
    if e < -126:
        return int(x * Fraction(2) ** 149)
    return (e + 127 << 23) + int((x / Fraction(2) ** e - 1) * 2 ** 23)


def real_of(bits):
    e, m = bits >> 23 & 255, bits & 0x7fffff
    return Fraction(m) * Fraction(2) ** -149 if e == 0 else (1 + Fraction(m, 2 ** 23)) * Fraction(2) ** (e - 127)


def number(text):
    """Float32 that a decimal of the contracts means."""
    return rounded(Fraction(text))


def add(a, b):
    return rounded(a + b)


def mul(a, b):
    return rounded(a * b)


def rsqrt(x):
    y = real_of(0x5f375a86 - (bits_of(x) >> 1))
    h = mul(x, Fraction(-1, 2))
    for _ in range(3):
        y = mul(y, add(mul(mul(h, y), y), Fraction(3, 2)))
    return y


def inverse(x):
    y = rsqrt(x)
    return mul(y, y)


LOG2 = [number(c) for c in ("-0.145807055", "0.234040521", "-0.248877417", "0.287098915", "-0.36023962", "0.480923236", "-0.721352788", "1.44269496")]
EXP2 = [number(c) for c in ("0.00132764727", "0.00967554133", "0.0555071327", "0.240221197", "0.693146967", "1")]


def power(q, n, cosine):
    """(R.V)^n from R - V, by docs/illumination.md."""
    if cosine <= 0:
        return Fraction(0)
    delta = mul(add(add(mul(q[0], q[0]), mul(q[1], q[1])), mul(q[2], q[2])), Fraction(1, 2))
    if delta >= 1:
        return Fraction(1 if n == 0 else 0)
    u = max(add(Fraction(1), -delta), Fraction(1, 2 ** 20))
    bits = bits_of(u)
    e = bits - 0x3f3504f3 >> 23
    m = real_of(bits - (e << 23))
    x = -delta if e == 0 else add(m, Fraction(-1))
    y = LOG2[0]
    for c in LOG2[1:]:
        y = add(mul(y, x), c)
    p = max(mul(n, add(Fraction(e), mul(y, x))), Fraction(-120))
    k = Fraction(math.floor(add(p, Fraction(1, 2))))
    r = add(p, -k)
    v = EXP2[0]
    for c in EXP2[1:]:
        v = add(mul(v, r), c)
    return real_of(bits_of(v) + (int(k) << 23))


def root(x):
    """Square root, correctly rounded: the nearest float32 of a root in 60 digits."""
    if x == 0:
        return x
    return rounded(Fraction((Decimal(x.numerator) / Decimal(x.denominator)).sqrt()))


def half_even(x):
    n = math.floor(x)
    rest = x - n
    return n + (1 if rest > Fraction(1, 2) or (rest == Fraction(1, 2) and n & 1) else 0)


def snap(pixels, steps):
    """Nearest multiple of 1/steps pixel, ties to even."""
    return Fraction(half_even(pixels * steps)) / steps


def srgb(linear):
    """Nearest code, from the exact curve."""
    x = min(max(linear, Fraction(0)), Fraction(1))
    d = Decimal(x.numerator) / Decimal(x.denominator)
    code = d * Decimal("12.92") if d <= Decimal("0.0031308") else Decimal("1.055") * (d.ln() / Decimal("2.4")).exp() - Decimal("0.055")
    return Fraction(half_even(Fraction(code * 255)))


def round255(linear):
    return Fraction(half_even(rounded(min(max(linear, Fraction(0)), Fraction(1)) * 255)))


class Chain:
    def __init__(self, lines):
        self.values = {}
        self.checked = 0
        self.lines = lines

    def evaluate(self, node, exact):
        if isinstance(node, ast.Expression):
            return self.evaluate(node.body, exact)
        if isinstance(node, ast.Constant):
            return Fraction(node.value)
        if isinstance(node, ast.Tuple):
            return tuple(self.evaluate(e, exact) for e in node.elts)
        if isinstance(node, ast.UnaryOp):
            return -self.evaluate(node.operand, exact)
        if isinstance(node, ast.Subscript):
            return self.values[node.value.id][node.slice.value if isinstance(node.slice, ast.Constant) else node.slice.value.value]
        if isinstance(node, ast.BinOp):
            a, b = self.evaluate(node.left, exact), self.evaluate(node.right, exact)
            if not exact:
                a, b = rounded(a), rounded(b)
            v = {ast.Add: lambda: a + b, ast.Sub: lambda: a - b, ast.Mult: lambda: a * b, ast.Div: lambda: a / b, ast.Mod: lambda: a - b * math.floor(a / b)}[type(node.op)]()
            return v if exact else rounded(v)
        name = node.func.id
        if name == "exact":
            return self.evaluate(node.args[0], True)
        a = [self.evaluate(x, exact) for x in node.args]
        return {"rsqrt": lambda: rsqrt(a[0]), "inverse": lambda: inverse(a[0]), "power": lambda: power(*a), "root": lambda: root(a[0]), "snap": lambda: snap(*a),
                "srgb": lambda: srgb(a[0]), "round255": lambda: round255(a[0]), "floor": lambda: Fraction(math.floor(a[0])), "min": lambda: min(a), "max": lambda: max(a),
                "clamp": lambda: min(max(a[0], a[1]), a[2]), "max0": lambda: max(a[0], Fraction(0)), "lit": lambda: a[1] if a[0] > 0 else Fraction(0),
                "mean": lambda: self.mean(a)}[name]()

    @staticmethod
    def mean(samples):
        total = samples[0]
        for s in samples[1:]:
            total = add(total, s)
        return mul(total, Fraction(1, len(samples)))

    def run(self):
        """Faults: sentences on lines whose printed value is not what its expression gives. Each line is computed from what was computed, not from what was printed."""
        faults = []
        for line in self.lines:
            if line["twin"] is None:
                continue
            printed = [Fraction(v) if not isinstance(v, str) else None for v in line["twin"]]
            if "how" not in line:
                self.values[line["name"]] = printed
                continue
            got = []
            for how in line["how"]:
                got.append(self.evaluate(ast.parse(how, mode="eval"), False))
            self.values[line["name"]] = got
            self.checked += len(got)
            for i, (g, p) in enumerate(zip(got, printed)):
                if g != p:
                    faults.append(f"{line['name']}[{i}] = {line['how'][i]}: exact fractions give {float(g)!r}, printed {line['twin'][i]!r}")
            if len(got) != len(printed):
                faults.append(f"{line['name']}: {len(got)} expressions for {len(printed)} values")
        return faults


def faults_of(pixel):
    """Faults of one element of `pixels`, and how many values were recomputed."""
    faults, checked = [], 0
    total = None
    for lines in pixel["chains"]:
        chain = Chain(lines["lines"])
        faults += [f"pixel {pixel['pixel']}, {lines['title']}: {f}" for f in chain.run()]
        checked += chain.checked
        if "before" in chain.values:  # rays: each continues the colour of the one before
            if total is not None and chain.values["before"] != total:
                faults.append(f"pixel {pixel['pixel']}, {lines['title']}: it does not continue the colour of the ray before")
            total = chain.values["total"]
    return faults, checked
