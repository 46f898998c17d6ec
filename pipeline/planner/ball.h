// SPDX-License-Identifier: MIT
// The scene that devices are calibrated by: a ball of triangles.
#pragma once

#include "pipeline/scene/load.h"

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

namespace plumb {

// Unit ball of 2 rings (2 rings - 2) triangles about the origin, smooth, of the first material.
inline TriangleMesh ballMesh(uint32_t rings, std::vector<Material>& materials) {
    constexpr double kPi = 3.14159265358979323846;
    PolygonMesh mesh;
    mesh.name = "ball";
    const uint32_t columns = 2 * rings;
    std::vector<glm::dvec3> points = {{0, 1, 0}};
    for (uint32_t ring = 1; ring < rings; ++ring)
        for (uint32_t column = 0; column < columns; ++column) {
            const double down = kPi * ring / rings, around = 2 * kPi * column / columns;
            points.emplace_back(std::sin(down) * std::sin(around), std::cos(down), std::sin(down) * std::cos(around));
        }
    points.emplace_back(0, -1, 0);
    for (const glm::dvec3& p : points) {
        mesh.positions.push_back(p);
        mesh.normals.emplace_back(p);
    }
    mesh.faceFirst.push_back(0);
    const auto face = [&](uint32_t a, uint32_t b, uint32_t c) {
        for (const uint32_t corner : {a, b, c}) mesh.corners.push_back({corner, corner});
        mesh.faceFirst.push_back(uint32_t(mesh.corners.size()));
        mesh.faceMaterial.push_back(kNone);
    };
    const auto at = [&](uint32_t ring, uint32_t column) { return 1 + (ring - 1) * columns + column % columns; };
    for (uint32_t column = 0; column < columns; ++column) {
        face(0, at(1, column), at(1, column + 1));
        for (uint32_t ring = 1; ring + 1 < rings; ++ring) {
            face(at(ring, column), at(ring + 1, column), at(ring + 1, column + 1));
            face(at(ring, column), at(ring + 1, column + 1), at(ring, column + 1));
        }
        face(at(rings - 1, column), uint32_t(points.size() - 1), at(rings - 1, column + 1));
    }
    return finishMesh(std::move(mesh), materials, 0, {});
}

}  // namespace plumb
