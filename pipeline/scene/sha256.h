// SPDX-License-Identifier: MIT
// SHA-256 (FIPS 180-4): a picture is compared by its pixels' hash, never by its file's bytes; inputs are named by theirs.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace plumb {

// `fastest`: by the processor's own instructions where it has them. `portable`: plain C++, for all others. Both give the same hash.
enum class Sha256Form { fastest, portable };
std::string sha256Hex(std::span<const std::byte> bytes, Sha256Form form = Sha256Form::fastest);
bool processorHasSha256();

}  // namespace plumb
