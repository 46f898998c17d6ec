// SPDX-License-Identifier: MIT
// Material libraries of an OBJ file (the MTL text of 1995).
#pragma once

#include "pipeline/scene/load.h"
#include "pipeline/scene/mesh.h"
#include "pipeline/scene/text.h"
#include "pipeline/scene/tolerance.h"

#include <cstdint>
#include <exception>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace plumb {

// Names a kind of statement that nothing draws in mesh.ignored, once. With `strict` it is refused.
void ignoreStatement(const Scanner& in, const std::string& what, const LoadOptions& options, PolygonMesh& mesh);
// Ignores the statement `key` of `format`. Refused is one that is no word, and a text with too many kinds.
void ignoreUnknown(const Scanner& in, std::string_view key, std::string_view format, const LoadOptions& options, PolygonMesh& mesh);

class MtlLibraries {
public:
    MtlLibraries(const std::filesystem::path& obj, const LoadOptions& options, Tolerance& tolerance, PolygonMesh& mesh)
        : obj_(obj), options_(options), tolerance_(tolerance), mesh_(mesh) {}

    void load(Scanner& in);  // the rest of an `mtllib` line

    struct Used {
        std::string name;
        uint64_t faces = 0;
    };
    // Puts materials into the mesh, in the order of their first use. mesh.faceMaterial are indices into `used` before, into mesh.materials
    // behind; faces that name no material or an unknown one have kNone.
    void assign(const std::vector<Used>& used);

private:
    struct Defined {
        Material material;
        bool clamped = false;
        bool emissionMapped = false;  // by map_Ke
        std::string location;         // for a warning
        std::exception_ptr refusal;   // of a statement that cannot be read
    };

    bool loadNamed(const Scanner& in, std::string_view name, bool last);
    std::filesystem::path find(const std::string& location, std::string_view name);
    void read(const std::filesystem::path& path);
    void property(Scanner& in, std::string_view key, Defined& defined);
    glm::vec3 colour(Scanner& in, std::string_view field, bool& clamped);
    void take(const Defined& defined);
    void warn(uint64_t lost, const std::string& firstLost);

    const std::filesystem::path& obj_;
    const LoadOptions& options_;
    Tolerance& tolerance_;
    PolygonMesh& mesh_;
    std::unordered_map<std::string, uint32_t> byName_;
    std::vector<Defined> defined_;
    std::vector<std::filesystem::path> read_;
    std::string missing_;
};

}  // namespace plumb
