// SPDX-License-Identifier: MIT
// SHA-256 (FIPS 180-4). Pictures are compared by the hash of their pixels, never of a file's bytes; inputs are named by the hash of their
// bytes.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace plumb {

// Form of the computation. `fastest`: the processor's own instructions where it has them. `portable`: plain C++. Both give the same hash.
enum class Sha256Form { fastest, portable };
std::string sha256Hex(std::span<const std::byte> bytes, Sha256Form form = Sha256Form::fastest);
bool processorHasSha256();

}  // namespace plumb
