// SPDX-License-Identifier: MIT
// A fingerprint as JSON, and two of them against each other. Answers are kept as their difference to what is expected, so a file holds all of
// them and stays small; whoever reads it makes the questions again.
#pragma once

#include "pipeline/fingerprint/fingerprint.h"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace plumb::fingerprint {

using Json = nlohmann::ordered_json;

inline constexpr const char* kSchema = "plumb-fingerprint-1";

// Object of `plumb devices --fingerprint --json` (docs/outputs.md). `findings` are those of the answers, in the order of traits().
Json jsonOf(const Fingerprint&, std::span<const Finding> findings, const Json& tool);
// Reads a file's text. Throws Error(input) naming `path` and what is missing, torn or of another version.
Fingerprint fingerprintOf(const std::string& path, const std::string& text);

// Words of answers as text: differences, zigzag, runs of zeros, base64.
std::string packed(std::span<const uint32_t> words, std::span<const uint32_t> expected);
// False unless the text is that of as many words as are expected.
bool unpack(const std::string& text, std::span<const uint32_t> expected, std::vector<uint32_t>& words);

// One trait that two devices answer differently.
struct Difference {
    std::string trait, what, planes;
    uint64_t differing = 0;   // answers; of a sweep: blocks
    std::string question;     // first of them, as words to read
    std::string left, right;  // both answers
    std::string allowance;
    bool leftAllowed = true, rightAllowed = true;
};
std::vector<Difference> differences(const Fingerprint& left, const Fingerprint& right);

// A question as words to read: "x 3f800000 (1), y 40000000 (2)", and an answer.
std::string questionText(const Trait&, const Question&);
std::string answerText(const Trait&, uint32_t answer);
std::string floatText(uint32_t bits);  // "3f800000 (1)"
std::string ulpText(uint64_t error);   // "0.500"; "no promise" for kNoPromise

}  // namespace plumb::fingerprint
