// SPDX-License-Identifier: MIT
// Operations on float32 and their largest errors. Allowances: Vulkan 1.3, Precision and Operation of SPIR-V Instructions. Operands are
// normal, and so are results: what happens elsewhere is a trait of its own (traits_behaviour.cpp).
#include "pipeline/fingerprint/functions.h"
#include "pipeline/fingerprint/traits.h"
#include "shared/fingerprint.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace plumb::fingerprint {

namespace {

constexpr const char* kJudged = "none: the self-test refuses a device whose + - * are not rounded to nearest, and the twin draws";
constexpr const char* kUnused = "none: no pass has this operation";
constexpr uint32_t kPiBits = 0x40490fdbu;  // nearest float32 of pi, above it

bool atMost(uint32_t x, uint32_t most) { return (x & 0x7fffffffu) <= most; }
bool goodResult(const Exact& x) { return x.isFinite() && x.topExponent() >= -125 && x.topExponent() <= 126; }
double valueOf(uint32_t bits) { return double(std::bit_cast<float>(bits)); }

// First of the drawn questions that is good; the draw goes on, so there is one.
template <class Make, class Good>
Question drawn(const char* trait, uint32_t item, const Make& make, const Good& good) {
    Draw draw(trait, item);
    for (;;)
        if (const Question q = make(draw); good(q)) return q;
}

uint64_t oneUlp(const Question&, const Exact&) { return kUlp; }

Exact sum(const Question& q) { return plus(exactOf(q[0]), exactOf(q[1])); }
Exact difference(const Question& q) { return plus(exactOf(q[0]), negated(exactOf(q[1]))); }
Exact product(const Question& q) { return times(exactOf(q[0]), exactOf(q[1])); }
Exact quotient(const Question& q) { return over(exactOf(q[0]), exactOf(q[1])); }

Question sumQuestion(const char* trait, uint32_t item, Exact (*exact)(const Question&)) {
    return drawn(
        trait, item,
        [](Draw& d) {
            const uint32_t x = d.real(-70, 100);
            return Question{x, d.real(exponentOf(x) - 26, std::min(exponentOf(x) + 26, 120)), 0, 0};
        },
        [&](const Question& q) { return goodResult(exact(q)) && !isTie(exact(q)); });
}

void addSums(std::vector<Trait>& list) {
    const char* const rounded = "correctly rounded, in a direction that Vulkan leaves open: either neighbour";
    list.push_back({.name = "add",
                    .group = "float32",
                    .what = "x + y",
                    .allowance = rounded,
                    .planes = kJudged,
                    .operation = gpu::kAskAdd,
                    .operands = Operands::two,
                    .question = [](uint32_t i) { return sumQuestion("add", i, sum); },
                    .exact = sum,
                    .allowed = oneUlp});
    list.push_back({.name = "subtract",
                    .group = "float32",
                    .what = "x - y",
                    .allowance = rounded,
                    .planes = kJudged,
                    .operation = gpu::kAskSubtract,
                    .operands = Operands::two,
                    .question = [](uint32_t i) { return sumQuestion("subtract", i, difference); },
                    .exact = difference,
                    .allowed = oneUlp});
    const auto products = [](uint32_t i) {
        return drawn(
            "multiply", i,
            [](Draw& d) {
                return Question{d.real(-100, 100), d.real(-100, 100), 0, 0};
            },
            [](const Question& q) { return goodResult(product(q)); });
    };
    list.push_back({.name = "multiply",
                    .group = "float32",
                    .what = "x * y",
                    .allowance = rounded,
                    .planes = kJudged,
                    .operation = gpu::kAskMultiply,
                    .operands = Operands::two,
                    .question = products,
                    .exact = product,
                    .allowed = oneUlp});
    const auto quotients = [](uint32_t i) {
        return drawn(
            "divide", i,
            [](Draw& d) {
                return Question{d.real(-120, 120), d.real(-126, 125), 0, 0};
            },
            [](const Question& q) { return goodResult(quotient(q)); });
    };
    list.push_back({.name = "divide",
                    .group = "float32",
                    .what = "x / y",
                    .allowance = "2.5 ULP for |y| in [2^-126, 2^126]",
                    .planes = "none: where the self-test finds it inexact, integer arithmetic takes its error out (up to 7 ULP)",
                    .operation = gpu::kAskDivide,
                    .operands = Operands::two,
                    .question = quotients,
                    .exact = quotient,
                    .allowed = [](const Question&, const Exact&) { return 5 * kUlp / 2; }});
}

void addRoots(std::vector<Trait>& list) {
    const auto anywhere = [](const char* trait) {
        return [trait](uint32_t i) { return Question{Draw(trait, i).positive(-126, 127), 0, 0, 0}; };
    };
    list.push_back({.name = "sqrt",
                    .group = "float32",
                    .what = "square root",
                    .allowance = "as 1 / inversesqrt(x): 2 ULP of that, at most 4 of the root, and 2.5",
                    .planes = "none: where the self-test finds it inexact, integer arithmetic takes its error out (up to 7 ULP)",
                    .operation = gpu::kAskSqrt,
                    .question = anywhere("sqrt"),
                    .exact = [](const Question& q) { return rootOf(exactOf(q[0])); },
                    .allowed = [](const Question&, const Exact&) { return 13 * kUlp / 2; }});
    list.push_back({.name = "inversesqrt",
                    .group = "float32",
                    .what = "1 / square root",
                    .allowance = "2 ULP",
                    .planes = kUnused,
                    .operation = gpu::kAskInverseSqrt,
                    .question = anywhere("inversesqrt"),
                    .exact = [](const Question& q) { return inverseRootOf(exactOf(q[0])); },
                    .allowed = [](const Question&, const Exact&) { return 2 * kUlp; }});
}

// Exponents: half of them evenly over the range, half over the binades.
Question powerQuestion(const char* trait, uint32_t item, Exact (*exact)(uint32_t)) {
    return drawn(
        trait, item,
        [](Draw& d) {
            if (d.below(2) == 0) return Question{d.real(-120, 6), 0, 0, 0};
            const float x = (float(d.below(256u << 15)) - float(128u << 15)) / 32768.0f;  // exact
            return Question{std::bit_cast<uint32_t>(x), 0, 0, 0};
        },
        [&](const Question& q) { return isNormal(q[0]) && goodResult(exact(q[0])); });
}
// 3 + 2 |x| ULP
uint64_t powerAllowed(uint32_t x) { return uint64_t((3 + 2 * valueOf(x & 0x7fffffffu)) * double(kUlp)); }

// Half of them anywhere, half within a factor of 2 of 1, and these often next to it.
uint32_t logarithmOperand(Draw& d) {
    switch (d.below(4)) {
        case 0:
            return d.positive(-1, 0);
        case 1: {
            const uint32_t step = 1u << d.below(23);
            return 0x3f800000u + (d.below(2) == 0 ? step : 0u - step / 2) + d.below(8);
        }
        default:
            return d.positive(-126, 127);
    }
}
bool nearOne(uint32_t x) { return x >= 0x3f000000u && x <= 0x40000000u; }  // [0.5, 2]
uint64_t logarithmAllowed(const Question& q, const Exact& exact) { return nearOne(q[0]) ? ulpsOfPower(-21, exact) : 3 * kUlp; }

void addPowers(std::vector<Trait>& list) {
    const char* const power = "3 + 2 |x| ULP";
    const char* const logarithm = "3 ULP outside [0.5, 2], 2^-21 inside";
    list.push_back({.name = "exp2",
                    .group = "float32",
                    .what = "2^x",
                    .allowance = power,
                    .planes = kUnused,
                    .operation = gpu::kAskExp2,
                    .question = [](uint32_t i) { return powerQuestion("exp2", i, exp2Of); },
                    .exact = [](const Question& q) { return exp2Of(q[0]); },
                    .allowed = [](const Question& q, const Exact&) { return powerAllowed(q[0]); }});
    list.push_back({.name = "exp",
                    .group = "float32",
                    .what = "e^x",
                    .allowance = power,
                    .planes = kUnused,
                    .operation = gpu::kAskExp,
                    .question = [](uint32_t i) { return powerQuestion("exp", i, expOf); },
                    .exact = [](const Question& q) { return expOf(q[0]); },
                    .allowed = [](const Question& q, const Exact&) { return powerAllowed(q[0]); }});
    const auto operand = [](const char* trait) {
        return [trait](uint32_t i) {
            return drawn(
                trait, i,
                [](Draw& d) {
                    return Question{logarithmOperand(d), 0, 0, 0};
                },
                [](const Question& q) { return q[0] != 0x3f800000u; });
        };
    };
    list.push_back({.name = "log2",
                    .group = "float32",
                    .what = "log2 x",
                    .allowance = logarithm,
                    .planes = kUnused,
                    .operation = gpu::kAskLog2,
                    .question = operand("log2"),
                    .exact = [](const Question& q) { return log2Of(q[0]); },
                    .allowed = logarithmAllowed});
    list.push_back({.name = "log",
                    .group = "float32",
                    .what = "ln x",
                    .allowance = logarithm,
                    .planes = kUnused,
                    .operation = gpu::kAskLog,
                    .question = operand("log"),
                    .exact = [](const Question& q) { return logOf(q[0]); },
                    .allowed = logarithmAllowed});
    // exp2(y log2 x): the logarithm's error times |y|, half of an ULP or a whole one of the product, and exp2's own. 2^d - 1 is at most d
    // for d up to 1, and a relative error of d is at most d 2^24 ULP.
    const auto allowed = [](const Question& q, const Exact&) {
        const Exact log = log2Of(q[0]);
        const double l = valueOf(nearestFloat(log) & 0x7fffffffu), y = valueOf(q[1] & 0x7fffffffu);
        const double logError = nearOne(q[0]) ? 0x1p-21 : 3 * l * 0x1p-23;
        const double exponentError = y * logError + y * l * 0x1p-23;
        if (exponentError > 1) return kNoPromise;
        return uint64_t((3 + 2 * (y * l + exponentError) + exponentError * 0x1p24) * double(kUlp));
    };
    const auto question = [](uint32_t i) {
        return drawn(
            "pow", i,
            [](Draw& d) {
                const uint32_t x = d.below(2) == 0 ? d.positive(-20, 20) : 0x3f800000u - (1u << d.below(23)) + d.below(8);
                return Question{x, d.real(-10, 10), 0, 0};
            },
            [](const Question& q) { return q[0] != 0x3f800000u && goodResult(powOf(q[0], q[1])); });
    };
    list.push_back({.name = "pow",
                    .group = "float32",
                    .what = "x^y",
                    .allowance = "as exp2(y * log2(x)) with the errors of its parts",
                    .planes = "colour with --trade specular=native or encode=native, within their bound; none without",
                    .operation = gpu::kAskPow,
                    .operands = Operands::two,
                    .question = question,
                    .exact = [](const Question& q) { return powOf(q[0], q[1]); },
                    .allowed = allowed});
}

// Three quarters in [-pi, pi]; the others anywhere, or next to a multiple of pi / 2.
uint32_t angleOperand(Draw& d) {
    switch (d.below(8)) {
        case 0:
            return d.real(2, 127);
        case 1:
            return std::bit_cast<uint32_t>(float(double(1 + d.below(100000)) * 0x1.921fb54442d18p+0));
        default:
            return d.real(-120, 1);
    }
}

struct Wave {
    const char *name, *what;
    uint32_t operation;
    Exact (*exact)(uint32_t);
};

void addWaves(std::vector<Trait>& list) {
    const auto allowed = [](const Question& q, const Exact& exact) {
        return atMost(q[0], kPiBits - 1) ? ulpsOfPower(-11, exact) : kNoPromise;
    };
    const char* const promise = "2^-11 in [-pi, pi], nothing outside";
    for (const auto& [name, what, operation, exact] :
         {Wave{"sin", "sine", gpu::kAskSin, sinOf}, Wave{"cos", "cosine", gpu::kAskCos, cosOf}})
        list.push_back({.name = name,
                        .group = "float32",
                        .what = what,
                        .allowance = promise,
                        .planes = kUnused,
                        .operation = operation,
                        .question =
                            [name = name](uint32_t i) {
                                Draw d(name, i);
                                return Question{angleOperand(d), 0, 0, 0};
                            },
                        .exact = [exact = exact](const Question& q) { return exact(q[0]); },
                        .allowed = allowed});
}

Exact fused(const Question& q) { return plus(product(q), exactOf(q[2])); }
Exact dotProduct(const Question& q) { return plus(times(exactOf(q[0]), exactOf(q[2])), times(exactOf(q[1]), exactOf(q[3]))); }
Exact magnitudes(const Question& q) { return dotProduct({q[0] & 0x7fffffffu, q[1] & 0x7fffffffu, q[2] & 0x7fffffffu, q[3] & 0x7fffffffu}); }

void addComposed(std::vector<Trait>& list) {
    const auto fmaQuestion = [](uint32_t i) {
        return drawn(
            "fma", i,
            [](Draw& d) {
                const uint32_t x = d.real(-30, 30), y = d.real(-30, 30);
                const int e = exponentOf(x) + exponentOf(y);
                return Question{x, y, d.real(e - 30, e + 30), 0};
            },
            [](const Question& q) { return goodResult(fused(q)) && goodResult(product(q)); });
    };
    list.push_back(
        {.name = "fma",
         .group = "float32",
         .what = "fma(x, y, z)",
         .allowance = "as x * y, then + z: an ULP of the product and one of the sum",
         .planes = kUnused,
         .operation = gpu::kAskFma,
         .operands = Operands::three,
         .question = fmaQuestion,
         .exact = fused,
         .allowed = [](const Question& q, const Exact& exact) { return kUlp + ulpsOfPower(product(q).topExponent() - 23, exact); }});
    const auto modQuestion = [](uint32_t i) {
        return drawn(
            "mod", i,
            [](Draw& d) {
                const uint32_t x = d.real(-40, 60);
                return Question{x, d.real(exponentOf(x) - 20, exponentOf(x) + 2), 0, 0};
            },
            [](const Question&) { return true; });
    };
    list.push_back(
        {.name = "mod",
         .group = "float32",
         .what = "x - y * floor(x / y)",
         .allowance =
             "as written: 3 ULP of the larger operand, counted modulo y, since a quotient may fall on either side of a whole number",
         .planes = kUnused,
         .operation = gpu::kAskMod,
         .operands = Operands::two,
         .question = modQuestion,
         .exact = [](const Question& q) { return modulo(exactOf(q[0]), exactOf(q[1])); },
         .scale = [](const Question& q) { return exactOf(std::max(q[0] & 0x7fffffffu, q[1] & 0x7fffffffu)); },
         .allowed = [](const Question&, const Exact&) { return 3 * kUlp; },
         .wraps = true});
    const auto dotQuestion = [](uint32_t i) {
        return drawn(
            "dot", i,
            [](Draw& d) {
                return Question{d.real(-15, 15), d.real(-15, 15), d.real(-15, 15), d.real(-15, 15)};
            },
            [](const Question& q) { return goodResult(dotProduct(q)); });
    };
    list.push_back({.name = "dot",
                    .group = "float32",
                    .what = "dot((x, y), (z, w)) as x z + y w",
                    .allowance = "as any sum of products: 3 ULP of the sum of their magnitudes",
                    .planes = kUnused,
                    .operation = gpu::kAskDot,
                    .operands = Operands::four,
                    .question = dotQuestion,
                    .exact = dotProduct,
                    .scale = magnitudes,
                    .allowed = [](const Question&, const Exact&) { return 3 * kUlp; }});
}

}  // namespace

void addArithmetic(std::vector<Trait>& list) {
    addSums(list);
    addRoots(list);
    addPowers(list);
    addWaves(list);
    addComposed(list);
}

}  // namespace plumb::fingerprint
