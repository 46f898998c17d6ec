// SPDX-License-Identifier: MIT
// zlib stream of the rows of a picture, compressed by all threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace plumb {

// Pieces that, one after another, are the stream (RFC 1950). fillRow(y, to) writes the `rowBytes` bytes of row y; it is called from several
// threads, once a row. The cuts depend on `rowBytes` alone, so threads change no byte. Throws Error(failed) without memory.
std::vector<std::vector<std::byte>> zlibStrips(uint32_t rows, size_t rowBytes, int level,
                                               const std::function<void(uint32_t, unsigned char*)>& fillRow);

}  // namespace plumb
