// SPDX-License-Identifier: MIT
// SHA-256 (FIPS 180-4): a picture is compared by its pixels' hash, never by its file's bytes; inputs are named by theirs.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace plumb {

std::string sha256Hex(std::span<const std::byte> bytes);

}  // namespace plumb
