// SPDX-License-Identifier: MIT
#include "tests/fault/planted_driver.h"

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <vector>

namespace plumb::test {

namespace {

using Is = std::function<bool(Editor&, const Words&)>;
using Change = std::function<void(Editor&)>;

Is opcode(uint32_t wanted) {
    return [wanted](Editor&, const Words& in) { return Editor::op(in) == wanted; };
}
Is builtIn(uint32_t number) {
    return [number](Editor& e, const Words& in) { return e.isExt(in, number); };
}

Change each(const Is& is, const std::function<void(Editor&, const Words&)>& change) {
    return [is, change](Editor& e) {
        e.eachInFunctions([&](const Words& in) {
            if (is(e, in)) change(e, in);
        });
    };
}

// The result's bits, one further.
Change oneMore(const Is& is) {
    return each(is, [](Editor& e, const Words& in) { e.wordResult(in, [&](uint32_t word) { return e.plusOne(word); }); });
}
// The same where the bits under `mask` are `value`.
Change oneMoreWhere(const Is& is, uint32_t mask, uint32_t value) {
    return each(is, [=](Editor& e, const Words& in) {
        e.wordResult(in, [&](uint32_t word) {
            const uint32_t condition = e.equal(e.masked(word, mask), e.constant(value));
            return e.select(condition, e.plusOne(word), word);
        });
    });
}
// A binary operation in [1, 2) only: the traits about behaviour leave that binade alone.
Change ulpWorse(uint32_t op) { return oneMoreWhere(opcode(op), 0x7f800000u, 0x3f800000u); }

// Bits under `mask` that are `value` become `instead`, with the sign kept or not.
Change replaced(const Is& is, uint32_t mask, uint32_t value, uint32_t instead, bool signKept) {
    return each(is, [=](Editor& e, const Words& in) {
        e.wordResult(in, [&](uint32_t word) {
            const uint32_t condition = e.equal(e.masked(word, mask), e.constant(value));
            uint32_t other = e.constant(instead);
            if (signKept) other = e.put(197, e.uintType(), {other, e.masked(word, 0x80000000u)});
            return e.select(condition, other, word);
        });
    });
}

uint32_t flushed(Editor& e, uint32_t id) {
    const uint32_t word = e.put(124, e.uintType(), {id});
    const uint32_t subnormal = e.equal(e.masked(word, 0x7f800000u), e.constant(0));
    return e.put(124, e.floatType(), {e.select(subnormal, e.masked(word, 0x80000000u), word)});
}

void flushOperands(Editor& e) {
    e.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) != 133) return;
        const uint32_t x = flushed(e, in[3]), y = flushed(e, in[4]);
        e.put(133, in[1], {x, y}, in[2]);
    });
}

// x y + z by way of binary64, which rounds it once (nearly always): what a driver that contracts gives.
Change contracted(bool decorated) {
    return [decorated](Editor& e) {
        std::map<uint32_t, Words> products;
        for (const Words& in : e.list())
            if (Editor::op(in) == 133) products[in[2]] = in;
        bool found = false;
        for (const Words& in : e.list())
            found = found ||
                    (Editor::op(in) == 129 && e.isDecorated(in[2]) == decorated && (products.contains(in[3]) || products.contains(in[4])));
        if (!found) return;
        const uint32_t wide = e.doubleType();
        e.eachInFunctions([&](const Words& in) {
            if (Editor::op(in) != 129 || e.isDecorated(in[2]) != decorated) return;
            const bool left = products.contains(in[3]);
            if (!left && !products.contains(in[4])) return;
            const Words product = products[left ? in[3] : in[4]];
            const auto widened = [&](uint32_t id) { return e.put(115, wide, {id}); };
            const uint32_t exact = e.put(133, wide, {widened(product[3]), widened(product[4])});
            e.put(115, in[1], {e.put(129, wide, {exact, widened(left ? in[4] : in[3])})}, in[2]);
        });
        e.undecorate();
    };
}

// (x + y) - x
std::map<uint32_t, Words> sumsLessSummand(const Editor& e) {
    std::map<uint32_t, Words> sums, found;
    for (const Words& in : e.list()) {
        if (Editor::op(in) == 129) sums[in[2]] = in;
        if (Editor::op(in) == 131 && sums.contains(in[3]) && sums[in[3]][3] == in[4]) found[in[2]] = sums[in[3]];
    }
    return found;
}

void reassociated(Editor& e) {
    const auto found = sumsLessSummand(e);
    e.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) == 131 && found.contains(in[2])) e.put(83, in[1], {found.at(in[2])[4]}, in[2]);
    });
}

void asWritten(Editor& e) {
    for (const auto& [difference, sum] : sumsLessSummand(e))
        if (!e.isDecorated(difference)) e.decorate(difference), e.decorate(sum[2]);
}

// The sum in binary64 is exact here; a tie gets a further bit, so that it rounds away from zero.
void tiesAway(Editor& e) {
    bool found = false;
    for (const Words& in : e.list()) found = found || Editor::op(in) == 129;
    if (!found) return;
    const uint32_t wide = e.doubleType(), pair = e.uvec2Type(), word = e.uintType();
    e.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) != 129) return;
        const uint32_t exact = e.put(129, wide, {e.put(115, wide, {in[3]}), e.put(115, wide, {in[4]})});
        const uint32_t bits = e.put(124, pair, {exact});
        const uint32_t low = e.put(81, word, {bits, 0}), high = e.put(81, word, {bits, 1});
        const uint32_t tie = e.equal(e.masked(low, 0x1fffffffu), e.constant(0x10000000u));
        const uint32_t further = e.put(80, pair, {e.put(197, word, {low, e.constant(1)}), high});
        const uint32_t away = e.put(115, in[1], {e.put(124, wide, {further})});
        const uint32_t plain = e.putRenamed(in);
        e.put(169, in[1], {tie, away, plain}, in[2]);
    });
}

void nansCanonical(Editor& e) {
    e.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) != 129) return;
        e.wordResult(in, [&](uint32_t word) {
            const uint32_t nan = e.put(172, e.boolType(), {e.masked(word, 0x7fffffffu), e.constant(0x7f800000u)});
            return e.select(nan, e.constant(0x7fc0beefu), word);
        });
    });
}

void minOfNanIsNan(Editor& e) {
    e.eachInFunctions([&](const Words& in) {
        if (!e.isExt(in, 37)) return;
        const uint32_t nan = e.put(156, e.boolType(), {in[6]});
        const uint32_t least = e.putRenamed(in);
        e.put(169, in[1], {nan, in[6], least}, in[2]);
    });
}

// Another opcode, or another number of a built-in function.
Change swapped(uint32_t from, uint32_t to) {
    return each(opcode(from), [to](Editor& e, const Words& in) {
        Words other = in;
        other[0] = (in[0] & 0xffff0000u) | to;
        e.put(other);
    });
}
Change builtInSwapped(uint32_t from, uint32_t to) {
    return each(builtIn(from), [to](Editor& e, const Words& in) {
        Words other = in;
        other[4] = to;
        e.put(other);
    });
}
// Operand `at` (a word of the instruction) with a bit turned over.
Change operandTurned(const Is& is, size_t at, uint32_t bit) {
    return each(is, [=](Editor& e, const Words& in) {
        Words other = in;
        other[at] = e.put(198, e.uintType(), {in[at], e.constant(bit)});
        e.put(other);
    });
}

// Loops end after 1000 iterations, as if by themselves.
void loopsCut(Editor& e) {
    std::set<uint32_t> merges;
    std::map<uint32_t, Words> comparisons;
    for (const Words& in : e.list()) {
        if (Editor::op(in) == 246) merges.insert(in[1]);
        if (Editor::op(in) == 176) comparisons[in[2]] = in;  // ULessThan
    }
    std::set<uint32_t> ends;
    for (const Words& in : e.list())
        if (Editor::op(in) == 250 && comparisons.contains(in[1]) && (merges.contains(in[2]) || merges.contains(in[3]))) ends.insert(in[1]);
    e.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) != 176 || !ends.contains(in[2])) return;
        const uint32_t before = e.put(176, in[1], {in[3], e.constant(1000)});
        e.put(167, in[1], {before, e.putRenamed(in)}, in[2]);
    });
}

// Pointers into storage buffers, with their last index.
std::map<uint32_t, uint32_t> bufferIndices(const Editor& e) {
    std::map<uint32_t, uint32_t> indices;
    for (const Words& in : e.list())
        if (Editor::op(in) == 65 && e.isBuffer(in[3])) indices[in[2]] = in.back();
    return indices;
}

void storeDropped(Editor& e) {
    const auto indices = bufferIndices(e);
    e.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) != 62 || !indices.contains(in[1]) || e.isConstant(indices.at(in[1]))) return;
        const uint32_t dropped = e.equal(indices.at(in[1]), e.constant(777777));
        const uint32_t old = e.put(61, e.uintType(), {in[1]});
        e.put(instruction(62, {in[1], e.select(dropped, old, in[2])}));
    });
}

void staleMemory(Editor& e) {
    const auto indices = bufferIndices(e);
    e.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) != 62 || !indices.contains(in[1])) return;
        const uint32_t old = e.put(61, e.uintType(), {in[1]});
        e.put(instruction(62, {in[1], e.put(198, e.uintType(), {in[2], e.masked(old, 4)})}));
    });
}

void indicesOf24Bits(Editor& e) {
    e.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) != 65 || !e.isBuffer(in[3]) || e.isConstant(in.back())) return;
        Words other = in;
        other.back() = e.masked(in.back(), 0x00ffffffu);
        e.put(other);
    });
}

void barriersDropped(Editor& e) {
    e.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) == 224) e.drop();
    });
}

void votesTurned(Editor& e) {
    e.eachInFunctions([&](const Words& in) {
        if (Editor::op(in) == 335) e.put(168, in[1], {e.putRenamed(in)}, in[2]);
    });
}

}  // namespace

std::vector<PlantedDriver> plantedDrivers() {
    std::vector<PlantedDriver> all = {
        {"add", "sums in [1, 2) are an ULP off", ulpWorse(129)},
        {"subtract", "differences in [1, 2) are an ULP off", ulpWorse(131)},
        {"multiply", "products in [1, 2) are an ULP off", ulpWorse(133)},
        {"divide", "quotients in [1, 2) are an ULP off", ulpWorse(136)},
        {"mod", "an ULP off", oneMore(opcode(141))},
        {"dot", "an ULP off", oneMore(opcode(148))},
        {"int-to-float", "an ULP off", oneMore(opcode(111))},
        {"uint-to-float", "an ULP off", oneMore(opcode(112))},
        {"float-to-int", "16 becomes 17", oneMoreWhere(opcode(110), ~0u, 16)},
        {"float-to-uint", "16 becomes 17", oneMoreWhere(opcode(109), ~0u, 16)},
        {"float-to-int-outside", "saturates at the largest int", replaced(opcode(110), ~0u, 0x80000000u, 0x7fffffffu, false)},
        {"pack-half", "the lower half is an ULP off", oneMore(builtIn(58))},
        {"unpack-half", "the upper half is an ULP off", operandTurned(builtIn(62), 5, 0x10000u)},
        {"whole-numbers", "roundEven rounds up", builtInSwapped(2, 9)},
        {"contraction", "NoContraction is stripped, and x y + z contracted", contracted(true)},
        {"contraction-allowed", "x y + z is contracted where it may be", contracted(false), true},
        {"reassociation", "NoContraction is stripped, and (x + y) - x is y", reassociated},
        {"reassociation-allowed", "(x + y) - x is as written where it need not be", asWritten, true},
        {"subnormal-results", "subnormal products are flushed", replaced(opcode(133), 0x7f800000u, 0, 0, true)},
        {"subnormal-operands", "subnormal factors are flushed", flushOperands},
        {"signed-zero", "a difference of 0 is -0", replaced(opcode(131), 0x7fffffffu, 0, 0x80000000u, false)},
        {"infinity", "products saturate at the largest number", replaced(opcode(133), 0x7fffffffu, 0x7f800000u, 0x7f7fffffu, true)},
        {"nan-payload", "a sum that is a NaN has one payload", nansCanonical},
        {"nan-compare", "a NaN equals everything", swapped(180, 181)},
        {"nan-min-max", "the smaller of a number and a NaN is the NaN", minOfNanIsNan},
        {"rounding-ties", "ties go away from zero", tiesAway},
        {"integer-sum", "sums from 0x12340000 on are 1 off", oneMoreWhere(opcode(128), 0xffff0000u, 0x12340000u)},
        {"integer-product", "products from 0x12340000 on are 1 off", oneMoreWhere(opcode(132), 0xffff0000u, 0x12340000u)},
        {"long-product", "a factor loses its highest bit but one", operandTurned(opcode(151), 3, 0x40000000u)},
        {"unsigned-quotient", "1 off", oneMore(opcode(134))},
        {"signed-quotient", "1 off", oneMore(opcode(135))},
        {"shift", "shifts with sign are 1 off", oneMore(opcode(195))},
        {"bits", "counts of bits are 1 off", oneMore(opcode(205))},
        {"loops", "loops are cut at 1000 iterations", loopsCut},
        {"stores", "the store at index 777777 is dropped", storeDropped},
        {"large-indices", "indices have 24 bits", indicesOf24Bits},
        {"workgroup-memory", "barriers are dropped", barriersDropped},
        {"atomics", "the smallest is the largest", swapped(237, 239)},
        {"subgroup-size", "a ballot counts a lane too many", oneMore(opcode(342))},
        {"subgroup-shuffle", "what is shuffled is 1 off", oneMore(opcode(345))},
        {"subgroup-vote", "any lane is turned over", votesTurned},
        {"subgroup-sum", "sums of lanes are 1 off", oneMore(opcode(349))},
        {"subgroup-float-sum", "an ULP off", oneMore(opcode(350))},
        {"determinism", "a store mixes with what was there before", staleMemory},
    };
    for (const auto& [trait, number] : {std::pair{"sqrt", 31u},
                                        {"inversesqrt", 32u},
                                        {"exp2", 29u},
                                        {"exp", 27u},
                                        {"log2", 30u},
                                        {"log", 28u},
                                        {"pow", 26u},
                                        {"sin", 13u},
                                        {"cos", 14u},
                                        {"fma", 50u}})
        all.push_back({trait, "an ULP off", oneMore(builtIn(number))});
    return all;
}

}  // namespace plumb::test
