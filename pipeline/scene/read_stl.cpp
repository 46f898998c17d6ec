// SPDX-License-Identifier: MIT
// STL, ascii and binary (3D Systems, 1989). The winding says which side is out; the facets' own normals are checked
// for NaN and infinity and otherwise not used, because exporters often leave them zero.
#include "pipeline/scene/input.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <string_view>

namespace plumb {
namespace {

constexpr size_t kHeaderBytes = 84, kFacetBytes = 50;  // 80 of comment and a count; 12 floats and an attribute

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian and read as it lies");

template <class T>
T loadAt(const std::string& bytes, size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof(T));
    return value;
}

void addFacet(PolygonMesh& mesh, const std::array<glm::dvec3, 3>& corners) {
    for (const glm::dvec3& corner : corners) {
        mesh.corners.push_back({uint32_t(mesh.positions.size())});
        mesh.positions.push_back(corner);
    }
    mesh.faceFirst.push_back(uint32_t(mesh.corners.size()));
    mesh.faceMaterial.push_back(kNone);
}

void readBinary(const std::string& bytes, const std::filesystem::path& path, const LoadOptions& options, PolygonMesh& mesh) {
    static constexpr const char* kField[12] = {"normal x",   "normal y",   "normal z",   "vertex 1 x", "vertex 1 y", "vertex 1 z",
                                               "vertex 2 x", "vertex 2 y", "vertex 2 z", "vertex 3 x", "vertex 3 y", "vertex 3 z"};
    if (bytes.size() < kHeaderBytes)
        throw inputError(placeOfByte(path, bytes.size()), fmt::format("the file ends inside the header of {} bytes", kHeaderBytes));
    const size_t count = loadAt<uint32_t>(bytes, 80);
    if (kHeaderBytes + kFacetBytes * count != bytes.size())
        throw inputError(placeOfByte(path, 80), fmt::format("facet count is {}, which takes {} bytes; the file has {}", count,
                                                            kHeaderBytes + kFacetBytes * count, bytes.size()));
    if (count == 0) throw inputError(placeOfByte(path, 80), "facet count is 0: the file has no face");
    mesh.positions.reserve(count * 3);
    mesh.corners.reserve(count * 3);
    mesh.faceFirst.reserve(count + 1);
    mesh.faceMaterial.reserve(count);
    bool attributes = false;
    LoadMeter meter(options, "parse", kReadEnds, kParseEnds, bytes.size());
    for (size_t facet = 0; facet < count; ++facet) {
        const size_t at = kHeaderBytes + facet * kFacetBytes;
        meter.at(at);
        float numbers[12];
        for (size_t i = 0; i < 12; ++i) {
            numbers[i] = loadAt<float>(bytes, at + 4 * i);
            if (!(std::abs(numbers[i]) <= kMaxCoordinate)) finiteFloat(numbers[i], placeOfByte(path, at + 4 * i), kField[i]);
        }
        attributes |= loadAt<uint16_t>(bytes, at + 48) != 0;
        addFacet(mesh,
                 {{{numbers[3], numbers[4], numbers[5]}, {numbers[6], numbers[7], numbers[8]}, {numbers[9], numbers[10], numbers[11]}}});
    }
    if (attributes) {
        if (options.strict) throw inputError(placeOfByte(path, kHeaderBytes + 48), "STL facet attributes would be ignored (--strict)");
        mesh.ignored.emplace_back("STL facet attributes");
    }
}

bool equalIgnoringCase(std::string_view word, std::string_view lower) {
    if (word.size() != lower.size()) return false;
    for (size_t i = 0; i < word.size(); ++i)
        if (char(word[i] >= 'A' && word[i] <= 'Z' ? word[i] - 'A' + 'a' : word[i]) != lower[i]) return false;
    return true;
}

constexpr char kNoComment = '\0';

void expect(Scanner& in, std::string_view keyword) {
    const std::string_view word = in.wordAnywhere(kNoComment);
    if (equalIgnoringCase(word, keyword)) return;
    if (word.empty()) in.refuse(fmt::format("the file ends where '{}' is expected", keyword));
    in.refuse(fmt::format("'{}' where '{}' is expected", printable(word, 40), keyword));
}

void readAscii(const std::string& text, const std::filesystem::path& path, const LoadOptions& options, PolygonMesh& mesh) {
    static constexpr const char* kVertexField[3] = {"vertex x", "vertex y", "vertex z"};
    static constexpr const char* kNormalField[3] = {"normal x", "normal y", "normal z"};
    Scanner in(text, path);
    LoadMeter meter(options, "parse", kReadEnds, kParseEnds, text.size());
    expect(in, "solid");
    while (true) {
        in.skipLine();  // the name of the solid
        while (true) {
            const std::string_view word = in.wordAnywhere(kNoComment);
            if (equalIgnoringCase(word, "endsolid")) break;
            if (word.empty()) in.refuse("the file ends where 'facet' or 'endsolid' is expected");
            if (!equalIgnoringCase(word, "facet"))
                in.refuse(fmt::format("'{}' where 'facet' or 'endsolid' is expected", printable(word, 40)));
            expect(in, "normal");
            for (const char* field : kNormalField) in.number(in.wordAnywhere(kNoComment), field);
            expect(in, "outer");
            expect(in, "loop");
            std::array<glm::dvec3, 3> corners;
            for (glm::dvec3& corner : corners) {
                expect(in, "vertex");
                for (int i = 0; i < 3; ++i) corner[i] = in.coordinate(in.wordAnywhere(kNoComment), kVertexField[i]);
            }
            expect(in, "endloop");
            expect(in, "endfacet");
            addFacet(mesh, corners);
            meter.at(in.offset());
        }
        in.skipLine();
        const std::string_view word = in.wordAnywhere(kNoComment);
        if (word.empty()) break;
        if (!equalIgnoringCase(word, "solid")) in.refuse(fmt::format("'{}' where 'solid' or the end is expected", printable(word, 40)));
    }
    if (mesh.faceMaterial.empty()) in.refuse("the file ends and has no face");
}

}  // namespace

PolygonMesh readStl(const std::filesystem::path& path, const LoadOptions& options) {
    const std::string bytes = readInput(path, options);
    PolygonMesh mesh;
    mesh.name = path.stem().string();
    mesh.faceFirst.push_back(0);
    // Binary or text: the size decides, because many binary files begin with the word "solid"; then a NUL, which no text has.
    const bool exact = bytes.size() >= kHeaderBytes && bytes.size() == kHeaderBytes + kFacetBytes * size_t(loadAt<uint32_t>(bytes, 80));
    const size_t start = std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size());
    const bool solid = equalIgnoringCase(std::string_view(bytes).substr(start, 5), "solid");
    if (exact || !solid || std::string_view(bytes).substr(0, kHeaderBytes).find('\0') != std::string_view::npos)
        readBinary(bytes, path, options, mesh);
    else
        readAscii(bytes, path, options, mesh);
    return mesh;
}

}  // namespace plumb
