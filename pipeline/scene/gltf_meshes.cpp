// SPDX-License-Identifier: MIT
#include "pipeline/scene/gltf_meshes.h"

#include "host/error.h"
#include "pipeline/scene/add_mesh.h"
#include "pipeline/scene/input.h"
#include "pipeline/scene/mesh.h"
#include "pipeline/scene/positions.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
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
        const Key key{std::bit_cast<uint64_t>(v.x), std::bit_cast<uint64_t>(v.y), std::bit_cast<uint64_t>(v.z)};
        const auto [found, isNew] = known_.try_emplace(key, uint32_t(into_.size()));
        if (isNew) into_.push_back(typename List::value_type(v));
        return found->second;
    }

private:
    using Key = std::array<uint64_t, 3>;
    struct Hash {
        size_t operator()(const Key& key) const {
            uint64_t h = 0x9e3779b97f4a7c15u;
            for (uint64_t word : key) h = std::rotl((h ^ word) * 0xff51afd7ed558ccdu, 31);
            return size_t(h);
        }
    };
    List& into_;
    std::unordered_map<Key, uint32_t, Hash> known_;
};

// Accessors of one primitive.
struct PrimitiveData {
    Accessor position;
    std::optional<Accessor> normal, indices;
    size_t count() const { return indices ? indices->count : position.count; }
};

// Quantized positions and normals (KHR_mesh_quantization) are accepted whether or not the file says so.
Accessor vectorsAt(const Value& index, const char* name, Accessors& accessors) {
    Accessor vector = accessors.at(index);
    if (vector.components != 3 || vector.componentType == 5125)
        index.refuse(fmt::format("{} is not an accessor of VEC3 of a vertex type", name));
    return vector;
}

PrimitiveData dataOf(const Value& primitive, const Value& positionIndex, Accessors& accessors, const Reading& reading) {
    PrimitiveData data{vectorsAt(positionIndex, "POSITION", accessors)};
    if (const auto value = primitive.required("attributes").find("NORMAL")) {
        data.normal = vectorsAt(*value, "NORMAL", accessors);
        if (data.normal->count != data.position.count)
            value->refuse(fmt::format("NORMAL has {} elements, POSITION has {}", data.normal->count, data.position.count));
        if (!data.normal->hasData() && data.normal->count > 0) reading.pass(*value, "NORMAL has no data; it counts as not stated");
        if (!data.normal->hasData()) data.normal.reset();
    }
    if (const auto value = primitive.find("indices")) {
        data.indices = accessors.at(*value);
        if (!data.indices->isIndex()) value->refuse("is not an accessor of SCALAR of an index type");
    }
    return data;
}

// Corners of one primitive, by their numbers in it.
class PrimitiveCorners {
public:
    PrimitiveCorners(const PrimitiveData& data, const RestVertices& rest, const Value& primitive, const Reading& reading,
                     Welder<Positions>& positions, Welder<std::vector<glm::vec3>>& normals)
        : data_(data), rest_(rest), primitive_(primitive), reading_(reading), positions_(positions), normals_(normals) {
        // Remembered only where the memory is in proportion to what is drawn.
        if (data.position.count <= 4 * data.count()) known_.assign(data.position.count, PolygonMesh::Corner{kNone});
    }

    uint32_t vertexOf(size_t i) const { return data_.indices ? data_.indices->index(i) : uint32_t(i); }

    PolygonMesh::Corner corner(size_t i) {
        const uint32_t vertex = vertexOf(i);
        if (vertex >= data_.position.count)
            throw inputError(data_.indices->location,
                             fmt::format("element {} is vertex {}, but POSITION has {}", i, vertex, data_.position.count));
        if (!known_.empty() && known_[vertex].position != kNone) return known_[vertex];
        glm::dvec3 read(0);
        int bad = load(data_.position, vertex, read);
        if (bad < 3)
            throw inputError(data_.position.location, fmt::format("element {}: POSITION {} is {}", vertex, "xyz"[bad],
                                                                  std::isnan(read[bad])   ? "NaN"
                                                                  : std::isinf(read[bad]) ? "infinite"
                                                                                          : "above 2^100"));
        const glm::dvec3 atRest = rest_.position(vertex, read);
        for (int i = 0; i < 3; ++i)
            if (!(std::abs(atRest[i]) <= kMaxCoordinate))
                throw inputError(data_.position.location, fmt::format("element {}: at rest POSITION {} is above 2^100", vertex, "xyz"[i]));
        PolygonMesh::Corner made{positions_.add(atRest)};
        if (data_.normal) {
            bad = load(*data_.normal, vertex, read);
            if (bad == 3)
                made.normal = normals_.add(rest_.normal(vertex, read));
            else
                reading_.pass(primitive_, "a NORMAL is not finite; it counts as not stated");
        }
        if (!known_.empty()) known_[vertex] = made;
        return made;
    }

private:
    // Loads an element; returns the first component that is not finite or too large, 3 when all are good.
    static int load(const Accessor& from, size_t element, glm::dvec3& v) {
        int bad = 3;
        for (int i = 2; i >= 0; --i) {
            v[i] = from.component(element, i);
            if (!(std::abs(v[i]) <= kMaxCoordinate)) bad = i;
        }
        return bad;
    }

    const PrimitiveData& data_;
    const RestVertices& rest_;
    const Value& primitive_;
    const Reading& reading_;
    Welder<Positions>& positions_;
    Welder<std::vector<glm::vec3>>& normals_;
    std::vector<PolygonMesh::Corner> known_;  // by vertex; may be empty
};

// Number of triangles of a primitive with `count` corners. Left over corners and primitives without a triangle are passed over.
size_t trianglesOf(uint64_t mode, size_t count, const Value& primitive, const Reading& reading) {
    if (count < 3) {
        reading.pass(primitive, count == 0 ? "is empty; it is passed over" : "has fewer than 3 vertices; it is passed over");
        return 0;
    }
    if (mode != 4) return count - 2;
    if (count % 3 != 0) reading.pass(primitive, "has vertices left over that make no whole triangle; they are not drawn");
    return count / 3;
}

// Refuses a primitive whose data is in a form that is not read.
void refuseCompressed(const Value& primitive) {
    if (const auto extensions = primitive.find("extensions"))
        if (const auto draco = extensions->find("KHR_draco_mesh_compression"))
            draco->refuse("KHR_draco_mesh_compression is not read, and the primitive has no data beside it");
}

struct MeshParts {
    PolygonMesh& mesh;
    Welder<Positions>& positions;
    Welder<std::vector<glm::vec3>>& normals;
};

void readPrimitive(const Value& primitive, const Reading& reading, Accessors& accessors, Materials& materials, const Rest& rest,
                   MeshParts& parts) {
    reading.ignoreExtensions(primitive, {});
    const auto modeValue = primitive.find("mode");
    const uint64_t mode = modeValue ? modeValue->whole(6) : 4;
    if (mode < 4) return reading.ignore(primitive, mode == 0 ? "points" : "lines");
    const Value attributes = primitive.required("attributes");
    if (const auto colours = attributes.find("COLOR_0")) reading.ignore(*colours, "vertex colours");
    const auto positionIndex = attributes.find("POSITION");
    if (!positionIndex) return reading.ignore(attributes, "primitives without POSITION");
    const PrimitiveData data = dataOf(primitive, *positionIndex, accessors, reading);
    const size_t triangles = trianglesOf(mode, data.count(), primitive, reading);
    if (triangles == 0) return;
    if (!data.position.hasData() || (data.indices && !data.indices->hasData())) {
        refuseCompressed(primitive);
        return reading.pass(primitive, "has no data; all its vertices are one point");
    }
    accessors.countCorners(3 * triangles, primitive);
    PolygonMesh& mesh = parts.mesh;
    if (mesh.corners.size() + 3 * triangles >= kNone) primitive.refuse("the mesh has 2^32 corners or more");
    const uint32_t material = materials.of(primitive);
    const RestVertices vertices(primitive, rest, data.position.count, accessors, reading);
    PrimitiveCorners corners(data, vertices, primitive, reading, parts.positions, parts.normals);
    LoadMeter meter(reading.options, "parse", kParseEnds, kParseEnds, triangles);
    for (size_t t = 0; t < triangles; ++t) {
        meter.at(t);
        // glTF 3.7.2.1: odd triangles of a strip swap their last two vertices; a fan starts each with v1, v2.
        const std::array<size_t, 3> at = mode == 4   ? std::array<size_t, 3>{3 * t, 3 * t + 1, 3 * t + 2}
                                         : mode == 5 ? std::array<size_t, 3>{t, t + 1 + t % 2, t + 2 - t % 2}
                                                     : std::array<size_t, 3>{t + 1, t + 2, 0};
        for (size_t i : at) mesh.corners.push_back(corners.corner(i));
        if (vertices.mirrored(corners.vertexOf(at[0]))) std::swap(mesh.corners.end()[-1], mesh.corners.end()[-2]);
        mesh.faceFirst.push_back(uint32_t(mesh.corners.size()));
        mesh.faceMaterial.push_back(material);
        mesh.faceSmoothing.push_back(data.normal ? kNone : 0);  // glTF 3.7.2.1: without normals, flat
    }
}

}  // namespace

Meshes::Meshes(const Container& container, Materials& materials, Accessors& accessors, const Reading& reading)
    : reading_(reading), materials_(materials), meshes_(container.root().list("meshes")), accessors_(accessors), shared_(meshes_.size()) {}

std::vector<double> Meshes::weightsOf(const Value& index) const { return weightsIn(meshes_[index.index(meshes_.size(), "meshes")]); }

uint32_t Meshes::inScene(const Value& index, const Rest& rest) {
    const size_t i = index.index(meshes_.size(), "meshes");
    const bool shareable = rest.joints.empty();
    if (shareable && shared_[i] && shared_[i]->weights == rest.weights) return shared_[i]->inScene;
    // Each mesh has its part of what follows the JSON.
    LoadOptions own = reading_.options;
    const double share = (own.to - own.from) / double(meshes_.size());
    own.from += share * double(std::min(read_++, meshes_.size() - 1));
    own.to = own.from + share;
    PolygonMesh mesh;
    mesh.name = fmt::format("mesh {}", i);
    if (const auto name = meshes_[i].find("name")) mesh.name = name->text();
    mesh.faceFirst.push_back(0);
    Welder<Positions> positions(mesh.positions);
    Welder<std::vector<glm::vec3>> normals(mesh.normals);
    MeshParts parts{mesh, positions, normals};
    meshes_[i].required("primitives");
    for (const Value& primitive : meshes_[i].list("primitives")) readPrimitive(primitive, reading_, accessors_, materials_, rest, parts);
    const uint32_t made = mesh.faceMaterial.empty() ? kNone : addMesh(reading_.scene, std::move(mesh), meshes_[i].location(), own);
    if (shareable) shared_[i] = Shared{rest.weights, made};
    return made;
}

}  // namespace plumb::gltf
