// SPDX-License-Identifier: MIT
// What a device does where Vulkan leaves it a choice: contraction, order, subnormal numbers, signs of zero, NaN, ties. A fault of one
// operation is a trait of its own (traits_arithmetic.cpp), so results in [1, 2) are left to those.
#include "pipeline/fingerprint/traits.h"
#include "shared/fingerprint.h"

#include <array>
#include <cstdint>
#include <iterator>
#include <vector>

namespace plumb::fingerprint {

namespace {

constexpr uint32_t kInfinity = 0x7f800000u, kNan = 0x7fc00000u, kNegative = 0x80000000u;
constexpr uint32_t kOne = 0x3f800000u, kLargest = 0x7f7fffffu;
constexpr const char* kDecorated = "none: the start-up self-test compares x * y + x on every device, and the twin draws where it differs";
constexpr const char* kNowhere = "none: every module of plumb has NoContraction";
constexpr uint32_t kItems = 4096;

uint32_t productAndSum(const Question& q) {
    return nearestFloat(plus(exactOf(nearestFloat(times(exactOf(q[0]), exactOf(q[1])))), exactOf(q[2])));
}
uint32_t fusedSum(const Question& q) { return nearestFloat(plus(times(exactOf(q[0]), exactOf(q[1])), exactOf(q[2]))); }
uint32_t sumLessSummand(const Question& q) {
    return nearestFloat(plus(exactOf(nearestFloat(plus(exactOf(q[0]), exactOf(q[1])))), negated(exactOf(q[0]))));
}
uint32_t productOf(const Question& q) { return nearestFloat(times(exactOf(q[0]), exactOf(q[1]))); }

bool isSubnormal(uint32_t bits) { return (bits & kInfinity) == 0 && (bits & 0x7fffffu) != 0; }
uint32_t flushed(uint32_t bits) { return isSubnormal(bits) ? bits & kNegative : bits; }
bool isNanBits(uint32_t bits) { return (bits & 0x7fffffffu) > kInfinity; }

// x y + z where one rounding and two differ. Half of them cancel, so that what is left is the product's own rounding.
Question contractible(uint32_t item) {
    Draw d("contraction", item);
    for (;;) {
        const uint32_t x = d.real(4, 6), y = d.real(4, 6);
        const uint32_t product = productOf({x, y});
        const uint32_t z = d.below(2) == 0 ? product ^ kNegative : d.real(exponentOf(product) - 12, exponentOf(product) + 2);
        const Question q{x, y, z, 0};
        const uint32_t apart = productAndSum(q), together = fusedSum(q);
        const bool tie = isTie(plus(exactOf(product), exactOf(z)));
        if (!tie && apart != together && isNormal(together) && !inFirstBinade(apart) && !inFirstBinade(together)) return q;
    }
}

// (x + y) - x where y does not survive the sum as it is.
Question reassociable(uint32_t item) {
    Draw d("reassociation", item);
    for (;;) {
        const uint32_t x = d.real(30, 40);
        const Question q{x, d.real(exponentOf(x) - 20, exponentOf(x) - 8), 0, 0};
        if (isTie(plus(exactOf(q[0]), exactOf(q[1])))) continue;
        if (sumLessSummand(q) != q[1] && isNormal(sumLessSummand(q))) return q;
    }
}

void addOrder(std::vector<Trait>& list) {
    for (const bool decorated : {true, false}) {
        const Kernel kernel = decorated ? Kernel::values : Kernel::loose;
        list.push_back({.name = decorated ? "contraction" : "contraction-allowed",
                        .group = "behaviour",
                        .what = decorated ? "x * y + z with NoContraction: one rounding or two"
                                          : "x * y + z without NoContraction: one rounding or two",
                        .allowance = decorated ? "two" : "one or two",
                        .planes = decorated ? kDecorated : kNowhere,
                        .kernel = kernel,
                        .operation = gpu::kAskProductAndSum,
                        .operands = Operands::three,
                        .items = kItems,
                        .question = contractible,
                        .alternatives = {{"two roundings", true, productAndSum}, {"one rounding (contracted)", !decorated, fusedSum}}});
        list.push_back(
            {.name = decorated ? "reassociation" : "reassociation-allowed",
             .group = "behaviour",
             .what = decorated ? "(x + y) - x with NoContraction: as written or y" : "(x + y) - x without NoContraction: as written or y",
             .allowance = decorated ? "as written" : "either",
             .planes = decorated ? kDecorated : kNowhere,
             .kernel = kernel,
             .operation = gpu::kAskSumLessSummand,
             .operands = Operands::two,
             .items = kItems,
             .question = reassociable,
             .alternatives = {{"as written", true, sumLessSummand}, {"y", !decorated, [](const Question& q) { return q[1]; }}}});
    }
}

void addSubnormals(std::vector<Trait>& list) {
    const char* const planes = "none: inputs below 2^-126 become 0 at load, and products that may be tiny are made 0 in integers";
    const auto results = [](uint32_t item) {
        Draw d("subnormal-results", item);
        for (;;) {
            const Question q{d.real(-70, -60), d.real(-75, -62), 0, 0};
            if (isSubnormal(productOf(q))) return q;
        }
    };
    list.push_back({.name = "subnormal-results",
                    .group = "behaviour",
                    .what = "x * y with a subnormal result",
                    .allowance = "kept or flushed",
                    .planes = planes,
                    .operation = gpu::kAskMultiply,
                    .operands = Operands::two,
                    .items = kItems,
                    .question = results,
                    .alternatives = {{"kept", true, productOf},
                                     {"flushed to zero of its sign", true, [](const Question& q) { return flushed(productOf(q)); }},
                                     {"flushed to +0", true, [](const Question&) { return 0u; }}}});
    const auto operands = [](uint32_t item) {
        Draw d("subnormal-operands", item);
        const uint32_t x = (d.word() & kNegative) | (1u + d.below(0x7fffffu)) >> d.below(23);
        return Question{x == 0 || x == kNegative ? 1u : x, d.real(60, 80), 0, 0};
    };
    list.push_back({.name = "subnormal-operands",
                    .group = "behaviour",
                    .what = "x * y with a subnormal x and a normal result",
                    .allowance = "kept or flushed",
                    .planes = planes,
                    .operation = gpu::kAskMultiply,
                    .operands = Operands::two,
                    .items = kItems,
                    .question = operands,
                    .alternatives = {{"kept", true, productOf},
                                     {"flushed to zero of their sign", true,
                                      [](const Question& q) {
                                          return productOf({flushed(q[0]), q[1]});
                                      }},
                                     {"flushed to +0", true, [](const Question& q) {
                                          return productOf({0u, q[1]});
                                      }}}});
}

uint32_t plainResult(const Question& q) {
    const Exact x = exactOf(q[0]), y = exactOf(q[1]);
    return nearestFloat(q[3] == 0 ? plus(x, y) : q[3] == 1 ? plus(x, negated(y)) : q[3] == 2 ? times(x, y) : over(x, y));
}

void addZeroAndInfinity(std::vector<Trait>& list) {
    static constexpr Question kZeros[] = {{0, 0, 0, 0},
                                          {kNegative, kNegative, 0, 0},
                                          {0, kNegative, 0, 0},
                                          {kNegative, 0, 0, 0},
                                          {0x41000000u, 0xc1000000u, 0, 0},
                                          {0, 0, 0, 1},
                                          {0, kNegative, 0, 1},
                                          {kNegative, 0, 0, 1},
                                          {kNegative, kNegative, 0, 1},
                                          {0x41000000u, 0x41000000u, 0, 1},
                                          {0, 0xc1000000u, 0, 2},
                                          {kNegative, 0x41000000u, 0, 2},
                                          {kNegative, 0xc1000000u, 0, 2},
                                          {0, kNegative, 0, 2}};
    list.push_back({.name = "signed-zero",
                    .group = "behaviour",
                    .what = "sign of a zero; w: 0 x + y, 1 x - y, 2 x * y",
                    .allowance = "any, without SignedZeroInfNanPreserve",
                    .planes = "none: no pass uses the sign of a zero",
                    .operation = gpu::kAskSignedZero,
                    .operands = Operands::four,
                    .items = uint32_t(std::size(kZeros)),
                    .question = [](uint32_t i) { return kZeros[i]; },
                    .alternatives = {{"as IEEE 754 says", true, plainResult}},
                    .free = true});
    static constexpr Question kEnds[] = {{kLargest, kLargest, 0, 0},
                                         {0xff7fffffu, 0xff7fffffu, 0, 0},
                                         {kInfinity, 0x41000000u, 0, 0},
                                         {kInfinity, 0xff800000u, 0, 0},
                                         {kInfinity, kInfinity, 0, 1},
                                         {kLargest, 0xff7fffffu, 0, 1},
                                         {0x60000000u, 0x60000000u, 0, 2},
                                         {0x60000000u, 0xe0000000u, 0, 2},
                                         {kInfinity, 0, 0, 2},
                                         {kInfinity, 0xc1000000u, 0, 2},
                                         {0x41000000u, 0, 0, 3},
                                         {0xc1000000u, 0, 0, 3},
                                         {0, 0, 0, 3},
                                         {kInfinity, kInfinity, 0, 3},
                                         {0x41000000u, kInfinity, 0, 3},
                                         {0x7f000000u, 0x00800000u, 0, 3}};
    list.push_back({.name = "infinity",
                    .group = "behaviour",
                    .what = "overflow, infinities and 0 / 0; w: 0 x + y, 1 x - y, 2 x * y, 3 x / y; a NaN shows as 7fc00000",
                    .allowance = "any, without SignedZeroInfNanPreserve",
                    .planes = "none: passes refuse what is not finite",
                    .operation = gpu::kAskInfinity,
                    .operands = Operands::four,
                    .items = uint32_t(std::size(kEnds)),
                    .question = [](uint32_t i) { return kEnds[i]; },
                    .alternatives = {{"as IEEE 754 says", true, plainResult}},
                    .free = true});
}

void addNan(std::vector<Trait>& list) {
    const char* const promise = "any, without SignedZeroInfNanPreserve";
    const char* const planes = "none: passes refuse a NaN, and none compares the bits of one";
    const auto payloads = [](uint32_t i) {
        Draw d("nan-payload", i);
        const uint32_t nan = kInfinity | (d.word() & kNegative) | (1u + d.below(0x7ffffeu));
        return i % 2 == 0 ? Question{nan, 0x41000000u, 0, 0} : Question{0x41000000u, nan, 0, 0};
    };
    const auto quiet = [](const Question& q) { return (isNanBits(q[0]) ? q[0] : q[1]) | 0x400000u; };
    list.push_back({.name = "nan-payload",
                    .group = "behaviour",
                    .what = "bits of x + y where one is a NaN",
                    .allowance = promise,
                    .planes = planes,
                    .operation = gpu::kAskAdd,
                    .operands = Operands::two,
                    .items = 64,
                    .question = payloads,
                    .alternatives = {{"kept, and made quiet", true, quiet},
                                     {"7fc00000", true, [](const Question&) { return kNan; }},
                                     {"ffc00000", true, [](const Question&) { return kNan | kNegative; }},
                                     {"7fffffff", true, [](const Question&) { return 0x7fffffffu; }}},
                    .free = true});
    static constexpr uint32_t kValues[] = {kNan, 0xffc01234u, 0x7f800001u, 0x41000000u, 0xc1000000u, 0, kNegative, kInfinity, 0xff800000u};
    constexpr uint32_t kCount = uint32_t(std::size(kValues));
    const auto pairs = [](uint32_t i) { return Question{kValues[i / kCount % kCount], kValues[i % kCount], 0, i / (kCount * kCount)}; };
    const auto compared = [](const Question& q) {
        const bool nan = isNanBits(q[0]) || isNanBits(q[1]);
        const auto order = [](uint32_t bits) { return bits >> 31 != 0 ? -int64_t(bits & 0x7fffffffu) : int64_t(bits); };
        const int64_t x = order(q[0]), y = order(q[1]);
        return (!nan && x == y ? 1u : 0u) | (nan || x != y ? 2u : 0u) | (!nan && x < y ? 4u : 0u) | (!nan && x >= y ? 8u : 0u) |
               (isNanBits(q[0]) ? 16u : 0u);
    };
    list.push_back({.name = "nan-compare",
                    .group = "behaviour",
                    .what = "bits of x == y, x != y, x < y, x >= y, isnan(x) with NaN, zeros and infinities",
                    .allowance = promise,
                    .planes = planes,
                    .operation = gpu::kAskCompare,
                    .operands = Operands::two,
                    .reads = Reads::number,
                    .items = kCount * kCount,
                    .question = pairs,
                    .alternatives = {{"as IEEE 754 says", true, compared}},
                    .free = true});
    // One of the two is a NaN; w: 0 min, 1 max.
    const auto withNan = [](uint32_t i) {
        constexpr std::array<uint32_t, 4> kNumbers = {0x41000000u, 0xc1000000u, kInfinity, 0x40400000u};
        const uint32_t number = kNumbers[i / 4 % 4];
        return (i & 1u) == 0 ? Question{kNan, number, 0, i >> 1 & 1u} : Question{number, kNan, 0, i >> 1 & 1u};
    };
    list.push_back({.name = "nan-min-max",
                    .group = "behaviour",
                    .what = "min and max where one operand is a NaN; w: 0 min, 1 max",
                    .allowance = "either operand",
                    .planes = planes,
                    .operation = gpu::kAskMinMax,
                    .operands = Operands::four,
                    .items = 16,
                    .question = withNan,
                    .alternatives = {{"the number", true, [](const Question& q) { return isNanBits(q[0]) ? q[1] : q[0]; }},
                                     {"the NaN", true, [](const Question& q) { return isNanBits(q[0]) ? q[0] : q[1]; }},
                                     {"the first operand", true, [](const Question& q) { return q[0]; }},
                                     {"the second operand", true, [](const Question& q) { return q[1]; }}}});
}

void addRounding(std::vector<Trait>& list) {
    // y is half of an ULP of x, so x + y lies in the middle of two neighbours.
    const auto ties = [](uint32_t item) {
        Draw d("rounding-ties", item);
        for (;;) {
            const uint32_t x = d.real(2, 60), sign = d.word() & kNegative;
            const uint32_t fraction = x & 0x7fffffu;
            if (fraction == 0 || fraction == 0x7fffffu) continue;
            return Question{x, sign | uint32_t(exponentOf(x) - 24 + 127) << 23, 0, 0};
        }
    };
    const auto exact = [](const Question& q) { return plus(exactOf(q[0]), exactOf(q[1])); };
    const auto toward = [exact](bool up) {
        return [exact, up](const Question& q) {
            const Exact sum = exact(q);
            return sum.negative == up ? floatWithin(sum) : floatBeyond(sum);
        };
    };
    list.push_back({.name = "rounding-ties",
                    .group = "behaviour",
                    .what = "x + y in the middle of two float32",
                    .allowance = "either neighbour",
                    .planes = "none: the self-test refuses a device that does not round to nearest even, and the twin draws",
                    .operation = gpu::kAskAdd,
                    .operands = Operands::two,
                    .items = kItems,
                    .question = ties,
                    .alternatives = {{"to nearest even", true, [exact](const Question& q) { return nearestFloat(exact(q)); }},
                                     {"away from zero", true, [exact](const Question& q) { return floatBeyond(exact(q)); }},
                                     {"toward zero", true, [exact](const Question& q) { return floatWithin(exact(q)); }},
                                     {"upward", true, toward(true)},
                                     {"downward", true, toward(false)}}});
}

}  // namespace

void addBehaviour(std::vector<Trait>& list) {
    addOrder(list);
    addSubnormals(list);
    addZeroAndInfinity(list);
    addNan(list);
    addRounding(list);
}

}  // namespace plumb::fingerprint
