// SPDX-License-Identifier: MIT
#include "pipeline/detail/simplify_mesh.h"

#include "pipeline/detail/deviation.h"

#include <fmt/core.h>
#include <meshoptimizer.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace plumb::detail {
namespace {

// Tries, each with half of the error before. The library's error is a mean over planes, which the deviation of single points exceeds.
constexpr int kTries = 6;

Surface surfaceOf(const TriangleMesh& mesh, const std::vector<uint32_t>& indices) {
    std::vector<Corners> triangles;
    triangles.reserve(indices.size() / 3);
    for (size_t i = 0; i < indices.size(); i += 3)
        triangles.push_back({glm::dvec3(mesh.positions[indices[i]]), glm::dvec3(mesh.positions[indices[i + 1]]),
                             glm::dvec3(mesh.positions[indices[i + 2]])});
    return Surface(std::move(triangles));
}

// True when corners of every triangle have one material, as the passes take it.
bool keepsMaterials(const TriangleMesh& mesh, const std::vector<uint32_t>& indices) {
    for (size_t i = 0; i < indices.size(); i += 3)
        for (size_t k = 1; k < 3; ++k)
            if (mesh.vertexMaterial[indices[i + k]] != mesh.vertexMaterial[indices[i]]) return false;
    return true;
}

// Mesh of the vertices that the indices name.
TriangleMesh meshOf(const TriangleMesh& mesh, const std::vector<uint32_t>& indices) {
    TriangleMesh out;
    out.name = mesh.name;
    out.location = mesh.location;
    out.origin = mesh.origin;
    out.lost = mesh.lost;
    std::vector<uint32_t> newOf(mesh.positions.size(), kNone);
    const auto vertexOf = [&](uint32_t v) {
        if (newOf[v] == kNone) {
            newOf[v] = uint32_t(out.positions.size());
            out.positions.push_back(mesh.positions[v]);
            out.normals.push_back(mesh.normals[v]);
            out.vertexMaterial.push_back(mesh.vertexMaterial[v]);
            if (!mesh.stated.empty()) out.stated.push_back(mesh.stated[v]);
        }
        return newOf[v];
    };
    std::map<std::tuple<float, float, float>, uint32_t> placeOf;  // edges are those of positions, whatever normals meet there
    std::map<std::pair<uint32_t, uint32_t>, bool> known;
    for (size_t i = 0; i < indices.size(); i += 3) {
        const uint32_t face = uint32_t(out.triangles.size());
        const uint32_t v[3] = {vertexOf(indices[i]), vertexOf(indices[i + 1]), vertexOf(indices[i + 2])};
        out.triangles.push_back({{v[0], v[1], v[2]}, face});
        const glm::dvec3 a(out.positions[v[0]]), b(out.positions[v[1]]), c(out.positions[v[2]]);
        const glm::dvec3 n = glm::cross(b - a, c - a);
        const double length = glm::length(n);
        out.degenerateFaces += !(length > 0);
        out.faceNormal.push_back(length > 0 ? glm::vec3(n / length) : glm::vec3(0, 0, 1));
        out.faceCentre.push_back(glm::vec3((a + b + c) / 3.0));
        out.faceMaterial.push_back(out.vertexMaterial[v[0]]);
        uint32_t place[3];
        for (size_t k = 0; k < 3; ++k) {
            const glm::vec3& p = out.positions[v[k]];
            place[k] = placeOf.try_emplace({p.x, p.y, p.z}, v[k]).first->second;
        }
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t from = place[k], to = place[(k + 1) % 3];
            if (known.try_emplace(std::minmax(from, to), true).second) out.edges.emplace_back(v[k], v[(k + 1) % 3]);
        }
    }
    out.boundsMin = out.boundsMax = out.positions.front();
    for (const glm::vec3& p : out.positions) out.boundsMin = glm::min(out.boundsMin, p), out.boundsMax = glm::max(out.boundsMax, p);
    out.statedMin = out.origin + glm::dvec3(out.boundsMin);
    out.statedMax = out.origin + glm::dvec3(out.boundsMax);
    return out;
}

}  // namespace

std::optional<TriangleMesh> simplified(const TriangleMesh& mesh, double deviation, uint32_t threads, const std::function<void()>& alive) {
    std::vector<uint32_t> all;
    all.reserve(3 * mesh.triangles.size());
    for (const TriangleMesh::Triangle& t : mesh.triangles) all.insert(all.end(), t.vertex, t.vertex + 3);
    if (all.empty()) return std::nullopt;
    const float* positions = &mesh.positions[0].x;
    const double scale = meshopt_simplifyScale(positions, mesh.positions.size(), sizeof(glm::vec3));
    if (!(scale > 0)) return std::nullopt;
    std::optional<Surface> whole;
    double error = deviation / scale;
    for (int i = 0; i < kTries; ++i, error /= 2) {
        alive();
        std::vector<uint32_t> kept(all.size());
        kept.resize(meshopt_simplify(kept.data(), all.data(), all.size(), positions, mesh.positions.size(), sizeof(glm::vec3), 0,
                                     float(std::min(error, 1.0)), 0, nullptr));
        if (kept.size() == all.size()) return std::nullopt;
        if (kept.empty() || !keepsMaterials(mesh, kept)) continue;
        if (!whole) whole.emplace(surfaceOf(mesh, all));
        if (within(*whole, surfaceOf(mesh, kept), deviation, threads, alive)) return meshOf(mesh, kept);
    }
    return std::nullopt;
}

std::string simplifierName() { return fmt::format("meshoptimizer {}.{}", MESHOPTIMIZER_VERSION / 1000, MESHOPTIMIZER_VERSION % 1000 / 10); }

}  // namespace plumb::detail
