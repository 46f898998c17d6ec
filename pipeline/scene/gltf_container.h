// SPDX-License-Identifier: MIT
// Container of a glTF: the bytes of a .gltf or .glb, the JSON in them, and the binary chunk.
#pragma once

#include "pipeline/scene/gltf_value.h"
#include "pipeline/scene/load.h"

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace plumb::gltf {

class Container {
public:
    Container(const std::filesystem::path& path, const LoadOptions& options);  // reads and parses, or refuses
    Container(const Container&) = delete;                                      // values and chunks point into it
    Container& operator=(const Container&) = delete;

    Value root() const { return Value(path_, json_, ""); }
    const std::filesystem::path& path() const { return path_; }
    const std::string& bytes() const { return bytes_; }
    std::optional<std::string_view> binaryChunk() const { return binaryChunk_; }

private:
    std::string_view unpackGlb();
    void refuseDeepJson(std::string_view text) const;
    std::string locationInJson(size_t byte) const;
    void parse(std::string_view text, const LoadOptions& options);

    std::filesystem::path path_;
    std::string bytes_;
    bool isGlb_ = false;
    size_t jsonStart_ = 0;  // of the JSON text in bytes_
    std::optional<std::string_view> binaryChunk_;
    nlohmann::json json_;
};

}  // namespace plumb::gltf
