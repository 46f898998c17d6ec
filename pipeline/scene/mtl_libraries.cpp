// SPDX-License-Identifier: MIT
#include "pipeline/scene/mtl_libraries.h"

#include "host/error.h"
#include "pipeline/scene/input.h"
#include "pipeline/scene/ray_shares.h"

#include <fmt/core.h>
#include <algorithm>
#include <glm/glm.hpp>
#include <system_error>
#include <utility>

namespace plumb {

namespace fs = std::filesystem;

// Most kinds of unknown statements. A text with more is not the format that its name promises.
static constexpr size_t kMaxUnknownKinds = 64;

void ignoreStatement(const Scanner& in, const std::string& what, const LoadOptions& options, PolygonMesh& mesh) {
    if (std::find(mesh.ignored.begin(), mesh.ignored.end(), what) != mesh.ignored.end()) return;
    if (options.strict) in.refuse(what + " would be ignored (--strict)");
    mesh.ignored.push_back(what);
}

void ignoreUnknown(const Scanner& in, std::string_view key, std::string_view format, const LoadOptions& options, PolygonMesh& mesh) {
    const bool plausible = key.size() <= 32 && std::all_of(key.begin(), key.end(), [](char c) {
                               return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
                           });
    if (!plausible) in.refuse(fmt::format("'{}' is not an {} statement", printable(key, 40), format));
    ignoreStatement(in, fmt::format("{} statement {}", format, key), options, mesh);
    if (mesh.ignored.size() > kMaxUnknownKinds) in.refuse(fmt::format("more than {} kinds of unknown statements", kMaxUnknownKinds));
}

static bool isThere(const fs::path& path) {
    std::error_code failed;
    return fs::exists(path, failed);
}

static bool equalIgnoringCase(std::string_view a, std::string_view b) {
    return a.size() == b.size() && editDistance(a, b, Letters::anyCase) == 0;
}

// Name of a file as this system would write a name of another one: "sub/a.mtl" of "sub\a.mtl", and "a.mtl" where the path leads out of the
// folder ("C:\work\a.mtl", "..\a.mtl").
static std::string ownNameOf(std::string_view name) {
    std::string own(name);
    std::replace(own.begin(), own.end(), '\\', '/');
    const bool drive = own.size() > 1 && own[1] == ':';
    const fs::path path(own);
    const bool leaves = drive || path.is_absolute() || std::find(path.begin(), path.end(), fs::path("..")) != path.end();
    return leaves ? path.filename().string() : own;
}

// Path of the library `name`; what does not exist here is looked for as another system may have written it.
fs::path MtlLibraries::find(const std::string& location, std::string_view name) {
    const fs::path base = referenceBase(obj_, options_);
    const auto resolved = [&](std::string_view reference) {
        return resolveReference(base, reference, options_.allowOutside, location, "material library");
    };
    fs::path path = resolved(name);
    if (isThere(path)) return path;
    const std::string own = ownNameOf(name);
    if (own.empty()) return path;
    path = resolved(own);
    if (!isThere(path)) {  // in another case
        std::error_code failed;
        const fs::path folder = path.parent_path().empty() ? fs::path(".") : path.parent_path();
        std::vector<std::string> found;
        for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
            if (equalIgnoringCase(entry->path().filename().native(), path.filename().native()))
                found.push_back(entry->path().filename().string());
        if (found.empty()) return path;
        std::sort(found.begin(), found.end());  // no result depends on the order of a folder
        path = resolved((fs::path(own).parent_path() / found.front()).string());
    }
    tolerance_.pass(fmt::format("material library '{}' is read from '{}'", printable(name), printablePath(path.filename())),
                    [&] { return location; });
    return path;
}

void MtlLibraries::load(Scanner& in) {
    const std::string_view all = in.restOfLine();
    if (all.empty()) return tolerance_.pass("'mtllib' names no material library; it is passed over", [&] { return in.location(); });
    if (!options_.keepMaterials) return;
    // A name may contain blanks, and the format also permits several names.
    if (loadNamed(in, all, all.find_first_of(" \t") == std::string_view::npos)) return;
    for (std::string_view rest = all; !rest.empty();) {
        const size_t length = std::min(rest.find_first_of(" \t"), rest.size());
        if (length > 0) loadNamed(in, rest.substr(0, length), true);
        rest.remove_prefix(std::min(length + 1, rest.size()));
    }
}

// Reads a material library. False when there is no such file; a missing file is noted when `last` says that the name can mean nothing else.
bool MtlLibraries::loadNamed(const Scanner& in, std::string_view name, bool last) {
    const std::string location = in.location();
    const fs::path library = find(location, name);
    if (!isThere(library)) {
        if (!last) return false;
        if (options_.strict) throw inputError(location, fmt::format("material library '{}' is missing (--strict)", printable(name)));
        if (missing_.empty()) missing_ = fmt::format("{}: material library '{}' is missing", location, printable(name));
        return true;
    }
    if (std::find(read_.begin(), read_.end(), library) != read_.end()) return true;
    read_.push_back(library);
    read(library);
    return true;
}

void MtlLibraries::read(const fs::path& path) {
    std::string text = readWholeFile(path);
    takeByteOrderMark(text, path);
    Scanner in(text, path);
    Defined* defined = nullptr;
    while (!in.atEnd()) {
        const std::string_view key = in.word();
        if (key == "newmtl") {
            const std::string_view name = in.restOfLine();
            // The first definition of a name is the one that counts.
            byName_.try_emplace(std::string(name), uint32_t(defined_.size()));
            defined = &defined_.emplace_back();
            defined->material.name = name;
            defined->location = printablePath(path) + ": material '" + printable(name) + "'";
        } else if (!key.empty() && key[0] != '#') {
            if (!defined) in.refuse(fmt::format("'{}' comes before newmtl", printable(key, 40)));
            try {
                property(in, key, *defined);
            } catch (const Error&) {
                // Refused where a face has the material; what no face has is not drawn.
                if (options_.strict) throw;
                if (!defined->refusal) defined->refusal = std::current_exception();
            }
        }
        in.skipLine();
    }
}

glm::vec3 MtlLibraries::colour(Scanner& in, std::string_view field, bool& clamped) {
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

void MtlLibraries::property(Scanner& in, std::string_view key, Defined& defined) {
    Material& material = defined.material;
    if (key == "Ka" || key == "Kd" || key == "Ks" || key == "Ke") {
        Scanner ahead = in;
        const std::string_view form = ahead.word();
        if (form == "spectral" || form == "xyz") return ignoreStatement(in, fmt::format("MTL {} {}", key, form), options_, mesh_);
        const glm::vec3 value = colour(in, key, defined.clamped);
        (key == "Ka" ? material.ambient : key == "Kd" ? material.diffuse : key == "Ks" ? material.specular : material.emission) = value;
    } else if (key == "Ns") {
        const float value = in.number("Ns");
        if (value < 0) in.refuse("Ns is negative");
        defined.clamped |= value > 1e6f;
        material.shininess = std::min(value, 1e6f);
    } else if (key == "Ni") {
        const float value = in.number("Ni");
        if (value < 0) in.refuse("Ni is negative");
        material.refractiveIndex = value == 0 ? 1.0f : value;  // exporters write 0 for "not stated"
    } else if (key == "d" || key == "Tr") {
        std::string_view word = in.word();
        if (key == "d" && word == "-halo") {
            ignoreStatement(in, "MTL d -halo", options_, mesh_);
            word = in.word();
        }
        const float value = in.number(word, key);
        const float inside = std::clamp(value, 0.0f, 1.0f);
        defined.clamped |= inside != value;
        material.opacity = key == "d" ? inside : 1.0f - inside;
    } else if (key == "illum") {
        const int64_t value = in.integer(in.word(), "illum");
        if (value < 0 || value > 10) in.refuse("illum is not in 0 to 10");
        material.illum = int(value);
        if (value == 10) ignoreStatement(in, "shadows on invisible surfaces (illum 10)", options_, mesh_);
    } else {
        defined.emissionMapped |= key == "map_Ke";
        ignoreUnknown(in, key, "MTL", options_, mesh_);
    }
}

void MtlLibraries::take(const Defined& defined) {
    Material& material = mesh_.materials.emplace_back(defined.material);
    if (material.opacity < 1 && !illumIsGlass(material.illum)) {
        const std::string what = "transparency (d, Tr)";
        if (options_.strict) throw inputError(defined.location, what + " would be ignored (--strict)");
        if (std::find(mesh_.ignored.begin(), mesh_.ignored.end(), what) == mesh_.ignored.end()) mesh_.ignored.push_back(what);
    }
    if (defined.emissionMapped && material.emission != glm::vec3(0)) {
        tolerance_.pass("Ke is the factor of a texture that is not drawn; it is left out", [&] { return defined.location; });
        material.emission = glm::vec3(0);
    }
    // Kinds 0 and 1 of illum have no highlight, whatever Ks says. Kind 0 is the colour Kd without any light.
    if (material.illum < 2) material.specular = glm::vec3(0);
    if (material.illum == 0) {
        material.emission = glm::min(material.emission + material.diffuse, glm::vec3(1));
        material.ambient = material.diffuse = glm::vec3(0);
    }
}

void MtlLibraries::assign(const std::vector<Used>& used) {
    std::vector<uint32_t> indexOf(used.size(), kNone);
    std::vector<bool> drawn(defined_.size());
    uint64_t lost = 0;
    std::string firstLost;
    for (size_t i = 0; i < used.size(); ++i) {
        if (used[i].faces == 0) continue;
        const auto found = byName_.find(used[i].name);
        if (found == byName_.end()) {
            lost += used[i].faces;
            if (firstLost.empty()) firstLost = used[i].name;
            continue;
        }
        const Defined& defined = defined_[found->second];
        if (defined.refusal) std::rethrow_exception(defined.refusal);
        drawn[found->second] = true;
        if (defined.clamped)
            tolerance_.pass("a used material has values outside their range; they are clamped", [&] { return defined.location; });
        indexOf[i] = uint32_t(mesh_.materials.size());
        take(defined);
    }
    for (uint32_t& material : mesh_.faceMaterial)
        if (material != kNone) material = indexOf[material];
    for (size_t i = 0; i < defined_.size(); ++i)
        if (defined_[i].refusal && !drawn[i])
            tolerance_.pass("a material that no face has cannot be read; it is passed over", [&] { return defined_[i].location; });
    warn(lost, firstLost);
}

void MtlLibraries::warn(uint64_t lost, const std::string& firstLost) {
    if (!missing_.empty())
        mesh_.warnings.push_back(fmt::format("{}; {} faces have the default material", missing_, lost));
    else if (lost > 0 && options_.keepMaterials)
        mesh_.warnings.push_back(fmt::format("{}: material '{}' is not defined; {} faces have the default material", printablePath(obj_),
                                             printable(firstLost), lost));
}

}  // namespace plumb
