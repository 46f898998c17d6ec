// SPDX-License-Identifier: MIT
// Traits of a device: what it is asked, what the answer should be, what Vulkan allows, and which pictures could change by it. Questions are
// the same on every machine and in every run of one kVersion.
#pragma once

#include "pipeline/fingerprint/exact.h"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace plumb::fingerprint {

// Number of the set of questions. A change of a trait, a question or an order takes the next one: fingerprints of two are not compared.
inline constexpr uint32_t kVersion = 1;
inline constexpr uint32_t kSamples = 65536;  // questions of a trait with decades

using Question = std::array<uint32_t, 4>;

enum class Kernel : uint8_t { values, loose, run, subgroup, repeats };
// How a question reads: numbers that it has, and whether they are float32.
enum class Operands : uint8_t { none, one, two, three, four, oneWord, twoWords, steps };

// How an answer reads: as its operands do, as a number, or as a float32.
enum class Reads : uint8_t { asOperands, number, real };

inline constexpr uint64_t kNoPromise = ~uint64_t(0);

// What an answer may be instead of the first, which is the one that is expected.
struct Alternative {
    const char* name;  // what the device does then: "flushed to zero"
    bool allowed;
    std::function<uint32_t(const Question&)> word;
};

struct Trait {
    const char* name;
    const char* group;      // float32, conversion, behaviour, integer, execution
    const char* what;       // what is asked, in one sentence
    const char* allowance;  // what Vulkan promises
    const char* planes;     // which pictures could change where this does
    Kernel kernel = Kernel::values;
    uint32_t operation = 0;
    Operands operands = Operands::one;
    Reads reads = Reads::asOperands;
    uint32_t items = 0;  // answers; 0: as many as samples
    std::function<Question(uint32_t item)> question;

    // Traits in ULP: the exact result, the number whose ULP counts (none: the result), and the allowance in 1/65536 ULP.
    std::function<Exact(const Question&)> exact;
    std::function<Exact(const Question&)> scale;
    std::function<uint64_t(const Question&, const Exact&)> allowed;
    bool wraps = false;  // distances count modulo the second operand

    std::vector<Alternative> alternatives;                                  // of the other traits, the expected one first
    bool free = false;                                                      // Vulkan promises nothing
    std::function<std::string(std::span<const uint32_t> answers)> finding;  // instead of the alternative's name

    bool inUlp() const { return bool(exact); }
};

// All traits, in the order of the report. Made once.
const std::vector<Trait>& traits();

// Parts of the list, each in a file of its own.
void addArithmetic(std::vector<Trait>&);
void addConversions(std::vector<Trait>&);
void addBehaviour(std::vector<Trait>&);
void addIntegers(std::vector<Trait>&);
void addExecution(std::vector<Trait>&);

// Questions of a trait, and the answers that are expected.
struct Questions {
    std::vector<Question> questions;
    std::vector<uint32_t> expected;
};
Questions questionsOf(const Trait&, uint32_t samples);
// Questions of all traits, in the order of the traits. They are made once for each number of samples.
const std::vector<Questions>& allQuestions(uint32_t samples = kSamples);

// Numbers of a question, drawn by the trait's name and the item alone: the same on every machine.
class Draw {
public:
    Draw(const char* trait, uint32_t item);
    uint32_t word();
    uint32_t below(uint32_t count) { return uint32_t((uint64_t(word()) * count) >> 32); }
    int between(int least, int most) { return least + int(below(uint32_t(most - least + 1))); }
    uint32_t significand();              // 23 bits: often at an end, or with few bits set
    uint32_t real(int least, int most);  // float32 of either sign with its exponent in this range
    uint32_t positive(int least, int most) { return real(least, most) & 0x7fffffffu; }

private:
    uint64_t state_;
};

inline int exponentOf(uint32_t bits) { return int(bits >> 23 & 255u) - 127; }
inline bool isNormal(uint32_t bits) { return (bits >> 23 & 255u) != 0 && (bits >> 23 & 255u) != 255; }
// Results of arithmetic that the traits about behaviour leave alone, so that a fault there is a trait of its own: [1, 2).
inline bool inFirstBinade(uint32_t bits) { return exponentOf(bits) == 0; }

}  // namespace plumb::fingerprint
