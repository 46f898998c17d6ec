// SPDX-License-Identifier: MIT
#include "pipeline/scene/toml_values.h"

#include "pipeline/scene/colour.h"
#include "pipeline/transform/vector.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>

namespace plumb::scene_file {

using glm::dvec3;

namespace {

// Linear value of an encoded sRGB channel, both 0 to 1 (IEC 61966-2-1): v^2.4 = v^2 (v^(1/5))^2, the root by Newton, with + - * / only.
// From 1 the iteration falls monotonically to the root, 0.6 or more, in fewer than 32 steps.
float linearOfSrgb(double encoded) {
    if (encoded <= 0.04045) return float(encoded / 12.92);
    const double v = (encoded + 0.055) / 1.055;
    double root = 1;
    for (int i = 0; i < 32; ++i) root = (4 * root + v / (root * root * root * root)) / 5;
    return float(v * v * root * root);
}

}  // namespace

const char* kindOf(const toml::node& node) {
    switch (node.type()) {
        case toml::node_type::table:
            return "a table";
        case toml::node_type::array:
            return "an array";
        case toml::node_type::string:
            return "a string";
        case toml::node_type::integer:
            return "an integer";
        case toml::node_type::floating_point:
            return "a number";
        case toml::node_type::boolean:
            return "a boolean";
        default:
            return "a date or time";
    }
}

// Refuses deep dotted keys. toml++ limits nested values itself, but not the parts of a dotted key, and frees its tables recursively.
void TomlValues::refuseDeepKeys(std::string_view text) const {
    enum { bare, comment, basic, literal, basicBlock, literalBlock } state = bare;
    size_t line = 1, lineStart = 0;
    int dots = 0;
    const auto startsBlock = [&](size_t i, char quote) { return i + 2 < text.size() && text[i + 1] == quote && text[i + 2] == quote; };
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        switch (state) {
            case bare:
                if (c == '#')
                    state = comment;
                else if (c == '"' || c == '\'') {
                    const bool block = startsBlock(i, c);
                    state = c == '"' ? (block ? basicBlock : basic) : (block ? literalBlock : literal);
                    if (block) i += 2;
                } else if (c == '.') {
                    if (++dots > kMaxDepth)
                        throw inputError(locationOfLine(path_, line, i - lineStart + 1),
                                         fmt::format("a key of more than {} parts", kMaxDepth));
                } else if (c == '=' || c == ',' || c == '[' || c == ']' || c == '{' || c == '}') {
                    dots = 0;
                }
                break;
            case comment:
                break;
            case basic:
            case literal:
                if (c == '\\' && state == basic)
                    ++i;
                else if (c == (state == basic ? '"' : '\''))
                    state = bare;
                break;
            case basicBlock:
            case literalBlock:
                if (c == '\\' && state == basicBlock)
                    ++i;
                else if (c == (state == basicBlock ? '"' : '\'') && startsBlock(i, c)) {
                    i += 2;
                    state = bare;
                }
                break;
        }
        if (i < text.size() && text[i] == '\n') {
            ++line;
            lineStart = i + 1;
            dots = 0;
            if (state == comment || state == basic || state == literal) state = bare;
        }
    }
}

void TomlValues::allowKeys(const toml::table& table, std::string_view what, const Known& known) const {
    for (const auto& [key, node] : table) {
        (void)node;
        if (std::find(known.begin(), known.end(), key.str()) == known.end())
            throw inputError(location(key.source()),
                             fmt::format("unknown key '{}' in {}{}", printable(key.str(), 64), what, suggestion(key.str(), known)));
    }
}

const toml::node& TomlValues::required(const toml::table& table, std::string_view key, const std::string& what) const {
    const toml::node* node = table.get(key);
    if (!node) refuse(table, fmt::format("{} has no '{}'", what, key));
    return *node;
}

const toml::table& TomlValues::tableOf(const toml::node& node, const std::string& field) const {
    if (const toml::table* table = node.as_table()) return *table;
    refuse(node, fmt::format("{} is {}, not a table", field, kindOf(node)));
}

const toml::array& TomlValues::arrayOf(const toml::node& node, const std::string& field) const {
    if (const toml::array* array = node.as_array()) return *array;
    refuse(node, fmt::format("{} is {}, not an array", field, kindOf(node)));
}

std::string TomlValues::stringOf(const toml::node& node, const std::string& field) const {
    if (const auto* text = node.as_string()) return text->get();
    refuse(node, fmt::format("{} is {}, not a string", field, kindOf(node)));
}

bool TomlValues::booleanOf(const toml::node& node, const std::string& field) const {
    if (const auto* value = node.as_boolean()) return value->get();
    refuse(node, fmt::format("{} is {}, not true or false", field, kindOf(node)));
}

int64_t TomlValues::integerOf(const toml::node& node, const std::string& field, int64_t least, int64_t most) const {
    const auto* value = node.as_integer();
    if (!value) refuse(node, fmt::format("{} is {}, not an integer", field, kindOf(node)));
    if (value->get() < least || value->get() > most)
        refuse(node, fmt::format("{} is {}, outside {} to {}", field, value->get(), least, most));
    return value->get();
}

double TomlValues::numberOf(const toml::node& node, const std::string& field) const {
    if (const auto* integer = node.as_integer()) return double(integer->get());
    const auto* value = node.as_floating_point();
    if (!value) refuse(node, fmt::format("{} is {}, not a number", field, kindOf(node)));
    if (std::isnan(value->get())) refuse(node, field + " is NaN");
    if (std::isinf(value->get())) refuse(node, field + " is infinite");
    return value->get();
}

// Text of a number outside its range: six digits, or as many as it takes to be outside (1000001 is not 1e+06).
static std::string numberOutside(double value, double least, double most) {
    const std::string text = fmt::format("{:g}", value);
    double shown = 0;
    std::from_chars(text.data(), text.data() + text.size(), shown);
    return shown < least || shown > most ? text : fmt::format("{}", value);
}

double TomlValues::numberOf(const toml::node& node, const std::string& field, double least, double most) const {
    const double value = numberOf(node, field);
    if (value < least || value > most)
        refuse(node, fmt::format("{} is {}, outside {:g} to {:g}", field, numberOutside(value, least, most), least, most));
    return value;
}

dvec3 TomlValues::vectorOf(const toml::node& node, const std::string& field) const {
    const toml::array& array = arrayOf(node, field);
    if (array.size() != 3) refuse(node, fmt::format("{} has {} numbers, not 3", field, array.size()));
    dvec3 v;
    for (int i = 0; i < 3; ++i) v[i] = numberOf(array[size_t(i)], fmt::format("{}[{}]", field, i), -kMaxCoordinate, kMaxCoordinate);
    return v;
}

// Direction of any length but zero.
dvec3 TomlValues::axisOf(const toml::node& node, const std::string& field) const {
    const dvec3 v = vectorOf(node, field);
    if (largestMagnitude(v) == 0) refuse(node, field + " is the zero vector");
    return v;
}

// Colour of inks, { cmy = [c, m, y] } or { cmyk = [c, m, y, k] }: they leave (1 - C) (1 - K) of the encoded red, and so on.
glm::vec3 TomlValues::inkOf(const toml::table& table, const std::string& field) const {
    allowKeys(table, field, {"cmy", "cmyk"});
    const bool black = table.contains("cmyk");
    if (table.size() != 1)
        refuse(table, fmt::format("{} holds {} inks; write {{ cmy = [c, m, y] }} or {{ cmyk = [c, m, y, k] }}", field, table.size()));
    const std::string name = field + (black ? ".cmyk" : ".cmy");
    const toml::node& node = *table.get(black ? "cmyk" : "cmy");
    const toml::array& array = arrayOf(node, name);
    const size_t count = black ? 4 : 3;
    if (array.size() != count) refuse(node, fmt::format("{} has {} numbers, not {}", name, array.size(), count));
    double ink[4] = {};
    for (size_t i = 0; i < count; ++i) ink[i] = numberOf(array[i], fmt::format("{}[{}]", name, i), 0, 1);
    const dvec3 rgb = rgbFromCmyk(Cmyk{ink[0], ink[1], ink[2], ink[3]});
    return {linearOfSrgb(rgb.r), linearOfSrgb(rgb.g), linearOfSrgb(rgb.b)};
}

// Colour: one number for grey, three for linear RGB, "#rrggbb" for sRGB as in every colour picker, or inks.
glm::vec3 TomlValues::colourOf(const toml::node& node, const std::string& field, double most) const {
    if (const auto* text = node.as_string()) {
        const std::optional<Rgb8> rgb = rgbOfHex(text->get());
        if (!rgb) refuse(node, fmt::format("{} is '{}', not a number, [r, g, b] or \"#rrggbb\"", field, printable(text->get(), 40)));
        return {linearOfSrgb((*rgb)[0] / 255.0), linearOfSrgb((*rgb)[1] / 255.0), linearOfSrgb((*rgb)[2] / 255.0)};
    }
    if (const auto* table = node.as_table()) return inkOf(*table, field);
    if (!node.is_array()) return glm::vec3(float(numberOf(node, field, 0, most)));
    const toml::array& array = *node.as_array();
    if (array.size() != 3) refuse(node, fmt::format("{} has {} numbers, not 3", field, array.size()));
    glm::vec3 colour;
    for (int i = 0; i < 3; ++i) colour[i] = float(numberOf(array[size_t(i)], fmt::format("{}[{}]", field, i), 0, most));
    return colour;
}

}  // namespace plumb::scene_file
