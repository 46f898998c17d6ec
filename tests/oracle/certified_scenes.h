// SPDX-License-Identifier: MIT
// Scenes that are hard for the truth's bounds: triangles at every distance and slope, numbers of 53 bits, lights beside surfaces, sharp highlights.
// Each is made of numbers that a source hands out: at random, or as a search has moved them.
#pragma once

#include "pipeline/scene/load.h"
#include "pipeline/scene/look_at.h"
#include "tests/support/ray_scenes.h"
#include "tests/support/scenes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

namespace plumb::test {

// Numbers in [0, 1) that a scene is made of, in the order in which it asks. More than there are come from `random`.
class Genes {
public:
    explicit Genes(Random& random) : random_(&random) {}
    void restart() { next_ = 0; }
    double operator()(double low, double high) { return low + (high - low) * one(); }
    uint32_t below(uint32_t n) { return std::min(n - 1, uint32_t(one() * n)); }
    glm::dvec3 direction() {
        for (int tries = 0; tries < 4; ++tries) {
            const glm::dvec3 v((*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1));
            const double length = glm::length(v);
            if (length > 0.1 && length < 1) return v / length;
        }
        return {0.6, 0, 0.8};
    }
    // Moves some of the numbers: a little, or anywhere.
    void mutate() {
        if (numbers_.empty()) return;
        const uint32_t count = 1 + random_->below(random_->below(3) == 0 ? uint32_t(numbers_.size() / 4) : 4);
        for (uint32_t i = 0; i < count; ++i) {
            double& x = numbers_[random_->below(uint32_t(numbers_.size()))];
            x = random_->below(4) == 0 ? (*random_)(0, 1)
                                       : std::clamp(x + std::pow(10.0, (*random_)(-15, -1)) * (*random_)(-1, 1), 0.0, 1 - 0x1p-53);
        }
    }

private:
    double one() {
        if (next_ == numbers_.size()) numbers_.push_back((*random_)(0, 1) + 0x1p-32 * (*random_)(0, 1));
        return numbers_[next_++];
    }
    Random* random_;
    std::vector<double> numbers_;
    size_t next_ = 0;
};

inline double decade(Genes& r, double low, double high) { return std::pow(10.0, r(low, high)); }

inline Material randomSurface(Genes& r) {
    static constexpr float kExponents[] = {0, 0.5f, 1, 2, 3.5f, 5, 30, 200, 1e4f, 1e6f};
    Material m;
    const auto colour = [&](double most) { return glm::vec3(glm::dvec3(r(0, most), r(0, most), r(0, most))); };
    m.ambient = colour(0.2);
    m.diffuse = colour(1);
    m.specular = r.below(3) == 0 ? glm::vec3(0) : colour(1);
    m.emission = r.below(4) == 0 ? colour(0.3) : glm::vec3(0);
    m.shininess = kExponents[r.below(10)];
    return m;
}

// A matrix that turns, stretches by up to `stretch` and mirrors at times.
inline glm::dmat4 randomMatrix(Genes& r, double stretch) {
    const glm::dvec3 a = r.direction(), b = glm::normalize(glm::cross(a, r.direction() + 2.0 * glm::dvec3(a.y, a.z, -a.x))),
                     c = glm::cross(a, b);
    glm::dmat4 m(glm::dvec4(a * r(1, stretch), 0), glm::dvec4(b * r(1, stretch), 0), glm::dvec4(c * r(1, stretch), 0),
                 glm::dvec4(0, 0, 0, 1));
    if (r.below(4) == 0) m[0] = -m[0];
    return m;
}

inline Light randomLamp(Genes& r, const glm::dvec3& around, double size) {
    Light light;
    light.directional = r.below(3) == 0;
    light.direction = r.direction() * decade(r, -2, 2);
    light.position = around + r.direction() * size * decade(r, -1, 1);
    light.attenuation = Attenuation(r.below(3));
    light.intensity = glm::vec3(glm::dvec3(r(0, 1), r(0, 1), r(0, 1)));
    return light;
}

// Triangles of any size and slope around the origin, some of them slivers, with three materials.
inline TriangleMesh randomMesh(Genes& r) {
    std::vector<Corners> triangles(3 + r.below(6));
    for (Corners& c : triangles) {
        const glm::dvec3 at = r.direction() * r(0, 1);
        const double edge = decade(r, -1, 0.7);
        for (glm::vec3& p : c) p = glm::vec3(at + r.direction() * edge);
        if (r.below(4) == 0) c[2] = c[0] + 0.5f * (c[1] - c[0]) + glm::vec3(1e-4 * r.direction());
    }
    TriangleMesh mesh = soupOf(triangles, 3);
    if (r.below(4) != 0)
        for (glm::vec3& n : mesh.normals) n = glm::vec3(r.direction());
    // The file's numbers have bits that float32 loses.
    for (const glm::vec3& p : mesh.positions) mesh.stated.push_back(glm::dvec3(p) * (1 + 0x1p-26 * r(-1, 1)));
    return mesh;
}

// A camera that looks at a thing of this size from near or far.
inline Camera randomCamera(Genes& r, const glm::dvec3& middle, double size, bool leftHanded) {
    const double away = size * decade(r, -0.3, 2);
    Camera camera = lookAt(middle + r.direction() * away, middle + r.direction() * 0.2 * size, {0, 1, 0}, 45, leftHanded);
    camera.fovYDegrees = std::min(120.0, 2 * 57.3 * std::atan(0.8 * size / away)) * r(0.1, 1);
    camera.near = away * 0x1p-10;
    return camera;
}

inline Scene randomTriangles(Genes& r) {
    Scene s;
    s.path = "random triangles";
    const double size = decade(r, -3, 3);
    const glm::dvec3 middle = r.direction() * size * (r.below(2) ? 0.0 : decade(r, 0, 4));
    for (int i = 0; i < 3; ++i) s.materials.push_back(randomSurface(r));
    for (uint32_t o = 0; o < 2; ++o) {
        glm::dmat4 matrix = randomMatrix(r, r.below(2) ? 1 : 3);
        for (int k = 0; k < 3; ++k) matrix[k] *= size;
        matrix[3] = glm::dvec4(middle, 1);
        addObject(s, randomMesh(r), matrix);
    }
    const uint32_t lamps = 1 + r.below(3);
    for (uint32_t i = 0; i < lamps; ++i) s.lights.push_back(randomLamp(r, middle, size));
    s.leftHanded = r.below(4) == 0;
    s.cullBackFaces = r.below(4) == 0;
    if (r.below(3) == 0) s.distantViewer = true;
    s.camera = randomCamera(r, middle, size, s.leftHanded);
    return s;
}

// Spheres, a board and some triangles that mirror one another, and some glass.
inline Scene randomTraced(Genes& r) {
    Scene s;
    s.path = "random traced scene";
    s.shading = Shading::ray;
    const double size = decade(r, -2, 2);
    const glm::dvec3 middle = r.direction() * size * (r.below(2) ? 0.0 : decade(r, 0, 3));
    for (int i = 0; i < 4; ++i) {
        Material m = randomSurface(r);
        m.reflect = r.below(2) ? float(r(0, 0.5)) : 0;
        m.transmit = i == 3 ? float(r(0, 0.9 - double(m.reflect))) : 0;
        m.refractiveIndex = i == 3 ? float(r(0.6, 2)) : 1;
        m.local = 1 - m.reflect - m.transmit;
        s.materials.push_back(m);
    }
    for (uint32_t i = 0; i < 4; ++i) s.spheres.push_back(ball(middle + r.direction() * size * r(0, 1.5), size * decade(r, -1, 0), i));
    PlaneShape board = floorAt(middle.y - size * r(0.5, 2), 0, 1, size * r(0.3, 2));
    board.point.x = middle.x, board.point.z = middle.z;
    board.mirrored = r.below(2) == 0;
    board.twoSided = r.below(2) == 0;
    s.planes.push_back(board);
    glm::dmat4 matrix = randomMatrix(r, r.below(2) ? 1 : 3);
    for (int k = 0; k < 3; ++k) matrix[k] *= 0.5 * size;
    matrix[3] = glm::dvec4(middle, 1);
    addObject(s, randomMesh(r), matrix);
    const uint32_t lamps = 1 + r.below(3);
    for (uint32_t i = 0; i < lamps; ++i) s.lights.push_back(randomLamp(r, middle, size));
    s.shadows = r.below(4) != 0;
    s.camera = randomCamera(r, middle, size, false);
    return s;
}

}  // namespace plumb::test
