// SPDX-License-Identifier: MIT
// Polygons of a mesh as the lecture notes see them: their outline, and whether they face the viewer (12.4). In binary64 on the host: facing
// is a decision, so it is taken once for device and twin.
#pragma once

#include "pipeline/scene/mesh.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <utility>
#include <vector>

namespace plumb {

// Edges of a face that no two of its triangles share, each as the face runs, in no particular order.
std::vector<std::pair<uint32_t, uint32_t>> boundaryOf(std::span<const TriangleMesh::Triangle> triangles);
// Boundary of a face as corners in order, from the first corner of its first boundary edge. Empty when the edges are not one closed line.
std::vector<uint32_t> outlineOf(std::span<const TriangleMesh::Triangle> triangles);

// Newell's normal of a polygon, and the sum of the magnitudes of its summands: 16 u of that bounds its rounding.
struct Newell {
    glm::dvec3 normal{0}, size{0};
    bool vanishes() const { return glm::all(glm::lessThanEqual(glm::abs(normal), 16 * 0x1p-53 * size)); }
    // True when the polygon faces the viewer: N.V - D > 0, computed as N.(eye - P0) without root and plane offset. Within its rounding the
    // polygon is edge-on, and not visible. `mirrored`: the object's matrix turns its polygons around.
    bool faces(const glm::dvec3& toEye, bool mirrored) const {
        return (mirrored ? -1 : 1) * glm::dot(normal, toEye) > 16 * 0x1p-53 * glm::dot(size, glm::abs(toEye));
    }
};
Newell newellOf(std::span<const glm::dvec3> world);

// One face of a mesh: its triangles stand together.
struct FaceTriangles {
    uint32_t face = 0, first = 0, count = 0;
};
std::vector<FaceTriangles> facesOf(const TriangleMesh& mesh);

// Choice of the edges that a wire frame draws.
struct WireChoices {
    // each edge once for each polygon that has it, in their order (section 2 of the notes); else each once by position
    bool perPolygon = false;
    bool facingOnly = false;  // only edges of polygons that face the viewer
};
struct WireEdge {
    glm::uvec2 vertex{0};
    uint32_t face = kNone;  // face of the edge, per polygon
};
std::vector<WireEdge> wireEdges(const TriangleMesh& mesh, const glm::dmat4& worldFromMesh, const glm::dvec3& eye, WireChoices choices);

}  // namespace plumb
