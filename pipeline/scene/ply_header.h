// SPDX-License-Identifier: MIT
// Header of a PLY file (Turk, "The PLY Polygon File Format", 1994): elements, their properties, and what each is to us.
#pragma once

#include "pipeline/scene/text.h"
#include "pipeline/scene/tolerance.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace plumb::ply {

enum class Type : uint8_t { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

inline constexpr size_t kTypeBytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
// Range of the integer types, as far as binary64 tells it.
inline constexpr double kLeast[] = {-128, 0, -32768, 0, -2147483648.0, 0, -9223372036854775808.0, 0};
inline constexpr double kMost[] = {127, 255, 32767, 65535, 2147483647.0, 4294967295.0, 9223372036854775807.0, 18446744073709551615.0};

inline bool isReal(Type type) { return type == Type::float32 || type == Type::float64; }

// Role of a property for us. kStrips: the list of a `tristrips` element.
enum Role { kX, kY, kZ, kNormalX, kNormalY, kNormalZ, kRed, kGreen, kBlue, kScalarRoles, kIndices = kScalarRoles, kStrips, kSkipped };

struct Property {
    std::string name;
    Type type = Type::float32;  // type of the scalar, or of the list's items
    Type countType = Type::uint8;
    bool list = false;
    Role role = kSkipped;
};

struct Element {
    std::string name;
    uint64_t count = 0;
    const char* countAt = nullptr;  // position in the header, for a refusal
    std::vector<Property> properties;
};

struct Header {
    bool ascii = false, swap = false;  // swap: the other byte order than ours
    std::vector<Element> elements;
    std::array<bool, kSkipped> has{};  // by role
    size_t bodyOffset = 0;             // of the first byte behind the header
    bool has3(Role first) const { return has[first] && has[first + 1] && has[first + 2]; }
};

// Reads the header and leaves `in` behind its last line. Lines that are no statement are passed over. `ignore` is called for each kind of
// what no pass draws.
Header readHeader(Scanner& in, std::string_view text, Tolerance& tolerance, const std::function<void(const std::string&)>& ignore);

}  // namespace plumb::ply
