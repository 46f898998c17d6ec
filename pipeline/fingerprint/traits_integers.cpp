// SPDX-License-Identifier: MIT
// Operations on integers, all of which Vulkan defines to the last bit.
#include "pipeline/fingerprint/traits.h"
#include "shared/fingerprint.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace plumb::fingerprint {

namespace {

constexpr const char* kEverywhere = "every plane: coverage, depth and indices are integers; verify and the twin tests notice";
constexpr const char* kUnused = "none: no pass depends on it";

uint32_t anyLength(Draw& d) {
    const uint32_t bits = d.word() >> d.below(32);
    return d.below(2) == 0 ? bits : 0u - bits;
}

uint32_t longProduct(const Question& q) {
    if (q[3] == 0) return uint32_t(uint64_t(q[0]) * q[1] >> 32);
    return uint32_t(uint64_t(int64_t(int32_t(q[0])) * int32_t(q[1])) >> 32);
}

uint32_t signedQuotient(const Question& q) {
    const int64_t x = int32_t(q[0]), y = int32_t(q[1]);
    return uint32_t(q[3] == 0 ? x / y : x % y);
}

uint32_t shifted(const Question& q) {
    return q[3] == 0 ? q[0] << q[1] : q[3] == 1 ? q[0] >> q[1] : uint32_t(int64_t(int32_t(q[0])) >> q[1]);
}

uint32_t bitsOfWord(const Question& q) {
    const uint32_t x = q[0];
    switch (q[3]) {
        case 0:
            return uint32_t(std::popcount(x));
        case 1:
            return x == 0 ? ~0u : uint32_t(std::countr_zero(x));
        case 2:
            return x == 0 ? ~0u : 31u - uint32_t(std::countl_zero(x));
        case 3: {
            uint32_t reversed = 0;
            for (int bit = 0; bit < 32; ++bit) reversed |= (x >> bit & 1u) << (31 - bit);
            return reversed;
        }
        default: {
            const uint32_t y = x >> 31 != 0 ? ~x : x;
            return y == 0 ? ~0u : 31u - uint32_t(std::countl_zero(y));
        }
    }
}

}  // namespace

void addIntegers(std::vector<Trait>& list) {
    constexpr uint32_t kItems = 16384;
    const auto add = [&](const char* name, const char* what, uint32_t operation, const char* planes,
                         std::function<Question(uint32_t)> question, std::function<uint32_t(const Question&)> word) {
        list.push_back({.name = name,
                        .group = "integer",
                        .what = what,
                        .allowance = "exact",
                        .planes = planes,
                        .operation = operation,
                        .operands = Operands::steps,
                        .items = kItems,
                        .question = std::move(question),
                        .alternatives = {{"exact", true, std::move(word)}}});
    };
    // Each 256th result begins with 0x1234, in the two traits whose operations all indices need: the planted faults change those alone.
    add(
        "integer-sum", "w: 0 x + y, 1 x - y", gpu::kAskIntegerSum, kEverywhere,
        [](uint32_t i) {
            Draw d("integer-sum", i);
            const uint32_t x = anyLength(d), way = d.below(2);
            if (i % 256 == 0) return Question{x, 0x12340000u + d.below(65536) - x, 0, 0};
            return Question{x, anyLength(d), 0, way};
        },
        [](const Question& q) { return q[3] == 0 ? q[0] + q[1] : q[0] - q[1]; });
    add(
        "integer-product", "x * y", gpu::kAskIntegerProduct, kEverywhere,
        [](uint32_t i) {
            Draw d("integer-product", i);
            if (i % 256 == 0) return Question{0x1234u, 65536u, 0, 0};
            const uint32_t x = anyLength(d);
            return Question{x, anyLength(d), 0, 0};
        },
        [](const Question& q) { return q[0] * q[1]; });
    add(
        "long-product", "high 32 bits of x * y; w: 0 unsigned, 1 signed", gpu::kAskLongProduct, kEverywhere,
        [](uint32_t i) {
            Draw d("long-product", i);
            const uint32_t x = anyLength(d), y = anyLength(d);
            return Question{x, y, 0, d.below(2)};
        },
        longProduct);
    add(
        "unsigned-quotient", "w: 0 x / y, 1 x % y", gpu::kAskUnsignedQuotient, kEverywhere,
        [](uint32_t i) {
            Draw d("unsigned-quotient", i);
            const uint32_t x = anyLength(d), y = anyLength(d);
            return Question{x, std::max(y, 1u), 0, d.below(2)};
        },
        [](const Question& q) { return q[3] == 0 ? q[0] / q[1] : q[0] % q[1]; });
    add(
        "signed-quotient", "w: 0 x / y, 1 x % y of numbers that are not negative", gpu::kAskSignedQuotient, kUnused,
        [](uint32_t i) {
            Draw d("signed-quotient", i);
            const uint32_t way = d.below(2);
            uint32_t x = anyLength(d), y = anyLength(d);
            if (way == 1) x &= 0x7fffffffu, y &= 0x7fffffffu;
            if (y == 0 || y == ~0u) y = 3;
            return Question{x, y, 0, way};
        },
        signedQuotient);
    add(
        "shift", "x by y bits; w: 0 left, 1 right, 2 right with sign", gpu::kAskShift, kEverywhere,
        [](uint32_t i) {
            Draw d("shift", i);
            const uint32_t x = anyLength(d), y = d.below(32);
            return Question{x, y, 0, d.below(3)};
        },
        shifted);
    add(
        "bits", "w: 0 bitCount, 1 findLSB, 2 findMSB, 3 bitfieldReverse, 4 findMSB of an int", gpu::kAskBits, kEverywhere,
        [](uint32_t i) {
            Draw d("bits", i);
            return Question{i < 5 ? 0u : i < 10 ? ~0u : anyLength(d), 0, 0, i % 5};
        },
        bitsOfWord);
}

}  // namespace plumb::fingerprint
