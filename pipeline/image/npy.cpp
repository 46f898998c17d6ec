// SPDX-License-Identifier: MIT
// NumPy's .npy, format version 1.0 (numpy.lib.format): magic, version, length of the header, a Python literal, the array in C order.
#include "host/error.h"
#include "pipeline/image/image.h"

#include <fmt/core.h>
#include <bit>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace plumb {

static_assert(std::endian::native == std::endian::little, "planes are written as they lie in memory, as '<f4' and '<u4'");

std::vector<std::byte> encodeNpy(const Frame& frame, Plane plane) {
    const char* type = "<f4";
    int channels = 1;
    std::span<const std::byte> data;
    switch (plane) {
        case kPlaneColour:
            type = "|u1", channels = 4, data = std::as_bytes(std::span(frame.rgba));
            break;
        case kPlaneLinear:
            channels = 3, data = std::as_bytes(std::span(frame.linear));
            break;
        case kPlaneDepth:
            data = std::as_bytes(std::span(frame.depth));
            break;
        case kPlaneDistance:
            data = std::as_bytes(std::span(frame.distance));
            break;
        case kPlaneNormal:
            channels = 3, data = std::as_bytes(std::span(frame.normal));
            break;
        case kPlaneObject:
            type = "<u4", data = std::as_bytes(std::span(frame.object));
            break;
        case kPlanePrimitive:
            type = "<u4", data = std::as_bytes(std::span(frame.primitive));
            break;
        case kPlaneZ:
            data = std::as_bytes(std::span(frame.z));
            break;
        case kPlaneTriangle:
            type = "<u4", data = std::as_bytes(std::span(frame.triangle));
            break;
    }
    const size_t elementBytes = type[2] == '1' ? 1 : 4;
    PLUMB_ASSERT(data.size() == size_t(frame.width) * frame.height * size_t(channels) * elementBytes);
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
