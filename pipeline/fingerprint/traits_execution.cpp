// SPDX-License-Identifier: MIT
// How a device runs a program: loops, stores, large indices, memory of a workgroup, atomics, subgroups, and whether it answers alike twice.
#include "pipeline/fingerprint/execution.h"
#include "pipeline/fingerprint/traits.h"
#include "shared/fingerprint.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <span>
#include <string>
#include <vector>

namespace plumb::fingerprint {

namespace {

constexpr const char* kRefused =
    "none: a frame with work that did not finish is refused (exit 5), and loops are split below the limit that the canary finds";

// x: outer iterations, y: inner, z: behind; w: 0 the count, 1 the state.
constexpr Question kLoops[] = {{1000, 1, 0, 0},      {1000, 1, 0, 1},      {10000, 1, 0, 0},    {60000, 1, 0, 0}, {65534, 1, 0, 0},
                               {65535, 1, 0, 0},     {65536, 1, 0, 0},     {70000, 1, 0, 0},    {70000, 1, 0, 1}, {200000, 1, 0, 0},
                               {1000000, 1, 0, 0},   {1, 60000, 0, 0},     {250, 250, 0, 0},    {300, 300, 0, 0}, {300, 300, 0, 1},
                               {30000, 1, 30000, 0}, {60000, 1, 60000, 0}, {60000, 1, 60000, 1}};

uint32_t loopAnswer(const Question& q) {
    uint32_t count = 0, state = 1;
    for (uint32_t i = 0; i < q[0]; ++i)
        for (uint32_t j = 0; j < q[1]; ++j) state = std::max(state ^ (count * 5), 1u), ++count;
    for (uint32_t i = 0; i < q[2]; ++i) state = std::max(state ^ (count * 3), 1u), ++count;
    return q[3] == 0 ? count : state;
}

std::string loopFinding(std::span<const uint32_t> answers) {
    uint32_t shortest = ~0u;
    bool wrong = false;
    for (size_t i = 0; i < answers.size(); ++i) {
        const bool right = answers[i] == loopAnswer(kLoops[i]);
        wrong = wrong || !right;
        if (!right && kLoops[i][3] == 0 && answers[i] < loopAnswer(kLoops[i])) shortest = std::min(shortest, answers[i]);
    }
    if (!wrong) return "every loop ends by itself";
    return shortest == ~0u ? "loops end with a wrong state" : fmt::format("a loop stops after {} iterations", shortest);
}

void addRuns(std::vector<Trait>& list) {
    list.push_back({.name = "loops",
                    .group = "execution",
                    .what = "loops of x times y iterations, and z behind them; w: 0 iterations that ran, 1 what they computed",
                    .allowance = "all of them",
                    .planes = kRefused,
                    .kernel = Kernel::run,
                    .operation = gpu::kRunLoops,
                    .operands = Operands::steps,
                    .items = uint32_t(std::size(kLoops)),
                    .question = [](uint32_t i) { return kLoops[i]; },
                    .alternatives = {{"every loop ends by itself", true, loopAnswer}},
                    .finding = loopFinding});
    list.push_back({.name = "stores",
                    .group = "execution",
                    .what = "a store by each of 1048576 invocations",
                    .allowance = "all of them",
                    .planes = "every plane: verify and the twin tests notice",
                    .kernel = Kernel::run,
                    .operation = gpu::kRunStores,
                    .operands = Operands::oneWord,
                    .items = 1u << 20,
                    .question =
                        [](uint32_t i) {
                            return Question{i, 0, 0, 0};
                        },
                    .alternatives = {{"all there", true, [](const Question& q) { return ~q[0]; }}}});
    // Around 2^10 to 2^24: three stores, and a load whose word is stored below 1024.
    const auto index = [](uint32_t i) {
        const uint32_t power = 1u << (10 + i / 4);
        return i % 4 < 3 ? Question{power - 1 + i % 4, 0, 0, 0} : Question{power + 5, 1, 16 + i, 0};
    };
    list.push_back({.name = "large-indices",
                    .group = "execution",
                    .what = "y: 0 store, 1 load at index x, around 2^10 to 2^24 words",
                    .allowance = "that very word",
                    .planes = "every plane of a large picture: verify notices",
                    .kernel = Kernel::run,
                    .operation = gpu::kRunIndices,
                    .operands = Operands::steps,
                    .items = 60,
                    .question = index,
                    .alternatives = {{"the right words", true, [](const Question& q) { return q[1] == 0 ? ~q[0] : indexWord(q[0]); }}}});
    list.push_back({.name = "workgroup-memory",
                    .group = "execution",
                    .what = "words of a workgroup of 64, read behind a barrier from the other end",
                    .allowance = "what was written",
                    .planes = "none: no pass uses memory of a workgroup",
                    .kernel = Kernel::run,
                    .operation = gpu::kRunMemory,
                    .operands = Operands::oneWord,
                    .items = 1024,
                    .question =
                        [](uint32_t i) {
                            return Question{i, 0, 0, 0};
                        },
                    .alternatives = {{"what was written", true, [](const Question& q) { return ~(q[0] ^ (gpu::kRunLanes - 1)); }}}});
    const auto atomics = [](const Question& q) {
        std::array<uint32_t, kAtomicWords> words = kAtomicStart;
        for (uint32_t i = 0; i < kAtomicOperands; ++i) {
            const uint32_t value = atomicOperand(i);
            words[0] += value, words[1] = std::min(words[1], value), words[2] = std::max(words[2], value);
            words[3] |= value, words[4] &= value, words[5] ^= value;
        }
        return words[q[0]];
    };
    list.push_back({.name = "atomics",
                    .group = "execution",
                    .what = "4096 atomics on one word; x: 0 sum, 1 min, 2 max, 3 or, 4 and, 5 exclusive or",
                    .allowance = "exact",
                    .planes = "none: counts that do not add up are refused (exit 5)",
                    .kernel = Kernel::run,
                    .operation = gpu::kRunAtomics,
                    .operands = Operands::oneWord,
                    .items = uint32_t(kAtomicWords),
                    .question =
                        [](uint32_t i) {
                            return Question{i, 0, 0, 0};
                        },
                    .alternatives = {{"exact", true, atomics}}});
}

void addSubgroups(std::vector<Trait>& list) {
    const auto lane = [](uint32_t i) { return Question{i, 0, 0, 0}; };
    const auto nothing = [](const Question&) { return 0u; };
    const char* const planes =
        "none: a device without these, or with other ones, draws by the modules that need none; verify notices a wrong one";
    const auto add = [&](const char* name, const char* what, uint32_t operation) {
        list.push_back({.name = name,
                        .group = "execution",
                        .what = what,
                        .allowance = "as defined",
                        .planes = planes,
                        .kernel = Kernel::subgroup,
                        .operation = operation,
                        .operands = Operands::oneWord,
                        .items = kSubgroupItems,
                        .question = lane,
                        .alternatives = {{"as defined", true, nothing}}});
    };
    // Expected is what most devices on the table have not got: the number itself is the finding.
    list.push_back({.name = "subgroup-size",
                    .group = "execution",
                    .what = "lanes that a ballot counts",
                    .allowance = "1 to 128, a power of two",
                    .planes = "none: no result depends on it",
                    .kernel = Kernel::subgroup,
                    .operation = gpu::kSubgroupSize,
                    .operands = Operands::oneWord,
                    .items = kSubgroupItems,
                    .question = lane,
                    .alternatives = {{"8 lanes", true, [](const Question&) { return 8u; }}},
                    .free = true,
                    .finding = [](std::span<const uint32_t> answers) { return fmt::format("{} lanes", answers[0]); }});
    add("subgroup-shuffle", "bits of what is wrong: 1 shuffle, 2 broadcast of the first, 4 shuffle by exclusive or", gpu::kSubgroupShuffle);
    add("subgroup-vote", "bits of what is wrong: 1 any, 2 all, 4 ballot, 8 all of the same", gpu::kSubgroupVote);
    add("subgroup-sum", "bits of what is wrong, of integers: 1 sum, 2 smallest, 4 sum of the lanes before", gpu::kSubgroupSum);
    std::vector<Alternative> orders;
    for (const uint32_t lanes : {8u, 4u, 16u, 32u, 64u})
        orders.push_back({"one lane after another", true, [lanes](const Question&) {
                              uint32_t sum = 0;
                              for (uint32_t i = 0; i < lanes; ++i) sum = nearestFloat(plus(exactOf(sum), exactOf(gpu::laneFloatBits(i))));
                              return sum;
                          }});
    list.push_back({.name = "subgroup-float-sum",
                    .group = "execution",
                    .what = "sum of floats over the lanes of a subgroup, which tells their order",
                    .allowance = "any order",
                    .planes = "none: no pass adds floats of several lanes",
                    .kernel = Kernel::subgroup,
                    .operation = gpu::kSubgroupFloatSum,
                    .operands = Operands::oneWord,
                    .items = kSubgroupItems,
                    .question = lane,
                    .alternatives = orders,
                    .free = true});
}

}  // namespace

void addExecution(std::vector<Trait>& list) {
    addRuns(list);
    addSubgroups(list);
    const uint32_t repeated = uint32_t(std::count_if(list.begin(), list.end(), [](const Trait& t) { return isRepeated(t); }));
    list.push_back({.name = "determinism",
                    .group = "execution",
                    .what = "words that differ when the traits up to here are asked again, one trait each",
                    .allowance = "none",
                    .planes = "every plane: verify notices",
                    .kernel = Kernel::repeats,
                    .operands = Operands::oneWord,
                    .items = repeated,
                    .question =
                        [](uint32_t i) {
                            return Question{i, 0, 0, 0};
                        },
                    .alternatives = {{"the same words again", true, [](const Question&) { return 0u; }}}});
}

}  // namespace plumb::fingerprint
