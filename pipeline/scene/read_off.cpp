// SPDX-License-Identifier: MIT
// OFF as Geomview documents it: [ST][C][N]OFF, text, '#' comments. Not read: 4OFF, nOFF (other dimensions), BINARY.
#include "pipeline/scene/input.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <utility>

namespace plumb {
namespace {

// Shortest vertex and face: "0 0 0\n" and "3 0 1 2\n"; the last line end may be missing.
constexpr size_t kLeastVertexBytes = 6, kLeastFaceBytes = 8;

class OffReader {
public:
    OffReader(const std::filesystem::path& path, const LoadOptions& options)
        : path_(path), options_(options), text_(readInput(path, options)), in_(text_, path) {}

    PolygonMesh read() {
        mesh_.name = path_.stem().string();
        mesh_.faceFirst.push_back(0);
        header();
        const int64_t vertices = count("vertex count", kLeastVertexBytes);
        const int64_t faces = count("face count", kLeastFaceBytes);
        if (faces == 0) in_.refuse("face count is 0: the file has no face");
        const std::string_view edges = in_.word();  // not needed, often wrong
        if (!edges.empty() && edges[0] != '#') in_.integer(edges, "edge count");
        in_.skipLine();
        mesh_.positions.reserve(size_t(vertices));
        LoadMeter meter(options_, "parse", kReadEnds, kParseEnds, text_.size());
        for (int64_t i = 0; i < vertices; ++i) vertex(), meter.at(in_.offset());
        for (int64_t i = 0; i < faces; ++i) face(), meter.at(in_.offset());
        if (!in_.wordAnywhere().empty()) in_.refuse(fmt::format("more data than {} vertices and {} faces", vertices, faces));
        return std::move(mesh_);
    }

private:
    void header() {
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
        if (word != "OFF") in_.refuse(fmt::format("'{}' is not OFF, COFF, NOFF, CNOFF or one of these after ST", printable(whole, 40)));
        Scanner ahead = in_;
        if (ahead.wordAnywhere() == "BINARY") ahead.refuse("binary OFF is not read");
        if (coloured_) ignore("vertex colours");
        if (textured_) ignore("texture coordinates");
    }

    void ignore(const std::string& what) {
        if (options_.strict) in_.refuse(what + " would be ignored (--strict)");
        mesh_.ignored.push_back(what);
    }

    // Count from the header. Nothing is allocated that the rest of the file could not fill.
    int64_t count(const char* field, size_t leastBytes) {
        const int64_t value = in_.integer(in_.wordAnywhere(), field);
        const int64_t most = int64_t((text_.size() - in_.offset() + 1) / leastBytes);
        if (value < 0) in_.refuse(fmt::format("{} is negative", field));
        if (value > most) in_.refuse(fmt::format("{} is {}; the rest of the file holds at most {}", field, value, most));
        return value;
    }

    glm::vec3 vector(const char* x, const char* y, const char* z) {
        const float a = in_.number(in_.wordAnywhere(), x), b = in_.number(in_.wordAnywhere(), y), c = in_.number(in_.wordAnywhere(), z);
        return {a, b, c};
    }

    void vertex() {
        const double x = in_.coordinate(in_.wordAnywhere(), "vertex x"), y = in_.coordinate(in_.wordAnywhere(), "vertex y"),
                     z = in_.coordinate(in_.wordAnywhere(), "vertex z");
        mesh_.positions.push_back({x, y, z});
        if (normals_) mesh_.normals.push_back(vector("normal x", "normal y", "normal z"));
        if (!coloured_) {
            if (textured_) in_.number("texture coordinate s"), in_.number("texture coordinate t");
            return;
        }
        // 3 or 4 numbers, integers of 0 to 255 or reals of 0 to 1; texture coordinates behind them are not told apart.
        float numbers[4];
        size_t size = 0;
        bool integers = true;
        for (std::string_view word = in_.word(); !word.empty() && word[0] != '#' && size < 4; word = in_.word()) {
            int64_t whole;
            integers &= parseInteger(word, whole);
            numbers[size++] = in_.number(word, "vertex colour");
        }
        if (size < 3) in_.refuse("vertex colour is missing");
        in_.skipLine();
        const glm::vec3 colour(numbers[0], numbers[1], numbers[2]);
        mesh_.colours.push_back(integers ? colour / 255.0f : colour);
    }

    void face() {
        const int64_t size = in_.integer(in_.wordAnywhere(), "corner count");
        if (size < 3) in_.refuse(fmt::format("face has {} corners; at least 3 are needed", size));
        for (int64_t i = 0; i < size; ++i) {
            const int64_t index = in_.integer(in_.wordAnywhere(), "vertex index");
            if (index < 0 || uint64_t(index) >= mesh_.positions.size())
                in_.refuse(fmt::format("vertex index is {}; there are {} vertices", index, mesh_.positions.size()));
            mesh_.corners.push_back({uint32_t(index), normals_ ? uint32_t(index) : kNone});
        }
        const std::string_view more = in_.word();
        if (!more.empty() && more[0] != '#' && !faceColours_) {
            in_.number(more, "face colour");
            ignore("face colours");
            faceColours_ = true;
        }
        in_.skipLine();
        mesh_.faceFirst.push_back(uint32_t(mesh_.corners.size()));
        mesh_.faceMaterial.push_back(kNone);
    }

    const std::filesystem::path& path_;
    const LoadOptions& options_;
    const std::string text_;
    Scanner in_;
    PolygonMesh mesh_;
    bool textured_ = false, coloured_ = false, normals_ = false, faceColours_ = false;
};

}  // namespace

PolygonMesh readOff(const std::filesystem::path& path, const LoadOptions& options) { return OffReader(path, options).read(); }

}  // namespace plumb
