// SPDX-License-Identifier: MIT
// A choice that a picture offers, as a row: the word that people write, its value, and what it does. Whatever reads or prints a word walks these
// rows: the command line with its help and completions, scene files, messages, reports and measurements.
#pragma once

#include "host/error.h"

#include <string>
#include <string_view>
#include <vector>

namespace plumb {

// What holds between the device's picture and the twin's (docs/accuracy.md, Verdicts).
enum class Verdict { bits, bounded, free };

template <class Value>
struct Choice {
    const char* word;
    Value value;
    const char* help;        // what it does, half a sentence
    const char* bound = "";  // how far it may be from what it stands for; empty where no such bound is known
    Verdict verdict = Verdict::bits;
    const char* alias = "";  // a second word that is read; never printed for the value
};

inline constexpr Choice<Verdict> kVerdicts[] = {
    {"bits", Verdict::bits, "the same bytes"},
    {"bounded", Verdict::bounded, "within a bound that is derived"},
    {"free", Verdict::free, "nothing is said"},
};

// The row of a word or of its alias. Null: no row has it.
template <class Rows>
constexpr auto choiceOfWord(const Rows& rows, std::string_view word) -> decltype(&rows[0]) {
    for (const auto& row : rows)
        if (!word.empty() && (word == row.word || word == row.alias)) return &row;
    return nullptr;
}

// The row of a value. Every value has one.
template <class Rows, class Value>
constexpr auto choiceOfValue(const Rows& rows, const Value& value) -> decltype((rows[0])) {
    for (const auto& row : rows)
        if (row.value == value) return row;
    PLUMB_ASSERT(!"every value has a row");
    return rows[0];
}

template <class Rows, class Value>
constexpr const char* wordOf(const Rows& rows, const Value& value) {
    return choiceOfValue(rows, value).word;
}

template <class Rows>
std::vector<const char*> wordsIn(const Rows& rows) {
    std::vector<const char*> words;
    for (const auto& row : rows) words.push_back(row.word);
    return words;
}

// What a row says of itself: "what it does: its bound".
template <class Row>
std::string helpOf(const Row& row) {
    return std::string(row.help) + (row.bound[0] == '\0' ? "" : ": ") + row.bound;
}

inline const char* nameOf(Verdict verdict) { return wordOf(kVerdicts, verdict); }

}  // namespace plumb
