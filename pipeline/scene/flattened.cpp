// SPDX-License-Identifier: MIT
#include "pipeline/scene/flattened.h"

#include <algorithm>

namespace plumb {

using glm::dmat3;
using glm::dvec3;

namespace {

// Rounding of an entry of a product of a few matrices, and of values made of two or three such entries, in shares of the magnitudes.
constexpr double kRounding = 64 * 0x1p-53;

}  // namespace

bool mirrors(const glm::dmat4& worldFromObject) {
    const dmat3 m(worldFromObject), rows = glm::transpose(m);
    // Hadamard's bound of the determinant, by rows and by columns: for a scale before a rotation and for one after it.
    const double most = std::min(glm::length(m[0]) * glm::length(m[1]) * glm::length(m[2]),
                                 glm::length(rows[0]) * glm::length(rows[1]) * glm::length(rows[2]));
    return glm::determinant(m) < -kRounding * most;
}

bool leavesNoArea(const TriangleMesh& mesh, const glm::dmat4& worldFromObject) {
    const dmat3 m(worldFromObject);
    // Cofactors: twice a triangle's area, as a vector, is their matrix times the same vector in object space.
    const dvec3 cofactors[3] = {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
    const dvec3 length(glm::length(m[0]), glm::length(m[1]), glm::length(m[2]));
    return std::none_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const TriangleMesh::Triangle& t) {
        const dvec3 a(mesh.positions[t.vertex[0]]), b(mesh.positions[t.vertex[1]]), c(mesh.positions[t.vertex[2]]);
        const dvec3 area = glm::cross(b - a, c - a), size = glm::abs(area);
        const dvec3 world = cofactors[0] * area.x + cofactors[1] * area.y + cofactors[2] * area.z;
        const double most = length.y * length.z * size.x + length.z * length.x * size.y + length.x * length.y * size.z;
        return glm::any(glm::greaterThan(glm::abs(world), dvec3(kRounding * most)));
    });
}

}  // namespace plumb
