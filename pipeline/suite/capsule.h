// SPDX-License-Identifier: MIT
// A capsule: one dispatch whose result differs from the twin's, as files that need neither the scene nor the passes. docs/capsules.md lists
// them.
#pragma once

#include "host/device.h"
#include "host/replay.h"
#include "pipeline/render/render.h"
#include "pipeline/suite/reduce.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace plumb::suite {

using Json = nlohmann::ordered_json;

inline constexpr const char* kCapsuleSchema = "plumb-capsule-1";
inline constexpr uint64_t kMostCapsuleBytes = uint64_t(256) << 20;  // of one file

// Where the compared values of the device lie in what the dispatch left.
struct Location {
    uint32_t binding = 0;  // index into DispatchRecord::bindings
    uint64_t offset = 0;   // bytes
};

struct Capsule {
    DispatchRecord dispatch;  // with what the device left, or the failure
    std::string pass, what;   // the first mismatch of verify: pass and sentence
    std::string element;      // name of one of the compared values; empty: none were compared
    uint32_t elementBytes = 0;
    std::vector<std::byte> expected, got;  // values of the twin and of the device
    std::optional<Location> location;      // none: the values are made from the dispatch's on the host
    Json about;                            // device, tool, and the picture: for people, and not read back
    std::string triangles;                 // OBJ text of the reduced scene, in the world's coordinates
};

// Draws the picture on both sides, dispatch by dispatch, and keeps the first dispatch whose result differs. Empty where the sides agree.
std::optional<Capsule> capsuleOf(Device& device, const Reduced& picture, const Json& tool);

// Files of the capsule by name.
std::map<std::string, std::string> filesOf(const Capsule& capsule);
// Reads a folder. Throws Error(input) that names the file, and what is missing, torn or of another program.
Capsule readCapsule(const std::filesystem::path& folder);

// What one run of a capsule left.
enum class Outcome { expected, captured, other, failed };
Outcome outcomeOf(const Capsule& capsule, const DispatchRecord& run);
// SHA-256 over everything that a run left, and its failure.
std::string hashOf(const DispatchRecord& run);
// Index of the first compared value that differs between two of them, and how many do.
struct ValueDifference {
    uint64_t first = 0, differing = 0, count = 0;
};
ValueDifference differenceOf(std::span<const std::byte> a, std::span<const std::byte> b, uint32_t elementBytes);
// Words of a value as hex.
std::string wordsOf(std::span<const std::byte> values, uint64_t index, uint32_t elementBytes);
// The compared values in what a run left; empty without a location.
std::vector<std::byte> valuesOf(const Capsule& capsule, const DispatchRecord& run);

}  // namespace plumb::suite
