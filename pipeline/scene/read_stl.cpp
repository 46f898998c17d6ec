// SPDX-License-Identifier: MIT
// STL, ascii and binary (3D Systems, 1989). The winding says which side is out; the facets' own normals are not used, because exporters
// often leave them zero. What is not drawn is passed over by the rule of tolerance.h: normals, names, bytes behind the last facet.
#include "pipeline/scene/input.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/text.h"
#include "pipeline/scene/tolerance.h"

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
constexpr std::string_view kBadNormal = "a facet normal is not three finite numbers; it is not used";
constexpr std::string_view kSolid = "'solid' or 'endsolid' stands where none is expected; it is passed over";
constexpr std::string_view kFewFacetCorners = "a facet has fewer than 3 corners; it is not drawn";

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

// True when the 50 bytes are a facet rather than padding: three finite corners that are not one point.
bool isFacet(const std::string& bytes, size_t at) {
    bool differ = false;
    for (size_t i = 3; i < 12; ++i) {
        const float number = loadAt<float>(bytes, at + 4 * i);
        if (!(std::abs(number) <= kMaxCoordinate)) return false;
        differ |= i >= 6 && number != loadAt<float>(bytes, at + 4 * (i - 3));
    }
    return differ;
}

// Number of facets: the header's where the file holds as many. Where its size is that of whole facets, the size decides, because exporters
// leave the count 0.
size_t facetsOf(const std::string& bytes, const std::filesystem::path& path, Tolerance& tolerance) {
    if (bytes.size() < kHeaderBytes)
        throw inputError(locationOfByte(path, bytes.size()), fmt::format("the file ends inside the header of {} bytes", kHeaderBytes));
    const size_t stated = loadAt<uint32_t>(bytes, 80), rest = bytes.size() - kHeaderBytes;
    const size_t whole = rest / kFacetBytes;
    if (kFacetBytes * stated == rest) return stated;
    bool decides = rest % kFacetBytes == 0 && whole > 0;
    for (size_t facet = stated; decides && facet < whole; ++facet) decides = isFacet(bytes, kHeaderBytes + facet * kFacetBytes);
    if (decides) {
        tolerance.pass(fmt::format("facet count is {}, but {} whole facets follow; they are drawn", stated, whole),
                       [&] { return locationOfByte(path, 80); });
        return whole;
    }
    if (stated > whole)
        throw inputError(locationOfByte(path, 80), fmt::format("facet count is {}, which takes {} bytes; the file has {}", stated,
                                                               kHeaderBytes + kFacetBytes * stated, bytes.size()));
    tolerance.pass(fmt::format("{} bytes after the last facet are ignored", rest - kFacetBytes * stated),
                   [&] { return locationOfByte(path, kHeaderBytes + kFacetBytes * stated); });
    return stated;
}

void readBinary(const std::string& bytes, const std::filesystem::path& path, const LoadOptions& options, Tolerance& tolerance,
                PolygonMesh& mesh) {
    static constexpr const char* kField[9] = {"vertex 1 x", "vertex 1 y", "vertex 1 z", "vertex 2 x", "vertex 2 y",
                                              "vertex 2 z", "vertex 3 x", "vertex 3 y", "vertex 3 z"};
    const size_t count = facetsOf(bytes, path, tolerance);
    if (count == 0) throw inputError(locationOfByte(path, 80), "facet count is 0: the file has no face");
    mesh.positions.reserve(count * 3);
    mesh.corners.reserve(count * 3);
    mesh.faceFirst.reserve(count + 1);
    mesh.faceMaterial.reserve(count);
    bool attributes = false;
    LoadMeter meter(options, "parse", kReadEnds, kParseEnds, bytes.size());
    for (size_t facet = 0; facet < count; ++facet) {
        const size_t at = kHeaderBytes + facet * kFacetBytes;
        meter.at(at);
        for (size_t i = 0; i < 3; ++i)
            if (!std::isfinite(loadAt<float>(bytes, at + 4 * i))) {
                tolerance.pass(kBadNormal, [&] { return locationOfByte(path, at + 4 * i); });
                break;
            }
        float numbers[9];
        for (size_t i = 0; i < 9; ++i) {
            numbers[i] = loadAt<float>(bytes, at + 12 + 4 * i);
            if (!(std::abs(numbers[i]) <= kMaxCoordinate)) finiteFloat(numbers[i], locationOfByte(path, at + 12 + 4 * i), kField[i]);
        }
        attributes |= loadAt<uint16_t>(bytes, at + 48) != 0;
        addFacet(mesh,
                 {{{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}, {numbers[6], numbers[7], numbers[8]}}});
    }
    if (attributes) {
        if (options.strict) throw inputError(locationOfByte(path, kHeaderBytes + 48), "STL facet attributes would be ignored (--strict)");
        mesh.ignored.emplace_back("STL facet attributes");
    }
}

bool equalIgnoringCase(std::string_view word, std::string_view lower) {
    if (word.size() != lower.size()) return false;
    for (size_t i = 0; i < word.size(); ++i)
        if (char(word[i] >= 'A' && word[i] <= 'Z' ? word[i] - 'A' + 'a' : word[i]) != lower[i]) return false;
    return true;
}

// Ascii STL by its words. Writers part keywords ("end solid"), join them ("outerloop"), or leave them out where nothing depends on them.
class AsciiStl {
public:
    AsciiStl(const std::string& text, const std::filesystem::path& path, const LoadOptions& options, Tolerance& tolerance,
             PolygonMesh& mesh)
        : in_(text, path), meter_(options, "parse", kReadEnds, kParseEnds, text.size()), tolerance_(tolerance), mesh_(mesh) {}

    void read() {
        bool inSolid = false;
        while (true) {
            take();
            if (word_.empty()) break;
            if (is("solid")) {
                if (inSolid) pass(kSolid);
                in_.skipLine();  // its name
                inSolid = true;
            } else if (is("endsolid") || endOf("solid")) {
                if (!inSolid) pass(kSolid);
                in_.skipLine();
                inSolid = false;
            } else if (is("facet")) {
                if (!inSolid) pass("'facet' stands outside a solid; it is drawn");
                inSolid = true;
                facet();
            } else {
                otherLine();
            }
        }
        if (mesh_.faceMaterial.empty() && !fewCorners_.empty())
            throw inputError(fewCorners_, "no facet has 3 corners or more: the file has no face");
        if (mesh_.faceMaterial.empty()) in_.refuse("the file ends and has no face");
        if (inSolid) pass("the file ends without 'endsolid'");
    }

private:
    void take() { word_ = in_.wordAnywhere(); }
    bool is(std::string_view keyword) const { return equalIgnoringCase(word_, keyword); }
    // True when the word is "end" and the next one of its line, which is then taken, `what`.
    bool endOf(std::string_view what) {
        if (!is("end")) return false;
        Scanner ahead = in_;
        if (!equalIgnoringCase(ahead.word(), what)) return false;
        in_ = ahead;
        return true;
    }
    void pass(std::string_view kind) {
        tolerance_.pass(kind, [&] { return in_.location(); });
    }
    [[noreturn]] void refuse(std::string_view expected) {
        if (word_.empty()) in_.refuse(fmt::format("the file ends where '{}' is expected", expected));
        in_.refuse(fmt::format("'{}' where '{}' is expected", printable(word_, 40), expected));
    }

    // A line outside the facets that is no statement. A part of a facet here would be geometry that is lost.
    void otherLine() {
        for (const std::string_view part : {"normal", "outer", "outerloop", "loop", "vertex", "endloop", "endfacet"})
            if (is(part)) refuse("facet' or 'endsolid");
        if (endOf("loop") || endOf("facet")) refuse("facet' or 'endsolid");
        pass("a line outside the facets is no statement of STL; it is passed over");
        in_.skipLine();
    }

    void facet() {
        normal();
        if (!is("outerloop")) {
            if (!is("outer")) refuse("outer");
            take();
            if (!is("loop")) refuse("loop");
        }
        std::array<glm::dvec3, 3> corners;
        size_t count = 0;
        for (take(); count < 3 && is("vertex"); ++count, take())
            for (int i = 0; i < 3; ++i) corners[count][i] = in_.coordinate(in_.wordAnywhere(), kVertexField[i]);
        const bool loopEnds = is("endloop") || endOf("loop");
        if (!loopEnds) refuse(count < 3 ? "vertex" : "endloop");
        if (count < 3) {
            pass(kFewFacetCorners);
            if (fewCorners_.empty()) fewCorners_ = in_.location();
        } else {
            addFacet(mesh_, corners);
        }
        take();
        if (!is("endfacet") && !endOf("facet")) refuse("endfacet");
        meter_.at(in_.offset());
    }

    // Takes the words up to "outer": "normal" and three numbers.
    void normal() {
        take();
        bool good = is("normal");
        if (good) take();
        int numbers = 0;
        for (; numbers < 4 && !is("outer") && !is("outerloop") && !is("vertex") && !word_.empty(); ++numbers, take()) {
            float number = 0;
            good &= parseFloat(word_, number) && std::isfinite(number);
        }
        if (!good || numbers != 3) pass(kBadNormal);
    }

    static constexpr const char* kVertexField[3] = {"vertex x", "vertex y", "vertex z"};

    Scanner in_;
    LoadMeter meter_;
    Tolerance& tolerance_;
    PolygonMesh& mesh_;
    std::string_view word_;
    std::string fewCorners_;  // location of the first facet of fewer than 3 corners; empty: there is none
};

// True when the first line that is neither blank nor a comment begins a solid or a facet.
bool beginsAsText(std::string_view bytes, const std::filesystem::path& path) {
    if (bytes.starts_with("\xef\xbb\xbf")) bytes.remove_prefix(3);
    Scanner in(bytes.substr(0, 4096), path);
    const std::string_view word = in.wordAnywhere();
    return equalIgnoringCase(word.substr(0, 5), "solid") || equalIgnoringCase(word, "facet");
}

}  // namespace

PolygonMesh readStl(const std::filesystem::path& path, const LoadOptions& options) {
    std::string bytes = readInput(path, options);
    PolygonMesh mesh;
    mesh.name = path.stem().string();
    mesh.faceFirst.push_back(0);
    Tolerance tolerance(options);
    // Binary or text: the size decides, because many binary files begin with the word "solid"; then a NUL, which no text has.
    const bool exact = bytes.size() >= kHeaderBytes && bytes.size() == kHeaderBytes + kFacetBytes * size_t(loadAt<uint32_t>(bytes, 80));
    if (!exact) takeByteOrderMark(bytes, path);
    if (exact || !beginsAsText(bytes, path) || std::string_view(bytes).substr(0, kHeaderBytes).find('\0') != std::string_view::npos)
        readBinary(bytes, path, options, tolerance, mesh);
    else
        AsciiStl(bytes, path, options, tolerance, mesh).read();
    tolerance.addTo(mesh.warnings);
    return mesh;
}

}  // namespace plumb
