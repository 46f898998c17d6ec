// SPDX-License-Identifier: MIT
// OFF as Geomview documents it: [ST][C][N]OFF, text, '#' comments. Not read: 4OFF, nOFF (other dimensions), BINARY. What is not drawn is
// passed over by the rule of tolerance.h.
#include "pipeline/scene/input.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/text.h"
#include "pipeline/scene/tolerance.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// Shortest vertex and face: "0 0 0\n" and "3 0 1 2\n"; the last line end may be missing.
constexpr size_t kLeastVertexBytes = 6, kLeastFaceBytes = 8;

constexpr std::string_view kBadNormal = "a normal is not finite; it counts as not stated";
constexpr std::string_view kBadColour = "a colour is not three finite numbers; it counts as not stated";
constexpr std::string_view kMoreNumbers = "a vertex has more numbers than the header says; they are not used";

class OffReader {
public:
    OffReader(const std::filesystem::path& path, const LoadOptions& options)
        : path_(path), options_(options), text_(readTextInput(path, options)), in_(text_, path), tolerance_(options) {}

    PolygonMesh read() {
        mesh_.name = path_.stem().string();
        mesh_.faceFirst.push_back(0);
        const std::string_view glued = header();
        vertices_ = count(glued.empty() ? in_.wordAnywhere() : glued, "vertex count", kLeastVertexBytes);
        faces_ = count(in_.wordAnywhere(), "face count", kLeastFaceBytes);
        if (faces_ == 0) in_.refuse("face count is 0: the file has no face");
        const std::string_view edges = in_.word();  // not needed, often wrong
        int64_t ignored = 0;
        if (isMore(edges) && !parseInteger(edges, ignored)) pass("the edge count is not an integer; it is not used");
        in_.skipLine();
        mesh_.positions.reserve(size_t(vertices_));
        LoadMeter meter(options_, "parse", kReadEnds, kParseEnds, text_.size());
        for (int64_t i = 0; i < vertices_; ++i) vertex(), meter.at(in_.offset());
        for (int64_t i = 0; i < faces_; ++i) face(), meter.at(in_.offset());
        if (!in_.wordAnywhere().empty()) pass("data after the last face is ignored");
        if (mesh_.faceMaterial.empty()) in_.refuse("no face has 3 corners or more: the file has no face");
        checkBadVertices();
        if (anyBadNormal_) dropBadNormals(mesh_);
        tolerance_.addTo(mesh_.warnings);
        return std::move(mesh_);
    }

private:
    // Reads the word OFF with its prefixes; returns a vertex count that is glued to it.
    std::string_view header() {
        std::string_view word = in_.wordAnywhere();
        const std::string_view whole = word;
        const auto take = [&](std::string_view prefix) {
            if (word.substr(0, prefix.size()) != prefix) return false;
            word.remove_prefix(prefix.size());
            return true;
        };
        textured_ = take("ST");
        coloured_ = take("C");
        normals_ = take("N");
        const bool named = take("OFF") || (!textured_ && !coloured_ && !normals_ && take("off"));
        int64_t glued = 0;
        if ((!named || !word.empty()) && !parseInteger(word, glued))
            in_.refuse(fmt::format("'{}' is not OFF, COFF, NOFF, CNOFF or one of these after ST", printable(whole, 40)));
        if (!named) pass("the word OFF is missing");  // Geomview does not ask for it
        if (named && !word.empty()) pass("the vertex count is glued to the word OFF");
        if (coloured_) ignore("vertex colours");
        if (textured_) ignore("texture coordinates");
        if (!word.empty()) return word;
        Scanner ahead = in_;
        if (ahead.wordAnywhere() == "BINARY") ahead.refuse("binary OFF is not read");
        return {};
    }

    static bool isMore(std::string_view word) { return !word.empty() && word[0] != '#'; }

    void pass(std::string_view kind) {
        tolerance_.pass(kind, [&] { return in_.location(); });
    }

    void ignore(const std::string& what) {
        if (options_.strict) in_.refuse(what + " would be ignored (--strict)");
        mesh_.ignored.push_back(what);
    }

    // Count from the header. Nothing is allocated that the rest of the file could not fill.
    int64_t count(std::string_view word, const char* field, size_t leastBytes) {
        const int64_t value = in_.integer(word, field);
        const int64_t most = int64_t((text_.size() - in_.offset() + 1) / leastBytes);
        if (value < 0) in_.refuse(fmt::format("{} is negative", field));
        if (value > most) in_.refuse(fmt::format("{} is {}; the rest of the file holds at most {}", field, value, most));
        return value;
    }

    // Number that may be NaN or too large.
    double anyNumber(const char* field) {
        const std::string_view word = in_.wordAnywhere();
        double value = 0;
        return parseDouble(word, value) ? value : in_.coordinate(word, field);
    }

    void vertex() {
        static constexpr const char* kField[3] = {"vertex x", "vertex y", "vertex z"};
        const size_t offset = in_.offset();
        glm::dvec3 position(0);
        bool finite = true;
        for (int i = 0; i < 3; ++i) {
            position[i] = anyNumber(kField[i]);
            finite &= std::abs(position[i]) <= double(kMaxCoordinate);
        }
        if (!finite) badVertices_.push_back({mesh_.positions.size(), offset});
        mesh_.positions.push_back(finite ? position : glm::dvec3(0));
        if (normals_) normal();
        if (coloured_) return colour();
        if (textured_) anyNumber("texture coordinate s"), anyNumber("texture coordinate t");
        if (!in_.lineEnds() && rowsAreLines()) {
            if (isMore(in_.word())) pass(kMoreNumbers);
            in_.skipLine();
        }
    }

    void normal() {
        static constexpr const char* kField[3] = {"normal x", "normal y", "normal z"};
        glm::dvec3 value(0);
        bool finite = true;
        for (int i = 0; i < 3; ++i) {
            value[i] = anyNumber(kField[i]);
            finite &= std::abs(value[i]) <= double(kMaxCoordinate);
        }
        if (!finite) pass(kBadNormal);
        anyBadNormal_ |= !finite;
        mesh_.normals.push_back(finite ? narrowed(value) : glm::vec3(std::numeric_limits<float>::quiet_NaN()));
    }
    // A number too small for float32 becomes its smallest denormal, so that finishMesh() counts it.
    static glm::vec3 narrowed(const glm::dvec3& v) {
        glm::vec3 narrow(v);
        for (int i = 0; i < 3; ++i)
            if (narrow[i] == 0 && v[i] != 0) narrow[i] = std::copysign(std::numeric_limits<float>::denorm_min(), narrow[i]);
        return narrow;
    }

    // 3 or 4 numbers, integers of 0 to 255 or reals of 0 to 1; texture coordinates behind them are not told apart.
    void colour() {
        float numbers[4];
        size_t size = 0;
        bool integers = true, good = true;
        for (std::string_view word = in_.word(); isMore(word) && size < 4; word = in_.word()) {
            int64_t whole;
            integers &= parseInteger(word, whole);
            good &= parseFloat(word, numbers[size]) && std::abs(numbers[size]) <= kMaxCoordinate;
            ++size;
        }
        good &= size >= 3;
        if (!good) pass(kBadColour);
        in_.skipLine();
        const glm::vec3 colour = good ? glm::vec3(numbers[0], numbers[1], numbers[2]) : glm::vec3(1);
        mesh_.colours.push_back(integers && good ? colour / 255.0f : colour);
    }

    // True when each vertex and each face has a line of its own, so that more numbers in a line are no further vertex.
    bool rowsAreLines() {
        if (rowsAreLines_) return *rowsAreLines_;
        const uint64_t rows = uint64_t(vertices_ + faces_) - mesh_.positions.size();
        Scanner ahead = in_;
        ahead.skipLine();
        uint64_t lines = 0;
        for (; lines < rows && !ahead.atEnd(); ahead.skipLine()) lines += isMore(ahead.word());
        return *(rowsAreLines_ = lines >= rows);
    }

    void face() {
        const int64_t size = in_.integer(in_.wordAnywhere(), "corner count");
        if (size < 0) in_.refuse(fmt::format("face has {} corners; at least 3 are needed", size));
        if (size < 3) {
            pass(kFewCorners);
            for (int64_t i = 0; i < size; ++i) in_.wordAnywhere();
            return in_.skipLine();
        }
        for (int64_t i = 0; i < size; ++i) {
            const int64_t index = in_.integer(in_.wordAnywhere(), "vertex index");
            if (index < 0 || uint64_t(index) >= mesh_.positions.size())
                in_.refuse(fmt::format("vertex index is {}; there are {} vertices", index, mesh_.positions.size()));
            mesh_.corners.push_back({uint32_t(index), normals_ ? uint32_t(index) : kNone});
        }
        const std::string_view more = in_.word();
        if (isMore(more) && !faceColours_) {
            ignore("face colours");
            faceColours_ = true;
        }
        in_.skipLine();
        mesh_.faceFirst.push_back(uint32_t(mesh_.corners.size()));
        mesh_.faceMaterial.push_back(kNone);
    }

    void checkBadVertices() {
        if (badVertices_.empty()) return;
        const std::vector<bool> drawn = drawnPositions(mesh_);
        for (const BadVertex& bad : badVertices_) {
            Scanner again(text_, path_, bad.offset);
            std::string_view word = again.wordAnywhere();
            if (!drawn[bad.index]) {
                tolerance_.pass(kBadVertex, [&] { return again.location(); });
                continue;
            }
            for (const char* field : {"vertex x", "vertex y", "vertex z"}) {  // one of them refuses
                again.coordinate(word, field);
                word = again.wordAnywhere();
            }
        }
    }

    struct BadVertex {
        size_t index, offset;  // in front of its numbers in the text
    };

    const std::filesystem::path& path_;
    const LoadOptions& options_;
    const std::string text_;
    Scanner in_;
    Tolerance tolerance_;
    PolygonMesh mesh_;
    int64_t vertices_ = 0, faces_ = 0;
    std::optional<bool> rowsAreLines_;
    std::vector<BadVertex> badVertices_;
    bool textured_ = false, coloured_ = false, normals_ = false, faceColours_ = false, anyBadNormal_ = false;
};

}  // namespace

PolygonMesh readOff(const std::filesystem::path& path, const LoadOptions& options) { return OffReader(path, options).read(); }

}  // namespace plumb
