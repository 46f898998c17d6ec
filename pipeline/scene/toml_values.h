// SPDX-License-Identifier: MIT
// Values of a scene.toml. Each is checked for kind and range. A refusal is Error(input), one line with file:line:column of the value and
// the path to it, as in "object.transform[2].scale is 0". Internal to the reader of scene.toml.
#pragma once

#include "pipeline/choices/choice.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <toml++/toml.h>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb::scene_file {

inline constexpr int kMaxDepth = 64;  // of keys and of object hierarchies, so that recursion does not overflow the stack

// Suggestion for an unknown word: "; did you mean 'x'?" for a slip of the pen, else "; known: a, b, c".
template <class Names>
std::string suggestion(std::string_view word, const Names& known) {
    std::string list;
    std::string_view nearest;
    size_t least = 1 + std::min<size_t>(word.size(), 64) / 3;
    size_t listed = 0;
    for (std::string_view name : known) {
        if (++listed <= 24) list += (list.empty() ? "" : ", ") + printable(name, 40);
        if (word.size() > 64 || name.size() > 64) continue;
        const size_t distance = editDistance(word, name, Letters::anyCase);
        if (distance <= least) {
            nearest = name;
            least = distance == 0 ? 0 : distance - 1;
        }
    }
    if (!nearest.empty()) return fmt::format("; did you mean '{}'?", printable(nearest, 64));
    return list.empty() ? std::string() : "; known: " + list;
}

// Kind of a value in a refusal: "a string", "an array", ...
const char* kindOf(const toml::node& node);

class TomlValues {
public:
    explicit TomlValues(std::filesystem::path path) : path_(std::move(path)) {}

protected:
    using Known = std::initializer_list<std::string_view>;

    // Locations and refusals. A field is written as the path to it: "object.transform[2].scale".
    std::string location(const toml::source_region& region) const { return locationOfLine(path_, region.begin.line, region.begin.column); }
    std::string location(const toml::node& node) const { return location(node.source()); }
    [[noreturn]] void refuse(const toml::node& node, const std::string& text) const { throw inputError(location(node), text); }
    void refuseDeepKeys(std::string_view text) const;
    void allowKeys(const toml::table& table, std::string_view what, const Known& known) const;
    const toml::node& required(const toml::table& table, std::string_view key, const std::string& what) const;

    // Typed values. Each refuses a value of another kind or range, with its location.
    const toml::table& tableOf(const toml::node& node, const std::string& field) const;
    const toml::array& arrayOf(const toml::node& node, const std::string& field) const;
    std::string stringOf(const toml::node& node, const std::string& field) const;
    bool booleanOf(const toml::node& node, const std::string& field) const;
    int64_t integerOf(const toml::node& node, const std::string& field, int64_t least, int64_t most) const;
    double numberOf(const toml::node& node, const std::string& field) const;
    double numberOf(const toml::node& node, const std::string& field, double least, double most) const;
    glm::dvec3 vectorOf(const toml::node& node, const std::string& field) const;
    glm::dvec3 axisOf(const toml::node& node, const std::string& field) const;
    glm::vec3 colourOf(const toml::node& node, const std::string& field, double most) const;
    glm::vec3 inkOf(const toml::table& table, const std::string& field) const;
    template <class T>
    T choiceOf(const toml::node& node, const std::string& field, std::initializer_list<std::pair<std::string_view, T>> choices) const;
    // The value of a word of a table of choices (pipeline/choices).
    template <class Rows>
    auto chosenOf(const toml::node& node, const std::string& field, const Rows& rows) const -> decltype(rows[0].value);
    template <class Read>
    void eachTable(const toml::table& parent, std::string_view key, const std::string& field, Read read) const;

    const std::filesystem::path path_;
};

template <class T>
T TomlValues::choiceOf(const toml::node& node, const std::string& field,
                       std::initializer_list<std::pair<std::string_view, T>> choices) const {
    const std::string word = stringOf(node, field);
    std::vector<std::string_view> known;
    for (const auto& [name, value] : choices) {
        if (word == name) return value;
        known.push_back(name);
    }
    refuse(node, fmt::format("{} is '{}'{}", field, printable(word, 40), suggestion(word, known)));
}

template <class Rows>
auto TomlValues::chosenOf(const toml::node& node, const std::string& field, const Rows& rows) const -> decltype(rows[0].value) {
    const std::string word = stringOf(node, field);
    if (const auto* row = choiceOfWord(rows, word)) return row->value;
    refuse(node, fmt::format("{} is '{}'{}", field, printable(word, 40), suggestion(word, wordsIn(rows))));
}

template <class Read>
void TomlValues::eachTable(const toml::table& parent, std::string_view key, const std::string& field, Read read) const {
    const toml::node* node = parent.get(key);
    if (!node) return;
    if (!node->is_array()) refuse(*node, fmt::format("{0} is {1}; write [[{0}]]", field, kindOf(*node)));
    for (const toml::node& element : *node->as_array()) read(tableOf(element, field));
}

}  // namespace plumb::scene_file
