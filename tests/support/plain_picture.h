// SPDX-License-Identifier: MIT
// A picture by the textbook, in binary64, that shares nothing with the passes: every triangle tested at every pixel of
// its box, Phong's formula, no clipping (what it draws lies in front of the eye). For questions such as "how bright" and
// "how large", where a pixel more or less does not matter.
#pragma once

#include "pipeline/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

namespace plumb::test {

struct PlainPicture {
    int width = 0, height = 0;
    std::vector<glm::dvec3> linear;  // row 0 on top
    std::vector<double> depth;       // 1/z; 0 where nothing is drawn
    bool drawn(int x, int y) const { return depth[size_t(y) * size_t(width) + size_t(x)] > 0; }
};

inline glm::dvec3 plainPhong(const Scene& scene, const Material& m, const glm::dvec3& n, const glm::dvec3& v) {
    glm::dvec3 sum = glm::dvec3(m.ambient) * glm::dvec3(scene.ambient) + glm::dvec3(m.emission);
    for (const Light& light : scene.lights) {
        const glm::dvec3 l = glm::normalize(light.direction);
        const double nl = glm::dot(n, l);
        if (nl <= 0) continue;
        const double rv = std::max(0.0, glm::dot(2 * nl * n - l, v));
        sum += glm::dvec3(light.intensity) * (glm::dvec3(m.diffuse) * nl + glm::dvec3(m.specular) * std::pow(rv, double(m.shininess)));
    }
    return sum;
}

// Directional lights, back faces culled.
inline PlainPicture plainPicture(const Scene& scene, int width, int height) {
    using glm::dvec3;
    PlainPicture out{width, height, std::vector<dvec3>(size_t(width) * size_t(height)),
                     std::vector<double>(size_t(width) * size_t(height))};
    const Camera& camera = *scene.camera;
    const double focal = height / 2.0 / std::tan(glm::radians(camera.fovYDegrees / 2));
    for (const Object& object : scene.objects) {
        const TriangleMesh& mesh = scene.meshes[object.mesh];
        const glm::dmat3 normalMatrix = glm::transpose(glm::inverse(glm::dmat3(object.worldFromObject)));
        for (const auto& triangle : mesh.triangles) {
            dvec3 world[3], normal[3], screen[3];
            for (int i = 0; i < 3; ++i) {
                world[i] = dvec3(object.worldFromObject * glm::dvec4(mesh.positions[triangle.vertex[i]], 1));
                normal[i] = normalMatrix * dvec3(mesh.normals[triangle.vertex[i]]);
                const dvec3 p = world[i] - camera.eye;
                const double z = glm::dot(p, camera.forward);
                screen[i] = {width / 2.0 + focal * glm::dot(p, camera.right) / z, height / 2.0 - focal * glm::dot(p, camera.up) / z, 1 / z};
            }
            const auto edge = [](const dvec3& a, const dvec3& b, double x, double y) {
                return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
            };
            const double area = edge(screen[0], screen[1], screen[2].x, screen[2].y);
            if (area >= 0) continue;  // y points down: counter-clockwise in the world is a negative area
            const auto [left, right] = std::minmax({screen[0].x, screen[1].x, screen[2].x});
            const auto [top, bottom] = std::minmax({screen[0].y, screen[1].y, screen[2].y});
            for (int y = std::max(0, int(top)); y < std::min(double(height), bottom + 1); ++y)
                for (int x = std::max(0, int(left)); x < std::min(double(width), right + 1); ++x) {
                    double w[3];
                    for (int i = 0; i < 3; ++i) w[i] = edge(screen[(i + 1) % 3], screen[(i + 2) % 3], x + 0.5, y + 0.5) / area;
                    if (w[0] < 0 || w[1] < 0 || w[2] < 0) continue;
                    const double nearness = w[0] * screen[0].z + w[1] * screen[1].z + w[2] * screen[2].z;
                    const size_t at = size_t(y) * size_t(width) + size_t(x);
                    if (nearness <= out.depth[at]) continue;
                    out.depth[at] = nearness;
                    dvec3 n(0), p(0);
                    for (int i = 0; i < 3; ++i) {
                        const double weight = w[i] * screen[i].z / nearness;
                        n += weight * normal[i];
                        p += weight * world[i];
                    }
                    out.linear[at] = plainPhong(scene, scene.materials[mesh.faceMaterial[triangle.face]], glm::normalize(n),
                                                glm::normalize(camera.eye - p));
                }
        }
    }
    return out;
}

// IEC 61966-2-1, to 8 bits.
inline int srgb8(double linear) {
    const double x = std::clamp(linear, 0.0, 1.0);
    const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    return int(std::lround(encoded * 255));
}

}  // namespace plumb::test
