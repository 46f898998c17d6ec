// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_meshes.h"

#include "host/error.h"
#include "pipeline/scene/add_mesh.h"
#include "pipeline/scene/input.h"
#include "pipeline/scene/mesh.h"
#include "pipeline/scene/positions.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <array>
#include <bit>
#include <cmath>
#include <glm/glm.hpp>
#include <string>
#include <unordered_map>
#include <utility>

namespace plumb::gltf {
namespace {

// Vertices with the same bits of position (or normal) become one: glTF repeats a position at every seam, and edges
// and creases are found by position. -0 counts as +0.
template <class List>
class Welder {
public:
    explicit Welder(List& into) : into_(into) {}
    uint32_t add(glm::dvec3 v) {
        v += 0.0;  // -0 becomes +0
        // No two numbers of a vertex type have the same float32.
        const Key key{std::bit_cast<uint32_t>(float(v.x)), std::bit_cast<uint32_t>(float(v.y)), std::bit_cast<uint32_t>(float(v.z))};
        const auto [found, isNew] = known_.try_emplace(key, uint32_t(into_.size()));
        if (isNew) into_.push_back(typename List::value_type(v));
        return found->second;
    }

private:
    using Key = std::array<uint32_t, 3>;
    struct Hash {
        size_t operator()(const Key& key) const {
            uint64_t h = 0x9e3779b97f4a7c15u;
            for (uint32_t word : key) h = std::rotl((h ^ word) * 0xff51afd7ed558ccdu, 31);
            return size_t(h);
        }
    };
    List& into_;
    std::unordered_map<Key, uint32_t, Hash> known_;
};

// Corners of one primitive, by their numbers in it.
class PrimitiveCorners {
public:
    PrimitiveCorners(const Value& primitive, const Value& positionIndex, Accessors& accessors)
        : position_(vectors(positionIndex, "POSITION", accessors)) {
        if (const auto value = primitive.required("attributes").find("NORMAL")) {
            normal_ = vectors(*value, "NORMAL", accessors);
            if (normal_->count != position_.count)
                value->refuse(fmt::format("NORMAL has {} elements, POSITION has {}", normal_->count, position_.count));
        }
        if (const auto value = primitive.find("indices")) {
            indices_ = accessors.at(*value);
            if (!indices_->isIndex()) value->refuse("is not an accessor of SCALAR of an index type");
        }
        // Remembered only where the memory is in proportion to what is drawn.
        if (position_.count <= 4 * count()) known_.assign(position_.count, PolygonMesh::Corner{kNone});
    }

    size_t count() const { return indices_ ? indices_->count : position_.count; }
    bool hasNormals() const { return normal_.has_value(); }

    PolygonMesh::Corner corner(size_t i, Welder<Positions>& positions, Welder<std::vector<glm::vec3>>& normals) {
        const uint32_t vertex = indices_ ? indices_->index(i) : uint32_t(i);
        if (vertex >= position_.count)
            throw inputError(indices_->place, fmt::format("element {} is vertex {}, but POSITION has {}", i, vertex, position_.count));
        if (!known_.empty() && known_[vertex].position != kNone) return known_[vertex];
        PolygonMesh::Corner made{positions.add(load(position_, vertex, "POSITION"))};
        if (normal_) made.normal = normals.add(load(*normal_, vertex, "NORMAL"));
        if (!known_.empty()) known_[vertex] = made;
        return made;
    }

private:
    // Quantized positions and normals (KHR_mesh_quantization) are accepted whether or not the file says so.
    static Accessor vectors(const Value& index, const char* name, Accessors& accessors) {
        Accessor vector = accessors.at(index);
        if (vector.components != 3 || vector.componentType == 5125)
            index.refuse(fmt::format("{} is not an accessor of VEC3 of a vertex type", name));
        return vector;
    }

    static glm::dvec3 load(const Accessor& from, size_t element, const char* name) {
        glm::dvec3 v;
        for (int i = 0; i < 3; ++i) {
            const double value = from.component(element, i);
            if (!(std::abs(value) <= kMaxCoordinate))
                throw inputError(from.place, fmt::format("element {}: {} {} is {}", element, name, "xyz"[i],
                                                         std::isnan(value)   ? "NaN"
                                                         : std::isinf(value) ? "infinite"
                                                                             : "above 2^100"));
            v[i] = value;
        }
        return v;
    }

    Accessor position_;
    std::optional<Accessor> normal_, indices_;
    std::vector<PolygonMesh::Corner> known_;  // by vertex; may be empty
};

struct MeshParts {
    PolygonMesh& mesh;
    Welder<Positions>& positions;
    Welder<std::vector<glm::vec3>>& normals;
};

void readPrimitive(const Value& primitive, const Reading& reading, Accessors& accessors, MeshParts& parts) {
    reading.ignoreExtensions(primitive, {});
    const auto modeValue = primitive.find("mode");
    const uint64_t mode = modeValue ? modeValue->whole(6) : 4;
    if (mode < 4) return reading.ignore(primitive, mode == 0 ? "points" : "lines");
    const Value attributes = primitive.required("attributes");
    if (const auto targets = primitive.find("targets")) reading.ignore(*targets, "morph targets");
    if (const auto colours = attributes.find("COLOR_0")) reading.ignore(*colours, "vertex colours");
    const auto positionIndex = attributes.find("POSITION");
    if (!positionIndex) return reading.ignore(attributes, "primitives without POSITION");
    PrimitiveCorners corners(primitive, *positionIndex, accessors);

    const size_t count = corners.count();
    if (mode == 4 && count % 3 != 0) primitive.refuse(fmt::format("{} vertices make no whole triangles", count));
    if (mode != 4 && count < 3) primitive.refuse(fmt::format("{} vertices make no triangle", count));
    const size_t triangles = mode == 4 ? count / 3 : count - 2;
    accessors.countCorners(3 * triangles, primitive);
    PolygonMesh& mesh = parts.mesh;
    if (mesh.corners.size() + 3 * triangles >= kNone) primitive.refuse("the mesh has 2^32 corners or more");
    const auto materialValue = primitive.find("material");
    const uint32_t material = materialValue ? uint32_t(materialValue->index(reading.scene.materials.size() - 1, "materials")) + 1 : 0;
    LoadMeter meter(reading.options, "parse", kParseEnds, kParseEnds, triangles);
    for (size_t t = 0; t < triangles; ++t) {
        meter.at(t);
        // glTF 3.7.2.1: odd triangles of a strip swap their last two vertices; a fan starts each with v1, v2.
        const std::array<size_t, 3> at = mode == 4   ? std::array<size_t, 3>{3 * t, 3 * t + 1, 3 * t + 2}
                                         : mode == 5 ? std::array<size_t, 3>{t, t + 1 + t % 2, t + 2 - t % 2}
                                                     : std::array<size_t, 3>{t + 1, t + 2, 0};
        for (size_t i : at) mesh.corners.push_back(corners.corner(i, parts.positions, parts.normals));
        mesh.faceFirst.push_back(uint32_t(mesh.corners.size()));
        mesh.faceMaterial.push_back(material);
        mesh.faceSmoothing.push_back(corners.hasNormals() ? kNone : 0);  // glTF 3.7.2.1: without normals, flat
    }
}

}  // namespace

Meshes::Meshes(const Container& container, const Reading& reading)
    : reading_(reading), meshes_(container.root().list("meshes")), accessors_(container, reading.options), inScene_(meshes_.size()) {}

uint32_t Meshes::inScene(const Value& index) {
    const size_t i = index.index(meshes_.size(), "meshes");
    if (inScene_[i]) return *inScene_[i];
    // Each mesh has its part of what follows the JSON.
    LoadOptions own = reading_.options;
    const double share = (own.to - own.from) / double(meshes_.size());
    own.from += share * double(read_++);
    own.to = own.from + share;
    PolygonMesh mesh;
    mesh.name = fmt::format("mesh {}", i);
    if (const auto name = meshes_[i].find("name")) mesh.name = name->text();
    mesh.faceFirst.push_back(0);
    Welder<Positions> positions(mesh.positions);
    Welder<std::vector<glm::vec3>> normals(mesh.normals);
    MeshParts parts{mesh, positions, normals};
    meshes_[i].required("primitives");
    for (const Value& primitive : meshes_[i].list("primitives")) readPrimitive(primitive, reading_, accessors_, parts);
    inScene_[i] = mesh.faceMaterial.empty() ? kNone : addMesh(reading_.scene, std::move(mesh), meshes_[i].place(), own);
    return *inScene_[i];
}

}  // namespace plumb::gltf
