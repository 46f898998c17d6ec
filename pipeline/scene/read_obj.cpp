// SPDX-License-Identifier: MIT
// Wavefront OBJ (Wavefront "Advanced Visualizer" manual, appendix B1). Polygons only: free-form curves and surfaces, lines and points are
// named in `ignored`. What no face draws is passed over by the rule of tolerance.h.
#include "pipeline/scene/input.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/mtl_libraries.h"
#include "pipeline/scene/text.h"
#include "pipeline/scene/tolerance.h"

#include <fmt/core.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr std::string_view kBadNormal = "a normal is not three finite numbers; it counts as not stated";
constexpr std::string_view kBadTexture = "a texture coordinate is not finite numbers; it is not used";
constexpr std::string_view kBadColour = "a vertex has more numbers that are no weight or colour; they are not used";
constexpr std::string_view kNoNormal = "a face corner names a normal that is not there; it counts as not stated";
constexpr std::string_view kNoTexture = "a face corner names a texture coordinate that is not there; it is not used";
constexpr std::string_view kSlashes = "a face corner has more slashes than numbers; they are passed over";

class ObjReader {
public:
    ObjReader(const std::filesystem::path& path, const LoadOptions& options)
        : path_(path),
          options_(options),
          text_(readTextInput(path, options)),
          tolerance_(options),
          libraries_(path, options, tolerance_, mesh_) {}

    PolygonMesh read() {
        mesh_.name = path_.stem().string();
        mesh_.faceFirst.push_back(0);
        Scanner in(text_, path_);
        in.continued = true;
        LoadMeter meter(options_, "parse", kReadEnds, kParseEnds, text_.size());
        while (!in.atEnd()) {
            statement(in);
            in.skipLine();
            meter.at(in.offset());
        }
        for (const Later& later : later_) checkLaterCorner(in, later);
        checkBadVertices();
        if (mesh_.faceMaterial.empty()) refuseWithoutFaces(in);
        if (anyBadNormal_) dropBadNormals(mesh_);
        libraries_.assign(usedMaterials_);
        if (!anySmoothing_) mesh_.faceSmoothing.clear();
        tolerance_.addTo(mesh_.warnings);
        return std::move(mesh_);
    }

private:
    void statement(Scanner& in) {
        const std::string_view key = in.word();
        if (key.empty() || key[0] == '#') return;
        if (key == "v") {
            vertex(in);
        } else if (key == "vn") {
            normal(in);
        } else if (key == "vt") {
            textureCoordinate(in);
        } else if (key == "f" || key == "fo") {
            face(in);
        } else if (key == "usemtl") {
            const std::string name(in.restOfLine());
            faceMaterialName_ = materialNames_.try_emplace(name, uint32_t(materialNames_.size())).first->second;
            if (faceMaterialName_ == usedMaterials_.size()) usedMaterials_.push_back({name, 0});
        } else if (key == "mtllib") {
            libraries_.load(in);
        } else if (key == "s") {
            smoothingGroup(in);
        } else if (key == "o" || key == "g") {
            // Parts of a file (o, g) make no objects: one file is one object of the scene.
        } else if (key == "l" || key == "p") {
            ignoreStatement(in, key == "l" ? "lines (l)" : "points (p)", options_, mesh_);
        } else {
            ignoreUnknown(in, key, "OBJ", options_, mesh_);
        }
    }

    void pass(const Scanner& in, std::string_view kind) {
        tolerance_.pass(kind, [&] { return in.location(); });
    }

    static bool isMore(std::string_view word) { return !word.empty() && word[0] != '#'; }
    static bool isFinite(std::string_view word, float& value) { return parseFloat(word, value) && std::abs(value) <= kMaxCoordinate; }

    void vertex(Scanner& in) {
        static constexpr const char* kField[3] = {"vertex x", "vertex y", "vertex z"};
        const size_t offset = in.offset();
        glm::dvec3 position(0);
        bool finite = true;
        for (int i = 0; i < 3; ++i) {
            const std::string_view word = in.word();
            if (parseDouble(word, position[i]) && std::abs(position[i]) <= double(kMaxCoordinate)) continue;
            if (!parseDouble(word, position[i])) in.coordinate(word, kField[i]);  // refuses
            position[i] = 0;
            finite = false;
        }
        if (!finite) badVertices_.push_back({mesh_.positions.size(), offset});
        mesh_.positions.push_back(position);
        extraNumbers(in);
    }

    // Numbers behind a position: the weight of free-form geometry, a colour, or both.
    void extraNumbers(Scanner& in) {
        float more[4];
        size_t count = 0;
        bool good = true;
        for (std::string_view word = in.word(); isMore(word); word = in.word(), ++count) good &= count < 4 && isFinite(word, more[count]);
        if (!good || count == 2) {
            pass(in, kBadColour);
            count = 0;
        }
        if (count >= 3) {
            mesh_.colours.resize(mesh_.positions.size() - 1, glm::vec3(1));
            mesh_.colours.push_back({more[count - 3], more[count - 2], more[count - 1]});
            ignoreStatement(in, "vertex colours", options_, mesh_);
        } else if (!mesh_.colours.empty()) {
            mesh_.colours.push_back(glm::vec3(1));
        }
    }

    void normal(Scanner& in) {
        glm::vec3 value;
        bool good = true;
        for (int i = 0; i < 3; ++i) good = good && isFinite(in.word(), value[i]);
        if (!good) pass(in, kBadNormal);
        anyBadNormal_ |= !good;
        mesh_.normals.push_back(good ? value : glm::vec3(std::numeric_limits<float>::quiet_NaN()));
    }

    void textureCoordinate(Scanner& in) {
        if (!numbersAreFinite(in)) pass(in, kBadTexture);
        ++textureCoordinates_;
    }
    // Takes one number or more, up to the first that is not finite.
    static bool numbersAreFinite(Scanner& in) {
        float value;
        std::string_view word = in.word();
        do {
            if (!isFinite(word, value)) return false;
            word = in.word();
        } while (isMore(word));
        return true;
    }

    // Index of a corner's vertex, 0-based. Positive ones may name a later vertex of the file, negative ones count back.
    static uint32_t vertexIndex(const Scanner& in, std::string_view word, const char*& at, size_t count, bool& later) {
        int64_t value = 0;
        const auto [rest, error] = std::from_chars(at, word.data() + word.size(), value);
        if (error != std::errc()) in.refuse(fmt::format("face corner '{}': the vertex index is not an integer", printable(word, 40)));
        at = rest;
        if (value == 0) in.refuse("face corner: the vertex index is 0; the first is 1");
        if (value < 0) value += int64_t(count) + 1;
        if (value <= 0 || value >= int64_t(kNone))
            in.refuse(fmt::format("face corner: the vertex index is out of range; {} are defined so far", count));
        later |= uint64_t(value) > count;
        return uint32_t(value - 1);
    }

    // Index behind a slash, 0-based; kNone where it is missing or no index, which is passed over as `kind`.
    uint32_t optionalIndex(const Scanner& in, std::string_view field, size_t count, std::string_view kind, bool& later) {
        if (field.empty()) return kNone;
        int64_t value = 0;
        const bool good = parseInteger(field, value);
        if (good && value < 0) value += int64_t(count) + 1;
        if (!good || value <= 0 || value >= int64_t(kNone)) {
            pass(in, kind);
            return kNone;
        }
        later |= uint64_t(value) > count;
        return uint32_t(value - 1);
    }

    // Corner "v", "v/vt", "v//vn" or "v/vt/vn".
    void corner(Scanner& in, std::string_view word) {
        const char* at = word.data();
        const char* const end = at + word.size();
        bool later = false;
        PolygonMesh::Corner corner{vertexIndex(in, word, at, mesh_.positions.size(), later)};
        uint32_t textureCoordinate = kNone;
        if (at != end) {
            if (*at != '/') in.refuse(fmt::format("face corner '{}' is not v, v/vt, v//vn or v/vt/vn", printable(word, 40)));
            const std::string_view behind(at + 1, size_t(end - at - 1));
            const size_t slash = std::min(behind.find('/'), behind.size());
            const bool second = slash < behind.size();
            std::string_view last = second ? behind.substr(slash + 1) : behind.substr(0, slash);
            textureCoordinate = optionalIndex(in, behind.substr(0, slash), textureCoordinates_, kNoTexture, later);
            const size_t third = std::min(last.find('/'), last.size());
            if (last.empty() || third < last.size()) pass(in, kSlashes);
            if (second) corner.normal = optionalIndex(in, last.substr(0, third), mesh_.normals.size(), kNoNormal, later);
        }
        if (later) later_.push_back({mesh_.corners.size(), in.offset() - word.size(), textureCoordinate});
        mesh_.corners.push_back(corner);
    }

    void face(Scanner& in) {
        const size_t first = mesh_.corners.size();
        for (std::string_view word = in.word(); isMore(word); word = in.word()) corner(in, word);
        if (mesh_.corners.size() - first < 3) {
            pass(in, kFewCorners);
            if (fewCorners_.empty()) fewCorners_ = in.location();
            mesh_.corners.resize(first);
            while (!later_.empty() && later_.back().corner >= first) later_.pop_back();
            return;
        }
        mesh_.faceFirst.push_back(uint32_t(mesh_.corners.size()));
        mesh_.faceMaterial.push_back(faceMaterialName_);  // an index into usedMaterials_ until they are assigned
        mesh_.faceSmoothing.push_back(smoothing_);
        if (faceMaterialName_ != kNone) ++usedMaterials_[faceMaterialName_].faces;
    }

    struct Later {
        size_t corner, offset;  // corner of the mesh, offset in the text
        uint32_t textureCoordinate;
    };

    void checkLaterCorner(const Scanner& in, const Later& later) {
        PolygonMesh::Corner& corner = mesh_.corners[later.corner];
        const auto location = [&] { return in.locationAt(text_.data() + later.offset); };
        if (corner.position >= mesh_.positions.size())
            throw inputError(location(),
                             fmt::format("face corner: the vertex index is out of range; {} are defined", mesh_.positions.size()));
        if (later.textureCoordinate != kNone && later.textureCoordinate >= textureCoordinates_) tolerance_.pass(kNoTexture, location);
        if (corner.normal != kNone && corner.normal >= mesh_.normals.size()) {
            tolerance_.pass(kNoNormal, location);
            corner.normal = kNone;
        }
    }

    // Refuses a vertex that is not finite where a face has it, or where the file has no face at all.
    void checkBadVertices() {
        if (badVertices_.empty()) return;
        const std::vector<bool> drawn = drawnPositions(mesh_);
        for (const BadVertex& bad : badVertices_) {
            Scanner again(text_, path_, bad.offset);
            again.continued = true;
            if (drawn[bad.index])
                for (const char* field : {"vertex x", "vertex y", "vertex z"}) again.coordinate(field);  // one of them refuses
            again.word();
            pass(again, kBadVertex);
        }
    }

    [[noreturn]] void refuseWithoutFaces(const Scanner& in) const {
        std::string drawn;
        for (const char* kind : {"lines (l)", "points (p)"})
            if (std::find(mesh_.ignored.begin(), mesh_.ignored.end(), kind) != mesh_.ignored.end())
                drawn += fmt::format("{}{}", drawn.empty() ? "" : " and ", kind);
        if (drawn.empty() && !fewCorners_.empty()) throw inputError(fewCorners_, "no face has 3 corners or more: the file has no face");
        throw inputError(in.locationAt(text_.data() + text_.size()),
                         drawn.empty() ? "the file ends and has no face" : fmt::format("the file has only {}; they are not drawn", drawn));
    }

    void smoothingGroup(Scanner& in) {
        const std::string_view word = in.word();
        if (word == "off" || word == "0") {
            smoothing_ = 0;
        } else if (word == "on") {
            smoothing_ = 1;
        } else {
            const int64_t group = in.integer(word, "smoothing group");
            if (group < 0 || group >= int64_t(kNone)) in.refuse("smoothing group is out of range");
            smoothing_ = uint32_t(group);
        }
        anySmoothing_ = true;
    }

    struct BadVertex {
        size_t index, offset;  // of its first number in the text
    };

    const std::filesystem::path& path_;
    const LoadOptions& options_;
    const std::string text_;
    PolygonMesh mesh_;
    Tolerance tolerance_;
    MtlLibraries libraries_;
    std::vector<Later> later_;  // corners that name a later vertex
    std::vector<BadVertex> badVertices_;
    size_t textureCoordinates_ = 0;
    uint32_t faceMaterialName_ = kNone;
    uint32_t smoothing_ = kNone;
    bool anySmoothing_ = false, anyBadNormal_ = false;
    std::string fewCorners_;  // location of the first face of fewer than 3 corners; empty: there is none
    std::unordered_map<std::string, uint32_t> materialNames_;
    std::vector<MtlLibraries::Used> usedMaterials_;
};

}  // namespace

PolygonMesh readObj(const std::filesystem::path& path, const LoadOptions& options) { return ObjReader(path, options).read(); }

}  // namespace plumb
