// SPDX-License-Identifier: MIT
// NumPy's .npy, format version 1.0 (numpy.lib.format): magic, version, length of the header, a Python literal, the array in C order.
#include "host/error.h"
#include "pipeline/image/image.h"

#include <fmt/core.h>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace plumb {

static_assert(std::endian::native == std::endian::little, "planes are written as they lie in memory, as '<f4' and '<u4'");

std::vector<std::byte> encodeNpy(const Frame& frame, Plane plane) {
    const char* type = "|u1";
    uint32_t channels = 4;  // bytes of a colour
    std::span<const std::byte> data = std::as_bytes(std::span(frame.rgba));
    forEachPlane([&](const auto& row, auto values) {
        if (row.plane != plane || plane == kPlaneColour) return;
        type = std::is_same_v<decltype(row.undrawn), float> ? "<f4" : "<u4";
        channels = row.channels;
        data = std::as_bytes(std::span(frame.*values));
    });
    const size_t elementBytes = type[2] == '1' ? 1 : 4;
    PLUMB_ASSERT(data.size() == size_t(frame.width) * frame.height * channels * elementBytes);
    const std::string shape = channels == 1 ? fmt::format("({}, {})", frame.height, frame.width)
                                            : fmt::format("({}, {}, {})", frame.height, frame.width, channels);
    std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type, shape);
    constexpr size_t kPrefix = 10;  // the array begins at a multiple of 64; the header ends in a newline
    header.append((64 - (kPrefix + header.size() + 1) % 64) % 64, ' ');
    header += '\n';
    std::string prefix("\x93NUMPY\x01\x00", 8);
    prefix += char(header.size() & 0xff);
    prefix += char(header.size() >> 8);
    std::vector<std::byte> bytes(kPrefix + header.size() + data.size());
    std::memcpy(bytes.data(), prefix.data(), kPrefix);
    std::memcpy(bytes.data() + kPrefix, header.data(), header.size());
    if (!data.empty()) std::memcpy(bytes.data() + kPrefix + header.size(), data.data(), data.size());
    return bytes;
}

}  // namespace plumb
