// SPDX-License-Identifier: MIT
// SPIR-V 1.5 specification: 2.2.5 and 2.4 layout, 2.11 structured control flow, 3.32 instructions.
#include "host/fold.h"

#include "host/error.h"
#include "host/spirv_words.h"

#include <fmt/core.h>
#include <cstdint>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {

namespace {

constexpr uint32_t kDecorationSpecId = 1;
constexpr uint32_t kMostNames = 4194304;  // 2.17, universal limits

using Words = std::span<const uint32_t>;
using Value = std::optional<uint32_t>;  // value of an id; none: not known here

uint32_t opOf(Words in) { return in[0] & 0xffffu; }

// Value of an operation on 32-bit integers and truth values. An operand of another kind is never known.
Value evaluate(uint32_t op, Value x, Value y, Value z) {
    if (op == kOpLogicalAnd && ((x && !*x) || (y && !*y))) return 0;
    if (op == kOpLogicalOr && ((x && *x) || (y && *y))) return 1;
    if (op == kOpSelect) return x ? (*x ? y : z) : std::nullopt;
    if (op == kOpLogicalNot) return x ? Value(!*x) : std::nullopt;
    if (!x || !y) return std::nullopt;
    const uint32_t a = *x, b = *y;
    const int32_t sa = int32_t(a), sb = int32_t(b);
    switch (op) {
        case kOpLogicalAnd:
        case kOpBitwiseAnd:
            return a & b;
        case kOpLogicalOr:
        case kOpBitwiseOr:
            return a | b;
        case kOpBitwiseXor:
            return a ^ b;
        case kOpIAdd:
            return a + b;
        case kOpISub:
            return a - b;
        case kOpIMul:
            return a * b;
        case kOpShiftRightLogical:
            return b < 32 ? Value(a >> b) : std::nullopt;
        case kOpShiftLeftLogical:
            return b < 32 ? Value(a << b) : std::nullopt;
        case kOpLogicalEqual:
        case kOpIEqual:
            return a == b;
        case kOpLogicalNotEqual:
        case kOpINotEqual:
            return a != b;
        case kOpUGreaterThan:
            return a > b;
        case kOpSGreaterThan:
            return sa > sb;
        case kOpUGreaterThanEqual:
            return a >= b;
        case kOpSGreaterThanEqual:
            return sa >= sb;
        case kOpULessThan:
            return a < b;
        case kOpSLessThan:
            return sa < sb;
        case kOpULessThanEqual:
            return a <= b;
        case kOpSLessThanEqual:
            return sa <= sb;
        default:
            return std::nullopt;
    }
}

class Folder {
public:
    Folder(const Module& module, const ConstantsById& constants) : name_(module.name), words_(module.words) {
        readGlobals(constants);
        readFunctions();
        call(entry_);
        for (size_t f = 0; f < called_.size(); ++f) walk(functions_[called_[f]]);
    }

    std::vector<uint32_t> words() const {
        std::vector<uint32_t> body;
        std::vector<bool> used(names_), gone(names_);
        for (const Function& f : functions_) {
            if (!f.called)
                forget(at(f.begin, f.end), gone);
            else
                writeFunction(f, body, used, gone);
        }
        dropVariables(body, used, gone);
        std::vector<uint32_t> all(words_.begin(), words_.begin() + kHeaderWords);
        all.reserve(kHeaderWords + globals_ + body.size());
        for (const Words in : instructions(at(kHeaderWords, globals_))) {
            const uint32_t op = opOf(in);
            const bool decorates = op == kOpDecorate || op == kOpMemberDecorate || op == kOpDecorateId;
            if (isDebug(op) || (decorates && gone[in[1]])) continue;
            all.insert(all.end(), in.begin(), in.end());
        }
        all.insert(all.end(), body.begin(), body.end());
        return all;
    }

private:
    struct Block {
        size_t begin = 0, end = 0;      // range of words, from its label to its terminator
        uint32_t label = 0, taken = 0;  // taken: label of the only side of its branch; 0: the branch stays
        bool live = false;
        std::vector<uint32_t> next;  // labels that it branches to, once live
    };
    struct Function {
        size_t begin = 0, end = 0;
        bool called = false;
        std::vector<Block> blocks;
    };

    [[noreturn]] void fail(const char* what) const { throw deviceError(fmt::format("{}: not SPIR-V: {}", name_, what)); }

    Words at(size_t begin, size_t end) const { return words_.subspan(begin, end - begin); }
    std::vector<Words> instructions(Words words) const {
        std::vector<Words> all;
        for (size_t i = 0; i < words.size();) {
            const size_t count = words[i] >> 16;
            if (count == 0 || count > words.size() - i) fail("a truncated instruction");
            all.push_back(words.subspan(i, count));
            i += count;
        }
        return all;
    }
    static bool isDebug(uint32_t op) { return (op >= kOpSourceContinued && op <= kOpLine) || op == kOpNoLine || op == kOpModuleProcessed; }
    // Id that an instruction of a function makes, or 0. Such instructions, and no others, have a type or are labels.
    uint32_t resultOf(Words in) const {
        if (opOf(in) == kOpLabel) return in[1];
        return in.size() > 2 && in[1] < names_ && isType_[in[1]] ? in[2] : 0;
    }
    uint32_t checked(uint32_t id) const {
        if (id >= names_) fail("an id beyond the bound");
        return id;
    }
    // Known value of the id at `word`. The caller knows that the word is an id: literals may stand where another instruction has an id.
    Value known(Words in, size_t word) const { return word < in.size() && in[word] < names_ ? known_[in[word]] : std::nullopt; }

    void readGlobals(const ConstantsById& constants) {
        if (words_.size() < kHeaderWords || words_[0] != kSpirvMagic) fail("no header");
        names_ = words_[3];
        if (names_ > kMostNames) fail("more ids than the specification allows");
        isType_.resize(names_);
        isWord_.resize(names_);
        known_.resize(names_);
        functionOf_.resize(names_, kNone);
        std::map<uint32_t, uint32_t> given;  // constants by id
        globals_ = words_.size();
        for (const Words in : instructions(at(kHeaderWords, words_.size()))) {
            const uint32_t op = opOf(in);
            if (op == kOpFunction) {
                globals_ = size_t(in.data() - words_.data());
                break;
            }
            const bool ofType = op >= kOpConstantTrue && op <= kOpSpecConstantOp;
            if (in.size() < (ofType ? 3u : op == kOpEntryPoint ? 3u : 2u) && op != kOpModuleProcessed) {
                if (op < kOpTypeVoid) continue;
                fail("a short instruction");
            }
            if (op == kOpEntryPoint) entry_ = checked(in[2]);
            if (op >= kOpTypeVoid && op <= kOpTypeFunction) isType_[checked(in[1])] = true;
            if (op == kOpTypeBool || (op == kOpTypeInt && in.size() > 2 && in[2] == 32)) isWord_[in[1]] = true;
            if (op == kOpDecorate && in.size() > 3 && in[2] == kDecorationSpecId)
                if (const auto it = constants.find(in[3]); it != constants.end()) given[checked(in[1])] = it->second;
            if (ofType) readConstant(in, given);
        }
    }

    void readConstant(Words in, const std::map<uint32_t, uint32_t>& given) {
        const uint32_t op = opOf(in), id = checked(in[2]);
        if (!isWord_[checked(in[1])]) return;
        Value& value = known_[id];
        if (op == kOpConstantTrue || op == kOpSpecConstantTrue) value = 1;
        if (op == kOpConstantFalse || op == kOpSpecConstantFalse) value = 0;
        if ((op == kOpConstant || op == kOpSpecConstant) && in.size() == 4) value = in[3];
        if (op == kOpSpecConstantOp && in.size() > 4) value = evaluate(in[3], known(in, 4), known(in, 5), known(in, 6));
        const auto it = given.find(id);
        if (it == given.end()) return;
        const bool truth = op == kOpSpecConstantTrue || op == kOpSpecConstantFalse;
        if (truth || (op == kOpSpecConstant && in.size() == 4)) value = truth ? it->second != 0 : it->second;
    }

    void readFunctions() {
        for (const Words in : instructions(at(globals_, words_.size()))) {
            const size_t begin = size_t(in.data() - words_.data());
            const uint32_t op = opOf(in);
            if (op == kOpFunction) {
                if (in.size() < 5) fail("a short instruction");
                functionOf_[checked(in[2])] = functions_.size();
                functions_.push_back({begin, begin, false, {}});
            }
            if (functions_.empty()) fail("an instruction outside of functions");
            Function& f = functions_.back();
            f.end = begin + in.size();
            if (op == kOpLabel) {
                if (in.size() < 2) fail("a short instruction");
                f.blocks.push_back({begin, begin, checked(in[1]), 0, false, {}});
            }
            if (!f.blocks.empty() && op != kOpFunctionEnd) f.blocks.back().end = f.end;
        }
    }

    void call(uint32_t id) {
        if (id >= names_ || functionOf_[id] == kNone) fail("a call of what is no function");
        Function& f = functions_[functionOf_[id]];
        if (!f.called) called_.push_back(functionOf_[id]);
        f.called = true;
    }

    static Block* find(Function& f, uint32_t label) {
        const auto it = std::find_if(f.blocks.begin(), f.blocks.end(), [&](const Block& b) { return b.label == label; });
        return it == f.blocks.end() ? nullptr : &*it;
    }

    // Visits the live blocks. Blocks stand after those that dominate them, so one round mostly suffices; the next finds nothing new.
    void walk(Function& f) {
        if (f.blocks.empty()) return;
        f.blocks[0].live = true;
        for (bool changed = true; changed;) {
            changed = false;
            for (Block& block : f.blocks) {
                if (!block.live || !block.next.empty()) continue;
                enter(f, block);
                for (const uint32_t label : block.next) {
                    Block* next = find(f, label);
                    if (!next) fail("a branch out of its function");
                    changed = changed || (!next->live && next <= &block);
                    next->live = true;
                }
            }
        }
    }

    void enter(Function& f, Block& block) {
        Words merge;
        for (const Words in : instructions(at(block.begin, block.end))) {
            const uint32_t op = opOf(in);
            if (op == kOpFunctionCall) call(in.size() > 3 ? in[3] : 0);
            if (op == kOpPhi)
                known_[checked(in[2])] = phi(f, block, in);
            else if (const uint32_t id = resultOf(in); id != 0 && in.size() > 3)
                known_[checked(id)] = evaluate(op, known(in, 3), known(in, 4), known(in, 5));
            if (op == kOpSelectionMerge || op == kOpLoopMerge) {
                // Blocks that a merge instruction names must stay, reached or not.
                merge = in;
                block.next.push_back(in[1]);
                if (op == kOpLoopMerge) block.next.push_back(in[2]);
            }
            if (op == kOpBranch) block.next.push_back(in[1]);
            if (op == kOpSwitch)
                for (size_t i = 2; i < in.size(); i += 2) block.next.push_back(in[i]);
            if (op != kOpBranchConditional) continue;
            const Value condition = known(in, 1);
            if (condition && !merge.empty() && opOf(merge) == kOpSelectionMerge) {
                block.taken = *condition ? in[2] : in[3];
                block.next = {block.taken};
            } else {
                block.next.insert(block.next.end(), {in[2], in[3]});
            }
        }
    }

    static bool comesFrom(const Block& from, uint32_t label) {
        return from.live && std::find(from.next.begin(), from.next.end(), label) != from.next.end();
    }
    // Value of a phi: known when all live predecessors give the same value.
    Value phi(Function& f, const Block& block, Words in) const {
        Value value;
        bool first = true;
        for (size_t i = 3; i + 1 < in.size(); i += 2) {
            const Block* from = find(f, in[i + 1]);
            if (!from || from >= &block) return std::nullopt;  // predecessor of a loop: not visited yet
            if (!comesFrom(*from, block.label)) continue;
            const Value here = known(in, i);
            if (!here || (!first && *here != *value)) return std::nullopt;
            value = here;
            first = false;
        }
        return value;
    }

    void forget(Words words, std::vector<bool>& gone) const {
        for (const Words in : instructions(words))
            if (const uint32_t id = resultOf(in)) gone[checked(id)] = true;
    }

    void writeFunction(const Function& f, std::vector<uint32_t>& body, std::vector<bool>& used, std::vector<bool>& gone) const {
        const auto write = [&](Words in) {
            body.insert(body.end(), in.begin(), in.end());
            const uint32_t own = opOf(in) == kOpVariable ? in[2] : 0;
            for (size_t i = 1; i < in.size(); ++i)
                if (in[i] < names_ && in[i] != own) used[in[i]] = true;
        };
        const size_t head = f.blocks.empty() ? f.end : f.blocks[0].begin;
        write(at(f.begin, head));
        for (const Block& block : f.blocks) {
            if (!block.live) {
                forget(at(block.begin, block.end), gone);
                continue;
            }
            for (const Words in : instructions(at(block.begin, block.end))) {
                const uint32_t op = opOf(in);
                if (isDebug(op) || (block.taken && op == kOpSelectionMerge)) continue;
                if (op == kOpPhi) {
                    std::vector<uint32_t> left(in.begin(), in.begin() + 3);
                    for (size_t i = 3; i + 1 < in.size(); i += 2)
                        if (arrives(f, in[i + 1], block.label)) left.insert(left.end(), {in[i], in[i + 1]});
                    left[0] = uint32_t(left.size()) << 16 | kOpPhi;
                    write(left);
                } else if (block.taken && op == kOpBranchConditional) {
                    write(std::array<uint32_t, 2>{2u << 16 | kOpBranch, block.taken});
                } else {
                    write(in);
                }
            }
        }
        if (!f.blocks.empty()) body.push_back(1u << 16 | kOpFunctionEnd);
    }
    // True when live block `from` branches to `to`. A block kept only because a merge instruction names it is no predecessor.
    bool arrives(const Function& f, uint32_t from, uint32_t to) const {
        for (const Block& block : f.blocks) {
            if (block.label != from) continue;
            if (!block.live) return false;
            if (block.taken) return block.taken == to;
            const Words last = instructions(at(block.begin, block.end)).back();
            return std::find(last.begin() + 1, last.end(), to) != last.end();
        }
        return false;
    }

    // Removes function-local variables that no remaining instruction uses.
    void dropVariables(std::vector<uint32_t>& body, const std::vector<bool>& used, std::vector<bool>& gone) const {
        std::vector<uint32_t> left;
        left.reserve(body.size());
        for (const Words in : instructions(body)) {
            if (opOf(in) == kOpVariable && !used[in[2]])
                gone[in[2]] = true;
            else
                left.insert(left.end(), in.begin(), in.end());
        }
        body = std::move(left);
    }

    static constexpr size_t kNone = ~size_t(0);
    std::string_view name_;
    Words words_;
    uint32_t names_ = 0, entry_ = 0;     // names_: all ids are below it
    size_t globals_ = 0;                 // words before the first function
    std::vector<bool> isType_, isWord_;  // isWord_: truth values and integers of 32 bits
    std::vector<Value> known_;
    std::vector<size_t> functionOf_;  // index into functions_ by id
    std::vector<Function> functions_;
    std::vector<size_t> called_;
};

}  // namespace

std::vector<uint32_t> foldConstants(const Module& module, const ConstantsById& constants) { return Folder(module, constants).words(); }

}  // namespace plumb
