// SPDX-License-Identifier: MIT
#include "pipeline/command/matrix_steps.h"

#include "host/error.h"
#include "pipeline/scene/text.h"
#include "pipeline/transform/vector.h"

#include <fmt/core.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/glm.hpp>
#include <string_view>
#include <utility>

namespace plumb {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr const char* kWordsInSpace = "translate, scale, rotate_x, rotate_y, rotate_z, rotate, matrix";
constexpr const char* kWordsInPlane = "translate, scale, rotate, matrix";

// Parts of one word. Parts that nothing reads are refused by finish().
class Word {
public:
    Word(std::string text, size_t number) : text_(std::move(text)), number_(number) {
        std::string_view rest = text_;
        while (!rest.empty()) {
            const std::string_view piece = rest.substr(0, rest.find(':'));
            rest.remove_prefix(std::min(rest.size(), piece.size() + 1));
            const size_t equals = piece.find('=');
            if (equals == std::string_view::npos || equals == 0) refuse(fmt::format("'{}' is not part=value", printable(piece, 60)));
            const std::string key(piece.substr(0, equals));
            for (const Part& part : parts_)
                if (part.key == key) refuse(fmt::format("{} is given twice", printable(key, 40)));
            parts_.push_back({key, piece.substr(equals + 1)});
        }
        if (parts_.empty()) refuse("it is empty");
        parts_[0].read = true;
    }

    [[noreturn]] void refuse(const std::string& why) const {
        throw usageError(fmt::format("matrix: step {} '{}': {}", number_, printable(text_, 120), why));
    }

    const std::string& kind() const { return parts_[0].key; }
    bool has(std::string_view key) const {
        for (const Part& part : parts_)
            if (part.key == key) return true;
        return false;
    }
    std::vector<double> numbers(std::string_view key) {
        for (Part& part : parts_)
            if (part.key == key) {
                part.read = true;
                return numbersOf(part);
            }
        refuse(fmt::format("{}= is missing", key));
    }
    double number(std::string_view key) { return counted(key, 1)[0]; }
    template <class Vector>
    Vector vector(std::string_view key) {
        const std::vector<double> list = counted(key, size_t(Vector::length()));
        Vector v;
        for (int i = 0; i < Vector::length(); ++i) v[i] = list[size_t(i)];
        return v;
    }
    template <class Vector>
    Vector factors() {  // one for all axes, or one an axis
        const std::vector<double> list = numbers(kind());
        return list.size() == 1 ? Vector(list[0]) : vector<Vector>(kind());
    }
    void finish() const {
        for (const Part& part : parts_)
            if (!part.read) refuse(fmt::format("{} does not go with {}", printable(part.key, 40), printable(kind(), 40)));
    }

private:
    struct Part {
        std::string key;
        std::string_view value;
        bool read = false;
    };
    std::vector<double> numbersOf(const Part& part) const {
        std::vector<double> list;
        std::string_view rest = part.value;
        for (bool more = true; more;) {
            std::string_view word = rest.substr(0, rest.find(','));
            more = word.size() < rest.size();
            rest.remove_prefix(std::min(rest.size(), word.size() + 1));
            if (!word.empty() && word.front() == '+') word.remove_prefix(1);
            double value = 0;
            const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
            if (word.empty() || error != std::errc() || end != word.data() + word.size() || !(std::abs(value) <= kMaxCoordinate))
                refuse(fmt::format("{}: '{}' is not a finite number of at most 2^100", part.key, printable(word, 40)));
            list.push_back(value);
        }
        return list;
    }
    std::vector<double> counted(std::string_view key, size_t count) {
        std::vector<double> list = numbers(key);
        if (list.size() != count)
            refuse(fmt::format("{} has {} {}, not {}", key, list.size(), list.size() == 1 ? "number" : "numbers", count));
        return list;
    }

    std::string text_;
    size_t number_;
    std::vector<Part> parts_;
};

template <class Point, class StepN>
std::vector<StepN> inPlaceOrNot(Word& word, const StepN& step) {
    if (!word.has("about")) return {step};
    return aboutSteps(word.vector<Point>("about"), step);
}

std::vector<Step3> spaceSteps(Word& word) {
    const std::string& kind = word.kind();
    if (kind == "translate") return {translateStep(word.vector<dvec3>(kind))};
    if (kind == "scale") return inPlaceOrNot<dvec3>(word, scaleStep(word.factors<dvec3>()));
    if (kind == "rotate_x") return inPlaceOrNot<dvec3>(word, rotateXStep(word.number(kind)));
    if (kind == "rotate_y") return inPlaceOrNot<dvec3>(word, rotateYStep(word.number(kind)));
    if (kind == "rotate_z") return inPlaceOrNot<dvec3>(word, rotateZStep(word.number(kind)));
    if (kind == "rotate" && word.has("from")) {
        const dvec3 from = word.vector<dvec3>("from"), to = word.vector<dvec3>("to");
        std::vector<Step3> steps = lineSteps(from, to, word.number(kind));
        if (steps.empty()) word.refuse("to is the same point as from: two equal points have no line");
        return steps;
    }
    if (kind == "rotate") {
        const dvec3 axis = word.vector<dvec3>("axis");
        if (largestMagnitude(axis) == 0) word.refuse("axis is the zero vector");
        const Step3 step = rotateStep(unitVector(axis), word.number(kind));
        return word.has("through") ? aboutSteps(word.vector<dvec3>("through"), step) : std::vector{step};
    }
    if (kind == "matrix") {
        const std::vector<double> list = word.numbers(kind);
        if (list.size() != 16) word.refuse(fmt::format("matrix has {} numbers, not 16", list.size()));
        if (list[12] != 0 || list[13] != 0 || list[14] != 0 || list[15] != 1) word.refuse("matrix: the last row is not 0, 0, 0, 1");
        double rows[16];
        std::copy(list.begin(), list.end(), rows);
        return {matrixStep(fromRows(rows))};
    }
    word.refuse(fmt::format("'{}' is not a step; steps: {}", printable(kind, 40), kWordsInSpace));
}

std::vector<Step2> planeSteps(Word& word) {
    const std::string& kind = word.kind();
    if (kind == "translate") return {translateStep(word.vector<dvec2>(kind))};
    if (kind == "scale") return inPlaceOrNot<dvec2>(word, scaleStep(word.factors<dvec2>()));
    if (kind == "rotate") return inPlaceOrNot<dvec2>(word, rotateStep(word.number(kind)));
    if (kind == "matrix") {
        const std::vector<double> list = word.numbers(kind);
        if (list.size() != 9) word.refuse(fmt::format("matrix has {} numbers, not 9", list.size()));
        if (list[6] != 0 || list[7] != 0 || list[8] != 1) word.refuse("matrix: the last row is not 0, 0, 1");
        double rows[9];
        std::copy(list.begin(), list.end(), rows);
        return {matrixStep(fromRows(rows))};
    }
    word.refuse(fmt::format("'{}' is not a step of the plane; steps: {}", printable(kind, 40), kWordsInPlane));
}

template <class StepN>
std::vector<StepN> steps(const std::vector<std::string>& words, std::vector<StepN> (*read)(Word&)) {
    std::vector<StepN> chain;
    for (size_t i = 0; i < words.size(); ++i) {
        Word word(words[i], i + 1);
        const std::vector<StepN> next = read(word);
        word.finish();
        chain.insert(chain.end(), next.begin(), next.end());
    }
    return chain;
}

}  // namespace

std::vector<Step3> stepsInSpace(const std::vector<std::string>& words) { return steps(words, spaceSteps); }
std::vector<Step2> stepsInPlane(const std::vector<std::string>& words) { return steps(words, planeSteps); }

}  // namespace plumb
