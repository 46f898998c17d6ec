// SPDX-License-Identifier: MIT
// An embedded SPIR-V module. This header has nothing else, because every generated source includes it.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace plumb {

// One embedded module; the generated header <spirv/NAME.h> defines `plumb::spirv::NAME` of this type.
struct Module {
    std::string_view name;  // stem of the .comp
    std::span<const uint32_t> words;
    std::string_view sha256;  // SHA-256 of the words, hex
};

}  // namespace plumb
