// SPDX-License-Identifier: MIT
#include "pipeline/render/dark_lights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb {

namespace {

using glm::dvec2;
using glm::dvec3;

// Least cosine by which a normal must point away. A sum of such normals has at least that share of their lengths, so its direction is off by at most
// 10 sqrt(3) u / 2^-8, and N.L by less than 2^-11 (docs/derivations.md, Normals and attributes).
constexpr double kAway = 0x1p-8;
// Pixels by which a triangle's corners may be off: 1/512 by the snap, and half a pixel where nothing warns.
constexpr double kCornerPixels = 1;

dvec3 times(const glm::vec4& row0, const glm::vec4& row1, const glm::vec4& row2, const dvec3& v, double one) {
    const auto along = [&](const glm::vec4& r) { return r.x * v.x + r.y * v.y + r.z * v.z + r.w * one; };
    return {along(row0), along(row1), along(row2)};
}

// True when the triangle is culled as a back face however its corners are snapped.
bool surelyBack(const gpu::ObjectRecord& o, const std::array<dvec3, 3>& corners, const DrawList& list) {
    if (!list.cullBackFaces) return false;
    dvec2 at[3];
    for (size_t i = 0; i < 3; ++i) {
        const dvec3 clip = times(o.rowX, o.rowY, o.rowW, corners[i], 1);
        if (!(clip.z > list.viewport.near * 1.001)) return false;
        at[i] = dvec2(clip) / clip.z;
    }
    const dvec2 a = at[1] - at[0], b = at[2] - at[0];
    const double twice = b.x * a.y - a.x * b.y;  // positive where it faces the viewer, y down
    const double around = glm::length(a) + glm::length(b) + glm::length(at[2] - at[1]);
    return twice < -4 * kCornerPixels * (around + kCornerPixels);
}

// True when the normal points away from the light at each of the points.
bool pointsAway(const gpu::LightRecord& light, const dvec3& normal, const std::array<dvec3, 3>& points) {
    const double length = glm::length(normal);
    if (light.kind == 0) return glm::dot(normal, dvec3(light.position)) < -kAway * length;
    for (const dvec3& p : points) {
        const dvec3 toward = dvec3(light.position) - p;
        // A position is off by 20 u of its distance from the eye.
        const double distance = glm::length(toward);
        if (!(distance > 0x1p-8 * glm::length(p)) || !(glm::dot(normal, toward) < -kAway * length * distance)) return false;
    }
    return true;
}

bool reflects(const glm::vec3& share, const glm::vec3& intensity) {
    for (int i = 0; i < 3; ++i)
        if (share[i] != 0 && intensity[i] != 0) return true;
    return false;
}

}  // namespace

bool isUnreflected(const gpu::LightRecord& light, const DrawList& list) {
    return std::none_of(list.materials.begin(), list.materials.end(), [&](const gpu::MaterialRecord& m) {
        return reflects(m.diffuse, light.intensity) || reflects(m.specular, light.intensity);
    });
}

bool isTurnedAway(const gpu::LightRecord& light, const DrawList& list, uint32_t shading) {
    if (list.triangles.size() > kMostLookedAt) return false;
    for (const DrawList::Range& r : list.ranges) {
        if (r.precision != Precision::fp32) return false;  // its rows in float32 do not say where it is
        const gpu::ObjectRecord& o = list.objects[r.record];
        for (uint32_t t = r.firstTriangle; t < r.firstTriangle + r.triangleCount; ++t) {
            std::array<dvec3, 3> corners, points;
            for (int i = 0; i < 3; ++i) {
                corners[size_t(i)] = dvec3(list.positions[list.triangles[t][i]]);
                points[size_t(i)] = times(o.world0, o.world1, o.world2, corners[size_t(i)], 1);
            }
            if (surelyBack(o, corners, list)) continue;
            for (int i = 0; i < (shading == gpu::kShadingFlat ? 1 : 3); ++i) {
                const glm::vec4& n =
                    shading == gpu::kShadingFlat ? list.faceNormals[list.triangleFace[t]] : list.normals[list.triangles[t][i]];
                if (!pointsAway(light, times(o.normal0, o.normal1, o.normal2, dvec3(n), 0), points)) return false;
            }
        }
    }
    return true;
}

}  // namespace plumb
