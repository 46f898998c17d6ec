// SPDX-License-Identifier: MIT
#include "pipeline/render/notes/polygons.h"

#include "pipeline/scene/flattened.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <glm/glm.hpp>
#include <set>

namespace plumb {

std::vector<std::pair<uint32_t, uint32_t>> boundaryOf(std::span<const TriangleMesh::Triangle> triangles) {
    std::vector<std::pair<uint32_t, uint32_t>> edges;
    for (const TriangleMesh::Triangle& t : triangles)
        for (size_t i = 0; i < 3; ++i) {
            const uint32_t a = t.vertex[i], b = t.vertex[(i + 1) % 3];
            const auto twin = std::find(edges.begin(), edges.end(), std::pair(b, a));
            if (twin != edges.end())
                edges.erase(twin);
            else
                edges.emplace_back(a, b);
        }
    return edges;
}

std::vector<uint32_t> outlineOf(std::span<const TriangleMesh::Triangle> triangles) {
    const std::vector<std::pair<uint32_t, uint32_t>> edges = boundaryOf(triangles);
    std::vector<uint32_t> outline;
    for (uint32_t at = edges.empty() ? 0 : edges[0].first; outline.size() < edges.size();) {
        const auto next = std::find_if(edges.begin(), edges.end(), [&](const auto& e) { return e.first == at; });
        if (next == edges.end()) return {};
        outline.push_back(at);
        at = next->second;
        if (at == outline[0]) break;
    }
    return outline.size() == edges.size() ? outline : std::vector<uint32_t>{};
}

Newell newellOf(std::span<const glm::dvec3> world) {
    Newell n;
    for (size_t i = 0; i < world.size(); ++i) {
        const glm::dvec3 a = world[i] - world[0], b = world[(i + 1) % world.size()] - world[0];
        n.normal += glm::cross(a, b);
        n.size += glm::abs(glm::dvec3(a.y * b.z, a.z * b.x, a.x * b.y)) + glm::abs(glm::dvec3(a.z * b.y, a.x * b.z, a.y * b.x));
    }
    return n;
}

std::vector<FaceTriangles> facesOf(const TriangleMesh& mesh) {
    std::vector<FaceTriangles> faces;
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (faces.empty() || faces.back().face != mesh.triangles[t].face) faces.push_back({mesh.triangles[t].face, t, 0});
        ++faces.back().count;
    }
    return faces;
}

namespace {

// Position by its bits: vertices that differ only in normal or material are one point.
using Point = std::array<uint32_t, 3>;
Point pointOf(const glm::vec3& p) { return {std::bit_cast<uint32_t>(p.x), std::bit_cast<uint32_t>(p.y), std::bit_cast<uint32_t>(p.z)}; }

}  // namespace

std::vector<WireEdge> wireEdges(const TriangleMesh& mesh, const glm::dmat4& worldFromMesh, const glm::dvec3& eye, WireChoices choices) {
    std::vector<WireEdge> edges;
    if (!choices.perPolygon && !choices.facingOnly) {
        for (const glm::uvec2& e : mesh.edges) edges.push_back({e, kNone});
        return edges;
    }
    const bool mirrored = mirrors(worldFromMesh);
    std::set<std::pair<Point, Point>> drawn;
    for (const FaceTriangles& f : facesOf(mesh)) {
        const std::span<const TriangleMesh::Triangle> own(mesh.triangles.data() + f.first, f.count);
        const std::vector<uint32_t> outline = outlineOf(own);
        if (choices.facingOnly) {
            std::vector<glm::dvec3> around;
            const auto add = [&](uint32_t v) { around.emplace_back(worldFromMesh * glm::dvec4(mesh.positions[v], 1)); };
            std::for_each(outline.begin(), outline.end(), add);
            if (outline.empty()) std::for_each(own[0].vertex, own[0].vertex + 3, add);
            if (!newellOf(around).faces(eye - around[0], mirrored)) continue;
        }
        std::vector<std::pair<uint32_t, uint32_t>> boundary = boundaryOf(own);
        for (size_t i = 0; i < outline.size(); ++i) boundary[i] = {outline[i], outline[(i + 1) % outline.size()]};
        for (const auto& [a, b] : boundary) {
            Point p = pointOf(mesh.positions[a]), q = pointOf(mesh.positions[b]);
            if (q < p) std::swap(p, q);
            if (choices.perPolygon || drawn.emplace(p, q).second) edges.push_back({{a, b}, f.face});
        }
    }
    return edges;
}

}  // namespace plumb
