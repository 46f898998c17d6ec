// SPDX-License-Identifier: MIT
// Wavefront OBJ and its material libraries (Wavefront "Advanced Visualizer" manual, appendix B1, and the MTL text of
// 1995). Polygons only: free-form curves and surfaces, lines and points are named in `ignored`.
#include "pipeline/scene/input.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/ray_shares.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// Most kinds of unknown statements. A text with more is not the format that its name promises.
constexpr size_t kMaxUnknownKinds = 64;

class ObjReader {
public:
    ObjReader(const std::filesystem::path& path, const LoadOptions& options) : path_(path), options_(options) {}

    PolygonMesh read() {
        const std::string text = readInput(path_, options_);
        mesh_.name = path_.stem().string();
        mesh_.faceFirst.push_back(0);
        Scanner in(text, path_);
        in.continued = true;
        LoadMeter meter(options_, "parse", kReadEnds, kParseEnds, text.size());
        while (!in.atEnd()) {
            statement(in);
            in.skipLine();
            meter.at(in.offset());
        }
        for (const Later& later : later_) checkLaterCorner(in, text.data() + later.offset, later);
        if (mesh_.faceMaterial.empty()) throw inputError(in.placeAt(text.data() + text.size()), "the file ends and has no face");
        assignMaterials();
        if (!anySmoothing_) mesh_.faceSmoothing.clear();
        return std::move(mesh_);
    }

private:
    void statement(Scanner& in) {
        const std::string_view key = in.word();
        if (key.empty() || key[0] == '#') return;
        if (key == "v") {
            vertex(in);
        } else if (key == "vn") {
            const float x = in.number("normal x"), y = in.number("normal y"), z = in.number("normal z");
            mesh_.normals.push_back({x, y, z});
        } else if (key == "vt") {
            // Texture coordinates must be well formed although nothing uses them, because a corner may name one.
            in.number("texture coordinate u");
            for (std::string_view word = in.word(); !word.empty() && word[0] != '#'; word = in.word())
                in.number(word, "texture coordinate");
            ++textureCoordinates_;
        } else if (key == "f" || key == "fo") {
            face(in);
        } else if (key == "usemtl") {
            const std::string name(in.restOfLine());
            faceMaterialName_ = materialNames_.try_emplace(name, uint32_t(materialNames_.size())).first->second;
            if (faceMaterialName_ == usedMaterials_.size()) usedMaterials_.push_back({name, 0});
        } else if (key == "mtllib") {
            materialLibraries(in);
        } else if (key == "s") {
            smoothingGroup(in);
        } else if (key == "o" || key == "g") {
            // Parts of a file (o, g) make no objects: one file is one object of the scene.
        } else if (key == "l" || key == "p") {
            ignore(in, key == "l" ? "lines (l)" : "points (p)");
        } else {
            unknown(in, key, "OBJ");
        }
    }

    void vertex(Scanner& in) {
        const double x = in.coordinate("vertex x"), y = in.coordinate("vertex y"), z = in.coordinate("vertex z");
        float more[4];
        size_t count = 0;
        for (std::string_view word = in.word(); !word.empty() && word[0] != '#'; word = in.word()) {
            if (count == 4) in.refuse("vertex has more than 7 numbers");
            more[count++] = in.number(word, "vertex weight or colour");
        }
        if (count == 2) in.refuse("vertex has 5 numbers; a position has 3 or 4, with a colour 6 or 7");
        mesh_.positions.push_back({x, y, z});  // a fourth number is the weight of free-form geometry
        if (count >= 3) {
            mesh_.colours.resize(mesh_.positions.size() - 1, glm::vec3(1));
            mesh_.colours.push_back({more[count - 3], more[count - 2], more[count - 1]});
            ignore(in, "vertex colours");
        } else if (!mesh_.colours.empty()) {
            mesh_.colours.push_back(glm::vec3(1));
        }
    }

    // Index of a corner, 0-based. Positive ones may name a later vertex of the file, negative ones count back.
    static uint32_t index(const Scanner& in, std::string_view word, const char*& at, size_t count, const char* field, bool& later) {
        int64_t value = 0;
        const auto [rest, error] = std::from_chars(at, word.data() + word.size(), value);
        if (error != std::errc()) in.refuse(fmt::format("face corner '{}': the {} index is not an integer", printable(word, 40), field));
        at = rest;
        if (value == 0) in.refuse(fmt::format("face corner: the {} index is 0; the first is 1", field));
        if (value < 0) value += int64_t(count) + 1;
        if (value <= 0 || value >= int64_t(kNone))
            in.refuse(fmt::format("face corner: the {} index is out of range; {} are defined so far", field, count));
        later |= uint64_t(value) > count;
        return uint32_t(value - 1);
    }

    void face(Scanner& in) {
        const size_t first = mesh_.corners.size();
        for (std::string_view word = in.word(); !word.empty() && word[0] != '#'; word = in.word()) {
            const char* at = word.data();
            const char* const end = at + word.size();
            bool later = false;
            uint32_t textureCoordinate = kNone;
            PolygonMesh::Corner corner{index(in, word, at, mesh_.positions.size(), "vertex", later)};
            if (at != end && *at == '/') {
                ++at;
                if (at != end && *at != '/') textureCoordinate = index(in, word, at, textureCoordinates_, "texture coordinate", later);
                if (at != end && *at == '/') corner.normal = index(in, word, ++at, mesh_.normals.size(), "normal", later);
            }
            if (at != end) in.refuse(fmt::format("face corner '{}' is not v, v/vt, v//vn or v/vt/vn", printable(word, 40)));
            if (later) later_.push_back({mesh_.corners.size(), in.offset() - word.size(), textureCoordinate});
            mesh_.corners.push_back(corner);
        }
        const size_t count = mesh_.corners.size() - first;
        if (count < 3) in.refuse(fmt::format("face has {} corners; at least 3 are needed", count));
        mesh_.faceFirst.push_back(uint32_t(mesh_.corners.size()));
        mesh_.faceMaterial.push_back(faceMaterialName_);  // an index into usedMaterials_ until assignMaterials()
        mesh_.faceSmoothing.push_back(smoothing_);
        if (faceMaterialName_ != kNone) ++usedMaterials_[faceMaterialName_].faces;
    }

    struct Later {
        size_t corner, offset;  // corner of the mesh, offset in the text
        uint32_t textureCoordinate;
    };

    void checkLaterCorner(const Scanner& in, const char* at, const Later& later) const {
        const PolygonMesh::Corner& corner = mesh_.corners[later.corner];
        const auto refuse = [&](const char* field, size_t count) {
            return inputError(in.placeAt(at), fmt::format("face corner: the {} index is out of range; {} are defined", field, count));
        };
        if (corner.position >= mesh_.positions.size()) throw refuse("vertex", mesh_.positions.size());
        if (corner.normal != kNone && corner.normal >= mesh_.normals.size()) throw refuse("normal", mesh_.normals.size());
        if (later.textureCoordinate != kNone && later.textureCoordinate >= textureCoordinates_)
            throw refuse("texture coordinate", textureCoordinates_);
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

    void ignore(const Scanner& in, const std::string& what) {
        if (std::find(mesh_.ignored.begin(), mesh_.ignored.end(), what) != mesh_.ignored.end()) return;
        if (options_.strict) in.refuse(what + " would be ignored (--strict)");
        mesh_.ignored.push_back(what);
    }

    void unknown(const Scanner& in, std::string_view key, std::string_view format) {
        const bool plausible = key.size() <= 32 && std::all_of(key.begin(), key.end(), [](char c) {
                                   return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
                               });
        if (!plausible) in.refuse(fmt::format("'{}' is not an {} statement", printable(key, 40), format));
        ignore(in, fmt::format("{} statement {}", format, key));
        if (mesh_.ignored.size() > kMaxUnknownKinds) in.refuse(fmt::format("more than {} kinds of unknown statements", kMaxUnknownKinds));
    }

    void materialLibraries(Scanner& in) {
        const std::string_view all = in.restOfLine();
        if (all.empty()) in.refuse("material library is missing");
        if (!options_.keepMaterials) return;
        // A name may contain blanks, and the format also permits several names.
        if (materialLibrary(in, all, all.find_first_of(" \t") == std::string_view::npos)) return;
        for (std::string_view rest = all; !rest.empty();) {
            const size_t length = std::min(rest.find_first_of(" \t"), rest.size());
            if (length > 0) materialLibrary(in, rest.substr(0, length), true);
            rest.remove_prefix(std::min(length + 1, rest.size()));
        }
    }

    // Reads a material library. False when there is no such file; a missing file is noted when `last` says that the name can mean nothing
    // else.
    bool materialLibrary(const Scanner& in, std::string_view name, bool last) {
        const std::string place = in.place();
        const std::filesystem::path library =
            resolveReference(referenceBase(path_, options_), name, options_.allowOutside, place, "material library");
        std::error_code failed;
        if (!std::filesystem::exists(library, failed)) {
            if (!last) return false;
            if (options_.strict) throw inputError(place, fmt::format("material library '{}' is missing (--strict)", printable(name)));
            if (missing_.empty()) missing_ = fmt::format("{}: material library '{}' is missing", place, printable(name));
            return true;
        }
        if (std::find(libraries_.begin(), libraries_.end(), library) != libraries_.end()) return true;
        libraries_.push_back(library);
        readMtl(library);
        return true;
    }

    glm::vec3 colour(Scanner& in, std::string_view field, bool& clamped) {
        const auto channel = [&](std::string_view word, const char* name) {
            const float value = in.number(word, fmt::format("{} {}", field, name));
            if (value < 0) in.refuse(fmt::format("{} {} is negative", field, name));
            return value;
        };
        glm::vec3 value(channel(in.word(), "red"));
        const std::string_view second = in.word();
        if (!second.empty() && second[0] != '#') {
            value.y = channel(second, "green");
            value.z = channel(in.word(), "blue");
        }
        const glm::vec3 inside = glm::min(value, glm::vec3(1));
        clamped |= inside != value;
        return inside;
    }

    void readMtl(const std::filesystem::path& path) {
        const std::string text = readWholeFile(path);
        Scanner in(text, path);
        Material* material = nullptr;
        bool* clamped = nullptr;
        while (!in.atEnd()) {
            const std::string_view key = in.word();
            if (key == "newmtl") {
                const std::string_view name = in.restOfLine();
                // The first definition of a name is the one that counts.
                materialByName_.try_emplace(std::string(name), uint32_t(library_.size()));
                library_.push_back({});
                material = &library_.back().material;
                clamped = &library_.back().clamped;
                material->name = name;
                library_.back().place = printablePath(path) + ": material '" + printable(name) + "'";
            } else if (!key.empty() && key[0] != '#') {
                if (!material) in.refuse(fmt::format("'{}' comes before newmtl", printable(key, 40)));
                property(in, key, *material, *clamped);
            }
            in.skipLine();
        }
    }

    void property(Scanner& in, std::string_view key, Material& material, bool& clamped) {
        if (key == "Ka" || key == "Kd" || key == "Ks" || key == "Ke") {
            Scanner ahead = in;
            const std::string_view form = ahead.word();
            if (form == "spectral" || form == "xyz") return ignore(in, fmt::format("MTL {} {}", key, form));
            const glm::vec3 value = colour(in, key, clamped);
            (key == "Ka" ? material.ambient : key == "Kd" ? material.diffuse : key == "Ks" ? material.specular : material.emission) = value;
        } else if (key == "Ns") {
            const float value = in.number("Ns");
            if (value < 0) in.refuse("Ns is negative");
            clamped |= value > 1e6f;
            material.shininess = std::min(value, 1e6f);
        } else if (key == "Ni") {
            const float value = in.number("Ni");
            if (value < 0) in.refuse("Ni is negative");
            material.refractiveIndex = value == 0 ? 1.0f : value;  // exporters write 0 for "not stated"
        } else if (key == "d" || key == "Tr") {
            std::string_view word = in.word();
            if (key == "d" && word == "-halo") {
                ignore(in, "MTL d -halo");
                word = in.word();
            }
            const float value = in.number(word, key);
            const float inside = std::clamp(value, 0.0f, 1.0f);
            clamped |= inside != value;
            material.opacity = key == "d" ? inside : 1.0f - inside;
        } else if (key == "illum") {
            const int64_t value = in.integer(in.word(), "illum");
            if (value < 0 || value > 10) in.refuse("illum is not in 0 to 10");
            material.illum = int(value);
            if (value == 10) ignore(in, "shadows on invisible surfaces (illum 10)");
        } else {
            unknown(in, key, "MTL");
        }
    }

    // Materials in the order of their first use; faces that name none or an unknown one keep kNone.
    void assignMaterials() {
        std::vector<uint32_t> indexOf(usedMaterials_.size(), kNone);
        uint64_t lost = 0, clamped = 0;
        std::string firstLost, firstClamped;
        for (size_t used = 0; used < usedMaterials_.size(); ++used) {
            const auto& [name, faces] = usedMaterials_[used];
            if (faces == 0) continue;
            const auto found = materialByName_.find(name);
            if (found == materialByName_.end()) {
                lost += faces;
                if (firstLost.empty()) firstLost = name;
                continue;
            }
            const Defined& defined = library_[found->second];
            if (defined.clamped && clamped++ == 0) firstClamped = defined.place;
            indexOf[used] = uint32_t(mesh_.materials.size());
            Material& material = mesh_.materials.emplace_back(defined.material);
            if (material.opacity < 1 && !illumIsGlass(material.illum)) {
                const std::string what = "transparency (d, Tr)";
                if (options_.strict) throw inputError(defined.place, what + " would be ignored (--strict)");
                if (std::find(mesh_.ignored.begin(), mesh_.ignored.end(), what) == mesh_.ignored.end()) mesh_.ignored.push_back(what);
            }
            // Kinds 0 and 1 of illum have no highlight, whatever Ks says. Kind 0 is the colour Kd without any light.
            if (material.illum < 2) material.specular = glm::vec3(0);
            if (material.illum == 0) {
                material.emission = glm::min(material.emission + material.diffuse, glm::vec3(1));
                material.ambient = material.diffuse = glm::vec3(0);
            }
        }
        for (uint32_t& material : mesh_.faceMaterial)
            if (material != kNone) material = indexOf[material];
        if (!missing_.empty())
            mesh_.warnings.push_back(fmt::format("{}; {} faces have the default material", missing_, lost));
        else if (lost > 0 && options_.keepMaterials)
            mesh_.warnings.push_back(fmt::format("{}: material '{}' is not defined; {} faces have the default material",
                                                 printablePath(path_), printable(firstLost), lost));
        if (clamped > 0)
            mesh_.warnings.push_back(
                fmt::format("{}: values outside the range are clamped; {} such materials are used", firstClamped, clamped));
    }

    struct Defined {
        Material material;
        bool clamped = false;
        std::string place;  // for a warning
    };
    struct Used {
        std::string name;
        uint64_t faces;
    };

    const std::filesystem::path& path_;
    const LoadOptions& options_;
    PolygonMesh mesh_;
    std::vector<Later> later_;  // corners that name a later vertex
    size_t textureCoordinates_ = 0;
    uint32_t faceMaterialName_ = kNone;
    uint32_t smoothing_ = kNone;
    bool anySmoothing_ = false;
    std::unordered_map<std::string, uint32_t> materialNames_, materialByName_;
    std::vector<Used> usedMaterials_;
    std::vector<Defined> library_;
    std::vector<std::filesystem::path> libraries_;
    std::string missing_;
};

}  // namespace

PolygonMesh readObj(const std::filesystem::path& path, const LoadOptions& options) { return ObjReader(path, options).read(); }

}  // namespace plumb
