// SPDX-License-Identifier: MIT
// A faulty driver, planted by changing SPIR-V before the real one reads it. SPIR-V 1.5: 2.3 physical layout, 3.32 instructions.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

namespace plumb::test {

using Words = std::vector<uint32_t>;

// Instruction: word 0 is opcode and count.
inline Words instruction(uint32_t op, std::vector<uint32_t> operands) {
    operands.insert(operands.begin(), uint32_t(operands.size() + 1) << 16 | op);
    return operands;
}

class Editor {
public:
    explicit Editor(const Words& words) : head_(words.begin(), words.begin() + 5) {
        for (size_t at = 5; at < words.size(); at += words[at] >> 16)
            list_.emplace_back(words.begin() + long(at), words.begin() + long(at + (words[at] >> 16)));
        for (const Words& in : list_) {
            if (op(in) == 11) set_ = in[1];
            if (op(in) == 71 && in[2] == 42) decorated_.insert(in[1]);
            if (op(in) == 54) break;
            if (op(in) == 43 || op(in) == 50) constants_.insert(in[2]);
            if (op(in) == 32) pointers_[in[1]] = in[2];
            if (op(in) == 59) variables_[in[2]] = in[3];
        }
    }
    static uint32_t op(const Words& in) { return in[0] & 0xffffu; }
    Words words() const {
        Words all = head_;
        for (const Words& in : list_) all.insert(all.end(), in.begin(), in.end());
        return all;
    }

    bool isExt(const Words& in, uint32_t number) const { return op(in) == 12 && in[3] == set_ && in[4] == number; }
    bool isDecorated(uint32_t id) const { return decorated_.contains(id); }
    bool isConstant(uint32_t id) const { return constants_.contains(id); }
    bool isBuffer(uint32_t variable) const {  // a storage buffer
        const auto it = variables_.find(variable);
        return it != variables_.end() && (it->second == 12 || it->second == 2);
    }
    uint32_t fresh() { return head_[3]++; }

    // Types and constants, found or made.
    uint32_t type(std::vector<uint32_t> operands, uint32_t opcode) {
        for (const Words& in : list_) {
            if (op(in) == 54) break;
            if (op(in) == opcode && in.size() == operands.size() + 2 && std::equal(operands.begin(), operands.end(), in.begin() + 2))
                return in[1];
        }
        const uint32_t id = fresh();
        operands.insert(operands.begin(), id);
        beforeFunctions(instruction(opcode, operands));
        return id;
    }
    uint32_t uintType() { return type({32, 0}, 21); }
    uint32_t floatType() { return type({32}, 22); }
    uint32_t boolType() { return type({}, 20); }
    uint32_t doubleType() {
        for (const Words& in : list_)
            if (op(in) == 17 && in[1] == 10) return type({64}, 22);
        list_.insert(list_.begin(), instruction(17, {10}));  // the capability of binary64
        return type({64}, 22);
    }
    uint32_t uvec2Type() {
        const uint32_t word = uintType();
        return type({word, 2}, 23);
    }
    uint32_t constant(uint32_t value) {
        const uint32_t id = fresh(), word = uintType();
        beforeFunctions(instruction(43, {word, id, value}));
        return id;
    }

    // Replaces each instruction of the functions for which `change` appends others to its list; an empty list keeps it.
    void eachInFunctions(const std::function<void(const Words&)>& change) {
        std::vector<Words> old;
        size_t first = 0;
        while (first < list_.size() && op(list_[first]) != 54) ++first;
        old.assign(list_.begin() + long(first), list_.end());
        std::vector<Words> made;
        for (const Words& in : old) {
            out_.clear();
            dropped_ = false;
            change(in);
            if (out_.empty() && !dropped_)
                made.push_back(in);
            else
                made.insert(made.end(), out_.begin(), out_.end());
        }
        first = 0;
        while (first < list_.size() && op(list_[first]) != 54) ++first;
        list_.resize(first);
        list_.insert(list_.end(), made.begin(), made.end());
    }
    void put(const Words& in) { out_.push_back(in); }
    void drop() { dropped_ = true; }
    uint32_t put(uint32_t opcode, uint32_t resultType, const std::vector<uint32_t>& operands, uint32_t result = 0) {
        if (result == 0) result = fresh();
        std::vector<uint32_t> all = {resultType, result};
        all.insert(all.end(), operands.begin(), operands.end());
        out_.push_back(instruction(opcode, all));
        return result;
    }
    // The instruction with its result under another id.
    uint32_t putRenamed(Words in) {
        const uint32_t id = fresh();
        in[2] = id;
        out_.push_back(in);
        return id;
    }
    // Changes the result of `in`, taken as a word: result = change(word).
    void wordResult(const Words& in, const std::function<uint32_t(uint32_t)>& change) {
        const uint32_t word = put(124, uintType(), {putRenamed(in)});
        put(124, in[1], {change(word)}, in[2]);
    }
    uint32_t select(uint32_t condition, uint32_t yes, uint32_t no) { return put(169, uintType(), {condition, yes, no}); }
    uint32_t equal(uint32_t a, uint32_t b) { return put(170, boolType(), {a, b}); }
    uint32_t masked(uint32_t word, uint32_t mask) { return put(199, uintType(), {word, constant(mask)}); }
    uint32_t plusOne(uint32_t word) { return put(128, uintType(), {word, constant(1)}); }

    void decorate(uint32_t id) {  // NoContraction, before the first type
        size_t first = 0;
        while (op(list_[first]) != 19) ++first;
        list_.insert(list_.begin() + long(first), instruction(71, {id, 42}));
    }
    void undecorate() {
        std::erase_if(list_, [](const Words& in) { return op(in) == 71 && in[2] == 42; });
    }
    const std::vector<Words>& list() const { return list_; }

private:
    void beforeFunctions(const Words& in) {
        size_t first = 0;
        while (first < list_.size() && op(list_[first]) != 54) ++first;
        // A type stands before what uses it: after all others, before the variables that need none of it.
        list_.insert(list_.begin() + long(first), in);
    }

    Words head_;
    std::vector<Words> list_, out_;
    uint32_t set_ = 0;
    bool dropped_ = false;
    std::set<uint32_t> decorated_, constants_;
    std::map<uint32_t, uint32_t> pointers_, variables_;
};

struct PlantedDriver {
    const char* trait;  // the one that it changes
    const char* fault;
    std::function<void(Editor&)> change;
    bool loose = false;  // it changes the modules without NoContraction, too
};

// A faulty driver for each trait.
std::vector<PlantedDriver> plantedDrivers();

}  // namespace plumb::test
