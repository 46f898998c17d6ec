// SPDX-License-Identifier: MIT
// Value of a glTF's JSON and the pointer (RFC 6901) that leads to it. Every refusal names the pointer.
#pragma once

#include <fmt/core.h>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb::gltf {

// The file's path and its JSON must outlive the value.
class Value {
public:
    Value(const std::filesystem::path& file, const nlohmann::json& node, std::string pointer)
        : file_(&file), node_(&node), pointer_(std::move(pointer)) {}

    [[noreturn]] void refuse(std::string_view text) const;
    std::string location() const;

    std::optional<Value> find(const char* key) const;  // of an object
    Value required(const char* key) const;
    std::vector<Value> list(const char* key) const;  // the array `key` of this object; an absent one is empty
    size_t size() const;                             // of an array
    Value element(size_t i) const;
    std::vector<std::string> keys() const;

    double number(double least, double most) const;      // finite
    uint64_t whole(uint64_t most) const;                 // also where it is written as 3.0
    size_t index(size_t count, const char* what) const;  // into `count` things named `what`
    const std::string& text() const;
    bool boolean() const;
    template <size_t N>
    std::array<double, N> numbers(double least, double most) const {
        std::array<double, N> values;
        for (size_t i = 0; i < N; ++i) values[i] = elementOf(i, N).number(least, most);
        return values;
    }
    Value elementOf(size_t i, size_t count) const;  // of an array of `count` numbers
    bool isObject() const;

private:
    void wanted(bool is, const char* kind) const;
    std::string described() const;

    const std::filesystem::path* file_;
    const nlohmann::json* node_;
    std::string pointer_;
};

}  // namespace plumb::gltf
