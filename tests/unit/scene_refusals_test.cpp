// SPDX-License-Identifier: MIT
// Bad mesh files: exit 3, one line with the place and the field, quickly and without a large allocation; or accepted
// because the file is complete all the same. Never a crash.
#include "host/error.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/text.h"
#include "tests/support/temporary_folder.h"

#include <fmt/core.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>
#include <bit>
#include <cctype>
#include <clocale>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <locale>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using test::TemporaryFolder;
namespace fs = std::filesystem;

// "" when it was accepted, else the message without the folder's name.
std::string refusalOf(const TemporaryFolder& folder, const std::function<void()>& load) {
    std::string message;
    try {
        load();
        return "";
    } catch (const Error& error) {
        EXPECT_EQ(error.exit(), Exit::input) << error.what();
        message = error.what();
    }
    EXPECT_EQ(message.find('\n'), std::string::npos) << "one line: " << message;
    const std::string prefix = folder.path().string() + "/";
    for (size_t at; (at = message.find(prefix)) != std::string::npos;) message.erase(at, prefix.size());
    return message;
}

// Thousands of small files. A disk would take milliseconds for each; these are in memory, under a name in a folder.
const TemporaryFolder& scratch() {
    static const TemporaryFolder kFolder;
    return kFolder;
}

fs::path writeScratch(const std::string& name, const std::string& bytes) {
    static std::map<std::string, int> files;
    fs::path path = scratch().path() / name;
    const auto [file, fresh] = files.try_emplace(name, -1);
    if (fresh) {
        file->second = memfd_create(name.c_str(), MFD_CLOEXEC);
        fs::create_symlink(fmt::format("/proc/self/fd/{}", file->second), path);
    }
    if (ftruncate(file->second, 0) != 0 || pwrite(file->second, bytes.data(), bytes.size(), 0) != ssize_t(bytes.size()))
        ADD_FAILURE() << name;
    return path;
}

std::string refusal(const std::string& name, const std::string& bytes, const LoadOptions& options = {}) {
    const fs::path path = writeScratch(name, bytes);
    return refusalOf(scratch(), [&] {
        Scene scene;
        addMeshFile(scene, path, options);
    });
}

// "file:line:column: text" or "file: byte N: text".
bool hasPlace(const std::string& message) {
    size_t at = message.find(':');
    const auto number = [&] {
        const size_t first = at;
        while (at < message.size() && std::isdigit(uint8_t(message[at]))) ++at;
        return at > first;
    };
    const auto text = [&](std::string_view want) {
        const bool there = message.compare(at, want.size(), want) == 0;
        at += there ? want.size() : 0;
        return there;
    };
    if (at == std::string::npos || at == 0) return false;
    if (text(": byte ")) return number() && text(": ") && at < message.size();
    return text(":") && number() && text(":") && number() && text(": ") && at < message.size();
}

template <class T>
void put(std::string& bytes, T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes.append(raw, sizeof(T));
}

const std::string kVertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";  // lines 1 to 3
const std::string kSolid =
    "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n";
const std::string kPlyHeader =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";  // 9 lines
const std::string kPlyBody = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
const std::string kOff = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
    const size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return text.replace(at, what.size(), with);
}

std::string binarySolid() {
    std::string bytes(80, 'h');
    put(bytes, uint32_t(1));
    for (float x : {0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) put(bytes, x);
    put(bytes, uint16_t(0));
    return bytes;
}

std::string binaryPly(bool big = false) {
    std::string bytes = replaced(kPlyHeader, "ascii", big ? "binary_big_endian" : "binary_little_endian");
    const auto order = [&](uint32_t word) { return big ? __builtin_bswap32(word) : word; };
    for (float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) put(bytes, order(std::bit_cast<uint32_t>(x)));
    bytes += char(3);
    for (uint32_t i : {0u, 1u, 2u}) put(bytes, order(i));
    return bytes;
}

struct Bad {
    const char* name;
    std::string bytes;
    const char* message;  // how the message begins: place and field
};

TEST(SceneRefusals, NameThePlaceAndTheField) {
    const std::string longWord(3000, 'x');
    const Bad rows[] = {
        // OBJ
        {"a.obj", "", "a.obj:1:1: the file ends and has no face"},
        {"a.obj", kVertices, "a.obj:4:1: the file ends and has no face"},
        {"a.obj", "v 1 2\n", "a.obj:1:6: vertex z is missing"},
        {"a.obj", "v\n", "a.obj:1:2: vertex x is missing"},
        {"a.obj", "v 1 2 three\n", "a.obj:1:7: vertex z 'three' is not a number"},
        {"a.obj", "v 1,5 2 3\n", "a.obj:1:3: vertex x '1,5' is not a number"},
        {"a.obj", "v 0x10 2 3\n", "a.obj:1:3: vertex x '0x10' is not a number"},
        {"a.obj", "v 1 2 +-3\n", "a.obj:1:7: vertex z '+-3' is not a number"},
        {"a.obj", "\n\n  v 1e31 2 3\n", "a.obj:3:5: vertex x is 1e31; the largest magnitude is"},
        {"a.obj", "v 1 -1e99 3\n", "a.obj:1:5: vertex y is -1e99; the largest magnitude is"},
        {"a.obj", "v nan 2 3\nv 0 0 0\nv 0 1 0\nf 2 3 1\n", "a.obj:1:3: vertex x is NaN"},
        {"a.obj", kVertices + "f 1 2\n", "a.obj:4:6: no face has 3 corners or more: the file has no face"},
        {"a.obj", kVertices + "l 1 2\np 1\n", "a.obj:6:1: the file has only lines (l) and points (p); they are not drawn"},
        {"a.obj", std::string("\xff\xfev\0 \0", 6), "a.obj:1:1: the text is UTF-16; only UTF-8 is read"},
        {"a.obj",
         std::string("v\0 \0"
                     "0\0 \0",
                     8),
         "a.obj:1:1: the text is UTF-16; only UTF-8 is read"},
        {"a.obj", kVertices + "f 1 2 0\n", "a.obj:4:7: face corner: the vertex index is 0"},
        {"a.obj", kVertices + "f 1 2 4\n", "a.obj:4:7: face corner: the vertex index is out of range; 3 are defined"},
        {"a.obj", kVertices + "f 1 2 -4\n", "a.obj:4:7: face corner: the vertex index is out of range; 3 are defined so far"},
        {"a.obj", kVertices + "f 1 2 99999999999999999999\n",
         "a.obj:4:7: face corner '99999999999999999999': the vertex index is not an integer"},
        {"a.obj", kVertices + "f 1 2 4294967295\n", "a.obj:4:7: face corner: the vertex index is out of range"},
        {"a.obj", kVertices + "f 1 2 3.5\n", "a.obj:4:7: face corner '3.5' is not v, v/vt, v//vn or v/vt/vn"},
        {"a.obj", kVertices + "f 1 2 x\n", "a.obj:4:7: face corner 'x': the vertex index is not an integer"},
        {"a.obj", kVertices + "s many\n", "a.obj:4:3: smoothing group 'many' is not an integer"},
        {"a.obj", kVertices + "s -1\n", "a.obj:4:3: smoothing group is out of range"},
        {"a.obj", "\x89PNG\r\n\x1a\n", "a.obj:1:1: '\\x89PNG' is not an OBJ statement"},
        {"a.obj", longWord, "a.obj:1:1: 'xxxxxxxx"},
        {"a.obj", std::string("v 1 2 3\0\n", 9), "a.obj:1:7: vertex z '3\\x00' is not a number"},
        // STL
        {"a.stl", "", "a.stl: byte 0: the file ends inside the header"},
        {"a.stl", "garbage", "a.stl: byte 7: the file ends inside the header"},
        {"a.stl", std::string(84, '\0'), "a.stl: byte 80: facet count is 0"},
        {"a.stl", std::string(80, 'h') + std::string("\xff\xff\xff\xff", 4),
         "a.stl: byte 80: facet count is 4294967295, which takes 214748364834 bytes; the file has 84"},
        {"a.stl", "solid s\nendsolid s\n", "a.stl:3:1: the file ends and has no face"},
        {"a.stl", replaced(kSolid, "outer loop", "outer lop"), "a.stl:3:7: 'lop' where 'loop' is expected"},
        {"a.stl", replaced(kSolid, "vertex 1 0 0", "vertex 1 0"), "a.stl:6:1: vertex z 'vertex' is not a number"},
        {"a.stl", "solid s\n", "a.stl:2:1: the file ends and has no face"},
        {"a.stl", replaced(kSolid, "vertex 0 1 0\n", ""), "a.stl:6:1: no facet has 3 corners or more: the file has no face"},
        {"a.stl", replaced(kSolid, "facet normal 0 0 1\n", ""), "a.stl:2:1: 'outer' where 'facet' or 'endsolid' is expected"},
        {"a.stl", replaced(kSolid, "endloop", "vertex 1 1 1\nendloop"), "a.stl:7:1: 'vertex' where 'endloop' is expected"},
        {"a.stl", replaced(kSolid, "vertex 1 0 0", "vertex 1 -inf 0"), "a.stl:5:10: vertex y is infinite"},
        // OFF
        {"a.off", "", "a.off:1:1: '' is not OFF"},
        {"a.off", "ON\n", "a.off:1:1: 'ON' is not OFF"},
        {"a.off", "4OFF\n", "a.off:1:1: '4OFF' is not OFF"},
        {"a.off", "OFF BINARY\n", "a.off:1:5: binary OFF is not read"},
        {"a.off", "OFF\n", "a.off:2:1: vertex count is missing"},
        {"a.off", "OFF\n3\n", "a.off:2:1: vertex count is 3; the rest of the file holds at most 0"},
        {"a.off", "OFF\n3 # and no more but this comment\n", "a.off:3:1: face count is missing"},
        {"a.off", "OFF\n-3 1 0\n", "a.off:2:1: vertex count is negative"},
        {"a.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", "a.off:2:3: face count is 0"},
        {"a.off", replaced(kOff, "3 1 0", "1000000000 1 0"), "a.off:2:1: vertex count is 1000000000; the rest of the file holds at most 5"},
        {"a.off", replaced(kOff, "3 1 0", "3 1000000000 0"), "a.off:2:3: face count is 1000000000; the rest of the file holds at most 3"},
        {"a.off", replaced(kOff, "0 1 0\n", "0 nan 0\n"), "a.off:5:3: vertex y is NaN"},
        {"a.off", replaced(kOff, "3 0 1 2", "3 0 1 3"), "a.off:6:7: vertex index is 3; there are 3 vertices"},
        {"a.off", replaced(kOff, "3 0 1 2", "3 0 1 -1"), "a.off:6:7: vertex index is -1"},
        {"a.off", replaced(kOff, "3 0 1 2", "2 0 1"), "a.off:7:1: no face has 3 corners or more: the file has no face"},
        {"a.off", replaced(kOff, "3 0 1 2", "999999999999 0 1 2"), "a.off:7:1: vertex index is missing"},
        {"a.off", replaced(replaced(kOff, "OFF", "NOFF"), "0 1 0\n", "0 1 0 0 0\n"), "a.off:"},
        // PLY
        {"a.ply", "", "a.ply:1:1: the file does not begin with 'ply'"},
        {"a.ply", "ply\n", "a.ply:2:1: the file ends inside the header"},
        {"a.ply", "plyx\n", "a.ply:1:1: the file does not begin with 'ply'"},
        {"a.ply", "ply\nend_header\n", "a.ply:2:1: the header has no format"},
        {"a.ply", replaced(kPlyHeader, "ascii", "utf8") + kPlyBody, "a.ply:2:8: format 'utf8' is not ascii"},
        {"a.ply", replaced(kPlyHeader, "1.0", "2.0") + kPlyBody, "a.ply:2:14: format version is not 1.0"},
        {"a.ply", replaced(kPlyHeader, "vertex 3", "vertex three") + kPlyBody, "a.ply:3:16: element count 'three' is not an integer"},
        {"a.ply", replaced(kPlyHeader, "vertex 3", "vertex -3") + kPlyBody, "a.ply:3:16: element count is negative"},
        {"a.ply", replaced(kPlyHeader, "vertex 3", "vertex 4000000000") + kPlyBody,
         "a.ply:3:16: element vertex has a count of 4000000000; the rest of the file holds at most 4"},
        {"a.ply", replaced(kPlyHeader, "face 1", "face 9000000000000000000") + kPlyBody,
         "a.ply:7:14: element face has a count of 9000000000000000000"},
        {"a.ply", replaced(kPlyHeader, "face 1", "face 0") + "0 0 0\n1 0 0\n0 1 0\n", "a.ply:7:14: element face has a count of 0"},
        {"a.ply", replaced(kPlyHeader, "element face 1", "element vertex 1") + kPlyBody, "a.ply:7:9: element 'vertex' is stated twice"},
        {"a.ply", replaced(kPlyHeader, "float y", "float x") + kPlyBody, "a.ply:5:16: property 'x' is stated twice"},
        {"a.ply", replaced(kPlyHeader, "float y", "real y") + kPlyBody, "a.ply:5:10: property type 'real' is not a type of PLY"},
        {"a.ply", replaced(kPlyHeader, "float z", "float w") + kPlyBody, "a.ply:9:1: the header has no element vertex with x, y and z"},
        {"a.ply", replaced(kPlyHeader, "vertex_indices", "indices") + kPlyBody,
         "a.ply:9:1: the header has no element face with a list vertex_indices"},
        {"a.ply", replaced(kPlyHeader, "list uchar int", "list float int") + kPlyBody,
         "a.ply:8:15: list count type is not an integer type"},
        {"a.ply", replaced(kPlyHeader, "list uchar int", "list uchar float") + kPlyBody,
         "a.ply:8:27: property vertex_indices is not a list of integers"},
        {"a.ply", "ply\nformat ascii 1.0\nproperty float x\n", "a.ply:3:1: property comes before the first element"},
        {"a.ply", replaced(kPlyHeader, "format", "formula") + kPlyBody, "a.ply:9:1: the header has no format"},
        {"a.ply", kPlyHeader + "0 0 0\n1 0\n", "a.ply:3:16: element vertex has a count of 3; the rest of the file holds at most 1"},
        {"a.ply", kPlyHeader + "0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n", "a.ply:12:3: vertex 2 property y is NaN"},
        {"a.ply", kPlyHeader + "0 0 0\n1 0 0\n0 1e40 0\n3 0 1 2\n",
         "a.ply:12:3: vertex 2 property y is 1e+40; the largest magnitude is 1.26"},
        {"a.ply", kPlyHeader + "0 0 0\n1 0 0\n0 zero 0\n3 0 1 2\n", "a.ply:12:3: vertex 2 property y 'zero' is not a number"},
        {"a.ply", kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "a.ply:13:7: face 0 property vertex_indices is 3; there are 3 vertices"},
        {"a.ply", kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "a.ply:13:7: face 0 property vertex_indices is negative: -1"},
        {"a.ply", kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "a.ply:7:14: element face has no face of 3 corners or more"},
        {"a.ply", kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n256 0 1 2\n",
         "a.ply:13:1: face 0 property vertex_indices is 256, which its type cannot hold"},
        {"a.ply", kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n", "a.ply:14:1: face 0 property vertex_indices is missing"},
        {"a.ply", replaced(binaryPly(), "vertex 3", "vertex 4000000000"),
         "a.ply:3:16: element vertex has a count of 4000000000; the rest of the file holds at most 4"},
        {"a.ply", binaryPly().substr(0, binaryPly().size() - 1), "a.ply: byte "},
    };
    static_assert(std::size(rows) >= 60);
    for (const Bad& row : rows) {
        const std::string got = refusal(row.name, row.bytes);
        EXPECT_EQ(got.substr(0, std::strlen(row.message)), row.message) << "whole message: " << got;
        EXPECT_TRUE(hasPlace(got)) << got;
        EXPECT_LT(got.size(), 500u) << "long words are cut";
    }
}

TEST(SceneRefusals, OfAMaterialLibraryNameItsOwnPlace) {
    const std::pair<const char*, const char*> rows[] = {
        {"Kd 1 1 1\n", "a.mtl:1:1: 'Kd' comes before newmtl"},
        {"newmtl a\nKd nan 0 0\n", "a.mtl:2:4: Kd red is NaN"},
        {"newmtl a\nKa 0 0\n", "a.mtl:2:7: Ka blue is missing"},
        {"newmtl a\nKs 0 inf 0\n", "a.mtl:2:6: Ks green is infinite"},
        {"newmtl a\nKe 0 0 x\n", "a.mtl:2:8: Ke blue 'x' is not a number"},
        {"newmtl a\nKd 0 -1 0\n", "a.mtl:2:6: Kd green is negative"},
        {"newmtl a\nNs -1\n", "a.mtl:2:4: Ns is negative"},
        {"newmtl a\nNs nan\n", "a.mtl:2:4: Ns is NaN"},
        {"newmtl a\nNi -1\n", "a.mtl:2:4: Ni is negative"},
        {"newmtl a\nNi inf\n", "a.mtl:2:4: Ni is infinite"},
        {"newmtl a\nd\n", "a.mtl:2:2: d is missing"},
        {"newmtl a\nTr nan\n", "a.mtl:2:4: Tr is NaN"},
        {"newmtl a\nd -halo half\n", "a.mtl:2:9: d 'half' is not a number"},
        {"newmtl a\nillum 2.5\n", "a.mtl:2:7: illum '2.5' is not an integer"},
        {"newmtl a\nillum 11\n", "a.mtl:2:7: illum is not in 0 to 10"},
        {"newmtl a\n\x01\n", "a.mtl:2:1: '\\x01' is not an MTL statement"},
    };
    for (const auto& [text, want] : rows) {
        const TemporaryFolder folder;
        folder.write("a.mtl", text);
        const fs::path path = folder.write("a.obj", "mtllib a.mtl\nusemtl a\n" + kVertices + "f 1 2 3\n");
        const std::string got = refusalOf(folder, [&] { readObj(path, {}); });
        EXPECT_EQ(got.substr(0, std::strlen(want)), want) << got;
    }
}

// Row 4 of docs/extremes.md: each numeric field times NaN, infinities and what float32 cannot hold, named with its field.
TEST(SceneRefusals, EveryNumericFieldNamesNanAndInfinity) {
    struct Field {
        const char* name;
        std::string before, after;
        const char* field;
    };
    const Field fields[] = {
        {"a.obj", "v ", " 2 3\n", "vertex x"},
        {"a.obj", "v 1 ", " 3\n", "vertex y"},
        {"a.obj", "v 1 2 ", "\n", "vertex z"},
        {"a.stl", "solid s\nfacet normal 0 0 1 outer loop vertex ", " 0 0\n", "vertex x"},
        {"a.stl", "solid s\nfacet normal 0 0 1 outer loop vertex 0 ", " 0\n", "vertex y"},
        {"a.stl", "solid s\nfacet normal 0 0 1 outer loop vertex 0 0 ", "\n", "vertex z"},
        {"a.off", "OFF 3 1 0\n", " 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "vertex x"},
        {"a.off", "OFF 3 1 0\n0 ", " 0\n1 0 0\n0 1 0\n3 0 1 2\n", "vertex y"},
        {"a.off", "OFF 3 1 0\n0 0 ", "\n1 0 0\n0 1 0\n3 0 1 2\n", "vertex z"},
        {"a.ply", kPlyHeader, " 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "property x"},
        {"a.ply", kPlyHeader + "0 ", " 0\n1 0 0\n0 1 0\n3 0 1 2\n", "property y"},
        {"a.ply", kPlyHeader + "0 0 ", "\n1 0 0\n0 1 0\n3 0 1 2\n", "property z"},
    };
    for (const Field& field : fields)
        for (const char* value : {"nan", "-nan", "NaN", "inf", "-inf", "Infinity", "1e39", "-1e39", "1e31", "1e99999999999999999999"}) {
            const std::string got = refusal(field.name, field.before + value + field.after);
            EXPECT_TRUE(hasPlace(got)) << got;
            EXPECT_NE(got.find(field.field), std::string::npos) << field.before << value << ": " << got;
        }
    // Binary: quiet and signalling NaN of both signs, infinities, and 2^101, in every field.
    const uint32_t patterns[] = {0x7fc00000u, 0xffc00000u, 0x7f800001u, 0xff800001u, 0x7f800000u, 0xff800000u, 0x72000000u};
    for (const uint32_t pattern : patterns) {
        for (size_t number = 3; number < 12; ++number) {
            std::string bytes = binarySolid();
            std::memcpy(bytes.data() + 84 + 4 * number, &pattern, 4);
            const std::string got = refusal("a.stl", bytes);
            const std::string what = fmt::format("vertex {} {}", number / 3, "xyz"[number % 3]);
            EXPECT_TRUE(got.starts_with(fmt::format("a.stl: byte {}: {} is ", 84 + 4 * number, what))) << got;
        }
        for (const bool big : {false, true})
            for (size_t number = 0; number < 9; ++number) {
                std::string bytes = binaryPly(big);
                const size_t at = bytes.find("end_header\n") + 11 + 4 * number;
                const uint32_t raw = big ? __builtin_bswap32(pattern) : pattern;
                std::memcpy(bytes.data() + at, &raw, 4);
                EXPECT_TRUE(refusal("a.ply", bytes)
                                .starts_with(fmt::format("a.ply: byte {}: vertex {} property {} is ", at, number / 3, "xyz"[number % 3])));
            }
    }
}

// Small files of each kind, complete, none with an optional end that a cut could leave valid but different.
std::vector<std::pair<std::string, std::string>> seeds() {
    return {
        {"a.obj", "# c\nmtllib a.mtl\no n\nusemtl m\ns 1\n" + kVertices +
                      "v 1 1 0 1 0 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 -2/1/1\nf -4//-1 -3//1 -1//1 \\\n -2//1\nl 1 2\n"},
        {"a.stl", kSolid + kSolid},
        {"b.stl", binarySolid()},
        {"a.off",
         "# c\nCNOFF # d\n4 2 0\n0 0 0 0 0 1 1 0 0\n1 0 0 0 0 1 1 0 0\n0 1 0 0 0 1 1 0 0\n1 1 1 0 0 1 0.5 0.5 0.5 1\n3 0 1 2\n4 0 1 3 2 "
         "255 0 0\n"},
        {"a.ply",
         replaced(kPlyHeader, "element face", "comment x\nobj_info y\nproperty uchar red\nproperty list uchar double t\nelement face") +
             "0 0 0 9 0\n1 0 0 9 1 0.5\n0 1 0 9 0\n3 0 1 2\n"},
        {"b.ply", binaryPly(false)},
        {"c.ply", binaryPly(true)},
    };
}

// The message of the refusal, "" for a mesh whose every index and normal is sound.
std::string expectRefusedOrSound(const std::string& name, const std::string& bytes, const std::string& what) {
    const fs::path path = writeScratch(name, bytes);
    std::string got = refusalOf(scratch(), [&] {
        Scene scene;
        const TriangleMesh& mesh = scene.meshes.at((addMeshFile(scene, path, {}), 0));
        ASSERT_FALSE(mesh.triangles.empty()) << what;
        for (const auto& t : mesh.triangles)
            for (uint32_t v : t.vertex) ASSERT_LT(v, mesh.positions.size()) << what;
        for (const glm::vec3& n : mesh.normals) ASSERT_NEAR(glm::length(glm::dvec3(n)), 1.0, 4e-7) << what;
    });
    if (!got.empty()) {
        EXPECT_TRUE(hasPlace(got)) << what << ": " << got;
    }
    return got;
}

TEST(SceneRefusals, FilesCutAtEveryByteAreRefusedOrComplete) {
    scratch().write("a.mtl", "newmtl m\nKd 1 0 0\n");
    size_t files = 0, accepted = 0;
    for (const auto& [name, bytes] : seeds()) {
        ASSERT_EQ(refusal(name, bytes), "") << "the seed itself is good";
        for (size_t length = 0; length < bytes.size(); ++length, ++files) {
            const std::string cut = bytes.substr(0, length);
            const std::string got = expectRefusedOrSound(name, cut, fmt::format("{} cut to {} bytes", name, length));
            if (name.ends_with(".obj")) continue;  // has no end that could be missing
            // Other formats say how much there is: accepted is only what lacks white space or a name at the very end.
            if (got.empty()) {
                ++accepted;
                EXPECT_TRUE(bytes.size() - length <= 4 || (name == "a.stl" && cut.find("endfacet") != std::string::npos) ||
                            (name == "a.off" && bytes.size() - length <= 11))
                    << name << " cut to " << length;
            }
        }
    }
    EXPECT_GT(files, 1300u);
    EXPECT_LT(accepted, 80u);
}

TEST(SceneRefusals, FilesWithAnyByteChangedAreRefusedOrSound) {
    scratch().write("a.mtl", "newmtl m\nKd 1 0 0\n");
    size_t files = 0, accepted = 0;
    for (const auto& [name, bytes] : seeds())
        for (size_t at = 0; at < bytes.size(); ++at)
            for (const char with : {'\0', '\xff', '9', '-', '\n', ' '}) {
                std::string changed = bytes;
                changed[at] = with;
                accepted += expectRefusedOrSound(name, changed, fmt::format("{} byte {} is {}", name, at, int(with))).empty();
                ++files;
            }
    EXPECT_GT(files, 7000u);
    EXPECT_GT(accepted, 700u) << "else this test would say little about meshes";
}

TEST(SceneRefusals, HeaderLiesCostNoMemory) {
    struct rusage before, after;
    getrusage(RUSAGE_SELF, &before);
    for (const char* count : {"100000000", "2147483648", "4294967295", "9223372036854775807", "99999999999999999999"}) {
        EXPECT_NE(refusal("a.off", replaced(kOff, "3 1 0", fmt::format("{} 1 0", count))), "");
        EXPECT_NE(refusal("a.off", replaced(kOff, "3 1 0", fmt::format("3 {} 0", count))), "");
        EXPECT_NE(refusal("a.off", replaced(kOff, "3 0 1 2", fmt::format("{} 0 1 2", count))), "");
        EXPECT_NE(refusal("a.ply", replaced(kPlyHeader, "vertex 3", fmt::format("vertex {}", count)) + kPlyBody), "");
        EXPECT_NE(refusal("a.ply", replaced(kPlyHeader, "face 1", fmt::format("face {}", count)) + kPlyBody), "");
        EXPECT_NE(refusal("a.ply", replaced(binaryPly(), "face 1", fmt::format("face {}", count))), "");
        EXPECT_NE(refusal("a.ply", replaced(replaced(kPlyHeader, "list uchar", "list int"), "ascii", "ascii") +
                                       replaced(kPlyBody, "3 0 1 2", fmt::format("{} 0 1 2", count))),
                  "");
        // An element without properties takes no bytes, whatever its count; it must cost no time either.
        EXPECT_EQ(refusal("a.ply", replaced(kPlyHeader, "end_header",
                                            fmt::format("element nothing {}\nend_header",
                                                        std::string(count) == "99999999999999999999" ? "7" : count)) +
                                       kPlyBody),
                  "");
    }
    getrusage(RUSAGE_SELF, &after);
    EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 16 * 1024) << "KiB";
}

TEST(SceneRefusals, HostileTextEndsInGoodTime) {
    std::string manyKinds, deepLine = kVertices + "f", manyMaterials, fan = "v 0 0 0\n";
    for (int i = 0; i < 100; ++i) manyKinds += fmt::format("kind{} 1\n", i);
    EXPECT_NE(refusal("a.obj", manyKinds).find("more than 64 kinds"), std::string::npos);
    // One face of 200,000 corners, all the same three points: no area to triangulate.
    for (int i = 0; i < 200000; ++i) deepLine += fmt::format(" {}", i % 3 + 1);
    // 30,000 faces around one vertex.
    for (int i = 0; i < 30000; ++i) fan += fmt::format("v {} {} 1\n", i % 173, i / 173);
    for (int i = 0; i < 30000; ++i) fan += fmt::format("f 1 {} {}\n", i + 2, (i + 1) % 30000 + 2);
    // A concave face beyond the limit of ear clipping.
    std::string comb;
    for (int i = 0; i < 10000; ++i) comb += fmt::format("v {} {} 0\n", i, i % 2);
    comb += "v 9999 -5 0\nv 0 -5 0\nf";
    for (int i = 10002; i > 0; --i) comb += fmt::format(" {}", i);
    const std::clock_t start = std::clock();
    refusal("a.obj", deepLine);
    EXPECT_EQ(refusal("a.obj", fan), "");
    EXPECT_EQ(refusal("a.obj", comb), "");
    // One beyond it: 100,000 corners whose ears are found late. It is left out, and costs not the file.
    comb.clear();
    for (int i = 0; i < 100000; ++i) comb += fmt::format("v {} {} 0\n", i, i % 2);
    comb += "v 99999 -5 0\nv 0 -5 0\nf";
    for (int i = 100002; i > 0; --i) comb += fmt::format(" {}", i);
    EXPECT_EQ(refusal("a.obj", comb + "\nf 1 2 3\n"), "");
    EXPECT_LT(double(std::clock() - start) / CLOCKS_PER_SEC, 10.0) << "seconds of the processor; sanitizers included";
}

TEST(SceneRefusals, OnlyRegularFilesAreOpened) {
    const TemporaryFolder folder;
    const auto at = [&](const char* name) { return folder.path() / name; };
    ASSERT_EQ(mkfifo(at("fifo.obj").c_str(), 0600), 0);
    fs::create_directory(at("folder.obj"));
    fs::create_symlink("/dev/zero", at("zero.obj"));
    fs::create_symlink("/dev/null", at("null.stl"));
    fs::create_symlink("loop.obj", at("loop.obj"));
    const int socketFd = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, at("socket.obj").c_str(), sizeof(address.sun_path) - 1);
    ASSERT_EQ(bind(socketFd, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    folder.write("large.ply", "ply\n");
    fs::resize_file(at("large.ply"), kMaxFileBytes + 1);  // sparse
    const std::pair<std::string, const char*> rows[] = {
        {"fifo.obj", "fifo.obj: is a FIFO, not a regular file"},
        {"folder.obj", "folder.obj: is a folder, not a regular file"},
        {"zero.obj", "zero.obj: is a device, not a regular file"},
        {"null.stl", "null.stl: is a device, not a regular file"},
        {"socket.obj", "socket.obj: is a socket, not a regular file"},
        {"loop.obj", "loop.obj: Too many levels of symbolic links"},
        {"none.obj", "none.obj: No such file or directory"},
        {"none/none.obj", "none/none.obj: No such file or directory"},
        {"large.ply", "large.ply: has 4294967297 bytes; at most 4294967296 are read"},
        {std::string("nul\0.obj", 8), "nul\\x00.obj: the name has a NUL character"},
        {std::string(4096, 'n') + ".obj", "nnnn"},
        {"\x1b[31mred\x07.obj", "\\x1b[31mred\\x07.obj: No such file or directory"},
    };
    for (const auto& [name, want] : rows) {
        const std::string got = refusalOf(folder, [&, &name = name] {
            Scene scene;
            addMeshFile(scene, folder.path() / name, {});
        });
        // The file name is at the end of a folder's name that printable() may have cut.
        EXPECT_TRUE(got.starts_with(want) || name.size() > 1000) << got;
        EXPECT_NE(got, "") << name;
        EXPECT_LT(got.size(), 400u);
        for (const char c : got) EXPECT_GE(uint8_t(c), 0x20) << got;
    }
    ::close(socketFd);
}

TEST(SceneRefusals, ReferencesStayInTheFolderOfTheFileThatNamesThem) {
    const TemporaryFolder outer;
    const fs::path inside = outer.path() / "inside";
    outer.write("secret.mtl", "newmtl m\nKd 1 0 0\n");
    outer.write("inside/sub/a.mtl", "newmtl m\nKd 1 0 0\n");
    outer.write("inside2/a.mtl", "newmtl m\nKd 1 0 0\n");
    fs::create_symlink(outer.path() / "secret.mtl", inside / "link.mtl");
    fs::create_symlink("sub/a.mtl", inside / "inner.mtl");
    fs::create_symlink(outer.path(), inside / "up");
    fs::create_symlink("/dev/zero", inside / "zero.mtl");
    ASSERT_EQ(mkfifo((inside / "fifo.mtl").c_str(), 0600), 0);
    const auto load = [&](const std::string& library, bool allowOutside) {
        const fs::path path = outer.write("inside/a.obj", "mtllib " + library + "\n" + kVertices + "f 1 2 3\n");
        LoadOptions options;
        options.allowOutside = allowOutside;
        return refusalOf(outer, [&] { readObj(path, options); });
    };
    const std::string longName(4096, 'n');
    for (const std::string& library :
         {std::string("../secret.mtl"), std::string("sub/../../secret.mtl"), std::string("sub/../sub/a.mtl"), std::string("/etc/passwd"),
          (outer.path() / "secret.mtl").string(), std::string("link.mtl"), std::string("up/secret.mtl"), std::string("up/inside2/a.mtl"),
          std::string("zero.mtl"), std::string("..")}) {
        const std::string got = load(library, false);
        EXPECT_TRUE(got.starts_with("inside/a.obj:1:8: material library '")) << library << ": " << got;
        EXPECT_NE(got.find("--allow-outside"), std::string::npos) << got;
    }
    EXPECT_EQ(load("fifo.mtl", false), "inside/fifo.mtl: is a FIFO, not a regular file");
    EXPECT_EQ(load("sub", false), "inside/sub: is a folder, not a regular file");
    for (const char* library : {"sub/a.mtl", "./sub/a.mtl", "inner.mtl", "missing.mtl", "\x1b[2J.mtl"})
        EXPECT_EQ(load(library, false), "") << library;
    for (const char* library : {"../secret.mtl", "link.mtl", "up/secret.mtl"}) EXPECT_EQ(load(library, true), "") << library;
    const std::string far = load(longName, false);
    EXPECT_LT(far.size(), 400u) << "missing, or refused with a cut name";
    EXPECT_EQ(load("zero.mtl", true), "inside/zero.mtl: is a device, not a regular file");
}

TEST(SceneRefusals, PrintNothingThatATerminalObeys) {
    EXPECT_EQ(printable("a\x1b[2Jb\r\n\t\x7f"), "a\\x1b[2Jb\\x0d\\x0a\\x09\\x7f");
    EXPECT_EQ(printable("gr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\x98\x80"), "gr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\x98\x80");
    EXPECT_EQ(printable("\xc2\x9b"
                        "31m \xe2\x80\xae"),
              "\\xc2\\x9b31m \\xe2\\x80\\xae")
        << "C1 controls and bidirectional overrides";
    EXPECT_EQ(printable("\xc0\xaf \xed\xa0\x80 \xff \xe2\x82"), "\\xc0\\xaf \\xed\\xa0\\x80 \\xff \\xe2\\x82") << "not UTF-8";
    EXPECT_EQ(printable(std::string(300, 'a')), std::string(200, 'a') + "...");
}

TEST(SceneRefusals, NumbersAreReadWithoutALocale) {
    struct Comma : std::numpunct<char> {
        char do_decimal_point() const override { return ','; }
        char do_thousands_sep() const override { return '.'; }
        std::string do_grouping() const override { return "\3"; }
    };
    const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
    std::setlocale(LC_ALL, "");
    const std::string got = refusal("a.obj", kVertices + "v 1234.5 2 3\nf 1 2 4\nf 1 2 1234567\n");
    std::locale::global(before);
    std::setlocale(LC_ALL, "C");
    EXPECT_EQ(got, "a.obj:6:7: face corner: the vertex index is out of range; 4 are defined");
    float value = 0;
    ASSERT_TRUE(parseFloat("1234.5", value));
    EXPECT_EQ(value, 1234.5f);
    EXPECT_FALSE(parseFloat("1234,5", value));
    EXPECT_FALSE(parseFloat("", value));
    EXPECT_FALSE(parseFloat("-", value));
    ASSERT_TRUE(parseFloat("-0.00000000000000000000000000000000000000000000000000001e-5", value));
    EXPECT_EQ(value, -std::numeric_limits<float>::denorm_min());
    ASSERT_TRUE(parseFloat("100000000000000000000000000000000000000000", value));
    EXPECT_EQ(value, std::numeric_limits<float>::infinity());
    ASSERT_TRUE(parseFloat("0.000001e+99", value));
    EXPECT_EQ(value, std::numeric_limits<float>::infinity());
    ASSERT_TRUE(parseFloat("1000000e-99", value));
    EXPECT_EQ(value, std::numeric_limits<float>::denorm_min());
}

TEST(SceneRefusals, AMeshTooSmallToDrawIsRefused) {
    const std::string got = refusal("a.obj", "v 0 0 0\nv 1e-31 0 0\nv 0 1e-31 0\nf 1 2 3\n");
    EXPECT_NE(got.find("is 1e-31 across; the smallest that is drawn is 7.88861e-31"), std::string::npos) << got;
    EXPECT_EQ(refusal("a.obj", "v 0 0 0\nv 1e-30 0 0\nv 0 1e-30 0\nf 1 2 3\n"), "");
    EXPECT_EQ(refusal("a.obj", "v 0 0 0\nv 1e30 0 0\nv 0 1e30 0\nf 1 2 3\n"), "");
}

}  // namespace
}  // namespace plumb
