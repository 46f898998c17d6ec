// SPDX-License-Identifier: MIT
// Small scenes that put every pass to the test, made from numbers: `plumb verify --suite` and the tests draw them. Every scene has the same
// camera: eye at the origin, looking along -z, focal length 256 pixels, so that the point pointAt(px, py, w) lands exactly on pixel
// coordinates (px, py) when they are multiples of a sub-pixel and w is a power of two.
#pragma once

#include "pipeline/scene/scene.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace plumb::suite {

inline constexpr double kFocal = 256;
inline constexpr double kNear = 0.25;
inline constexpr double kSubpixel = 1.0 / 256;

struct View {
    uint32_t width = 0, height = 0;
    glm::vec3 pointAt(double px, double py, double w) const {
        return {float((px - width / 2.0) * w / kFocal), float((height / 2.0 - py) * w / kFocal), float(-w)};
    }
};

using Corners = std::array<glm::vec3, 3>;

// Uniform in [low, high), the same on every standard library.
class Random {
public:
    explicit Random(uint32_t seed) : engine_(seed) {}
    double operator()(double low, double high) { return low + (high - low) * (engine_() / 4294967296.0); }
    uint32_t below(uint32_t n) { return engine_() % n; }
    glm::vec3 direction() {
        for (;;) {
            const glm::dvec3 v((*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1));
            const double length = glm::length(v);
            if (length > 0.1 && length < 1) return glm::vec3(v / length);
        }
    }

private:
    std::mt19937 engine_;
};

// A mesh in which each triangle owns its vertices and its face; materials in turn. Normals: the triangle's own, or random ones.
inline TriangleMesh soupOf(const std::vector<Corners>& triangles, uint32_t materials, Random* normals = nullptr) {
    TriangleMesh mesh;
    glm::vec3 low(INFINITY), high(-INFINITY);
    for (size_t t = 0; t < triangles.size(); ++t) {
        const Corners& c = triangles[t];
        const glm::dvec3 n = glm::cross(glm::dvec3(c[1]) - glm::dvec3(c[0]), glm::dvec3(c[2]) - glm::dvec3(c[0]));
        const glm::vec3 face = glm::dot(n, n) > 0 ? glm::vec3(glm::normalize(n)) : glm::vec3(0, 0, 1);
        const uint32_t first = uint32_t(mesh.positions.size()), material = uint32_t(t) % materials;
        for (const glm::vec3& p : c) {
            mesh.positions.push_back(p);
            mesh.normals.push_back(normals ? normals->direction() : face);
            mesh.vertexMaterial.push_back(material);
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
        mesh.triangles.push_back({{first, first + 1, first + 2}, uint32_t(t)});
        mesh.faceCentre.push_back((c[0] + c[1] + c[2]) / 3.0f);
        mesh.faceNormal.push_back(face);
        mesh.faceMaterial.push_back(material);
        for (uint32_t i = 0; i < 3; ++i) mesh.edges.push_back({first + i, first + (i + 1) % 3});
    }
    mesh.boundsMin = low;
    mesh.boundsMax = high;
    return mesh;
}

// Three materials (one matt, one shining, one that only shines) and four lights of all kinds.
inline Scene litScene() {
    Scene s;
    s.path = "in memory";
    s.camera = Camera{};
    s.camera->focalPixels = kFocal;
    s.camera->near = kNear;
    s.cullBackFaces = false;
    s.ambient = glm::vec3(0.2f);
    s.materials.resize(3);
    s.materials[0].diffuse = {0.8f, 0.3f, 0.1f};
    s.materials[1].diffuse = {0.1f, 0.5f, 0.7f};
    s.materials[1].specular = {0.6f, 0.5f, 0.4f};
    s.materials[1].shininess = 50;
    s.materials[2].diffuse = glm::vec3(0.0f);
    s.materials[2].specular = {0.9f, 0.9f, 0.2f};
    s.materials[2].shininess = 3.5f;
    s.materials[2].emission = {0.05f, 0.0f, 0.1f};
    Light sun;
    sun.direction = {1, 2, 3};
    sun.intensity = {0.9f, 0.8f, 0.7f};
    s.lights.push_back(sun);
    for (Attenuation a : {Attenuation::none, Attenuation::inverse, Attenuation::inverseSquare}) {
        Light lamp;
        lamp.directional = false;
        lamp.position = {-2.0 + double(a), 1.5, 0.5};
        lamp.intensity = glm::vec3(0.3f + 2.0f * float(a));
        lamp.attenuation = a;
        s.lights.push_back(lamp);
    }
    return s;
}

inline void addObject(Scene& s, TriangleMesh mesh, const glm::dmat4& worldFromObject = glm::dmat4(1)) {
    Object o;
    o.name = "object " + std::to_string(s.objects.size());
    o.mesh = uint32_t(s.meshes.size());
    o.worldFromObject = worldFromObject;
    s.meshes.push_back(std::move(mesh));
    s.objects.push_back(o);
}

inline Scene sceneOf(const std::vector<Corners>& triangles) {
    Scene s = litScene();
    Random random(7);
    addObject(s, soupOf(triangles, uint32_t(s.materials.size()), &random));
    return s;
}

// `count` triangles of about `size` pixels anywhere in and around the frame, at depths 1 to 9.
inline Scene soup(View v, uint32_t seed, uint32_t count, double size) {
    Random r(seed);
    std::vector<Corners> t(count);
    for (Corners& c : t) {
        const double x = r(-0.1, 1.1) * v.width, y = r(-0.1, 1.1) * v.height;
        for (glm::vec3& p : c) p = v.pointAt(x + r(-size, size), y + r(-size, size), r(1, 9));
    }
    return sceneOf(t);
}

// Fans around shared vertices whose edges run exactly through pixel centres, or -3 to 3 sub-pixels beside them; depths differ by
// fan, so that no triangle hides another of its own fan. Neighbours share edges: no pixel may be lost or drawn twice.
inline Scene throughCentres(View v) {
    std::vector<Corners> t;
    const double step = 16;
    for (double y = 0.5; y < v.height; y += step)
        for (double x = 0.5; x < v.width; x += step) {
            const int beside = int(t.size() / 6) % 7 - 3;
            const double px = x + beside * kSubpixel, py = y + (int(t.size() / 6) % 5 - 2) * kSubpixel;
            const std::array<std::array<double, 2>, 6> ring{{{8, 0}, {4, 8}, {-4, 8}, {-8, 0}, {-4, -8}, {4, -8}}};
            for (size_t k = 0; k < 6; ++k) {
                const auto &a = ring[k], &b = ring[(k + 1) % 6];
                t.push_back({v.pointAt(px, py, 2), v.pointAt(px + b[0], py + b[1], 2), v.pointAt(px + a[0], py + a[1], 2)});
            }
        }
    return sceneOf(t);
}

// Triangles of equal depth everywhere: the same ones listed twice, corners rotated, and coplanar ones that overlap.
inline Scene equalDepths(View v) {
    Random r(11);
    std::vector<Corners> t;
    for (int i = 0; i < 40; ++i) {
        Corners c;
        for (glm::vec3& p : c) p = v.pointAt(std::floor(r(0, v.width)) + 0.5, std::floor(r(0, v.height)) + 0.5, 4);
        t.push_back(c);
        t.push_back({c[1], c[2], c[0]});
        t.push_back(c);
    }
    return sceneOf(t);
}

// No area at all, needles of one sub-pixel, triangles between pixel centres; one plain triangle so that something is drawn.
inline Scene degenerate(View v) {
    Random r(13);
    std::vector<Corners> t;
    for (int i = 0; i < 200; ++i) {
        const double x = std::floor(r(0, v.width)) + 0.5, y = std::floor(r(0, v.height)) + 0.5;
        const glm::vec3 a = v.pointAt(x, y, 2);
        const double far = r(1, v.width), up = r(-20, 20);
        t.push_back({a, a, a});
        t.push_back({a, v.pointAt(x + 8, y + 4, 2), v.pointAt(x + 16, y + 8, 2)});
        t.push_back({a, v.pointAt(x + far, y + up, 2), v.pointAt(x + far, y + up + kSubpixel, 2)});
        t.push_back({v.pointAt(x - kSubpixel, y, 1), v.pointAt(x + kSubpixel, y, 1), v.pointAt(x, y + kSubpixel, 1)});
        t.push_back({v.pointAt(x + 0.1, y + 0.1, 1), v.pointAt(x + 0.8, y + 0.1, 1), v.pointAt(x + 0.1, y + 0.8, 1)});
    }
    t.push_back({v.pointAt(0, 0, 8), v.pointAt(0, v.height, 8), v.pointAt(v.width, v.height, 8)});
    return sceneOf(t);
}

// Triangles whose boxes reach far into the guard band, so that edge values need 64 bits.
inline Scene huge(View v) {
    Random r(17);
    std::vector<Corners> t;
    for (int i = 0; i < 24; ++i) {
        const double angle = r(0, 6.28), reach = r(2000, 8100);
        Corners c;
        for (int k = 0; k < 3; ++k)
            c[size_t(k)] = v.pointAt(v.width / 2.0 + reach * std::cos(angle + k * 2.09),
                                     v.height / 2.0 + reach * std::sin(angle + k * 2.09), r(1, 12));
        t.push_back(c);
    }
    const std::vector<Corners> small = {{v.pointAt(1, 1, 0.5), v.pointAt(1, 9, 0.5), v.pointAt(9, 9, 0.5)}};
    t.insert(t.end(), small.begin(), small.end());
    return sceneOf(t);
}

// For every clip plane all 27 patterns of three vertices outside, on and inside it; the inside ones are in the view.
inline Scene signPatterns(View v) {
    std::vector<Corners> t;
    Random r(19);
    const double guardX = v.width / 2.0 + 8192, guardY = v.height / 2.0 + 8192;
    for (int plane = 0; plane < 5; ++plane)
        for (int pattern = 0; pattern < 27; ++pattern)
            for (int copy = 0; copy < 2; ++copy) {
                Corners c;
                for (int k = 0, left = pattern; k < 3; ++k, left /= 3) {
                    const int state = left % 3 - 1;  // -1 outside, 0 on the plane, 1 inside
                    const double x = r(0, v.width), y = r(0, v.height);
                    glm::vec3& p = c[size_t(k)];
                    if (plane == 0) {
                        const double w = state > 0 ? r(1, 4) : state == 0 ? kNear : r(-3, 0.2);
                        p = v.pointAt(x, y, state == 0 ? kNear : 1);
                        if (state != 0) p *= float(w);
                        if (state < 0 && copy) p = {float(r(-1, 1)), float(r(-1, 1)), 0};  // w = 0: in the eye's plane
                    } else {
                        const double beyond = state > 0 ? 0 : state == 0 ? 1 : r(1.001, 4);
                        const double px = plane == 1 ? v.width / 2.0 - guardX * beyond : plane == 2 ? v.width / 2.0 + guardX * beyond : x;
                        const double py = plane == 3 ? v.height / 2.0 - guardY * beyond : plane == 4 ? v.height / 2.0 + guardY * beyond : y;
                        p = state > 0 ? v.pointAt(x, y, 2) : v.pointAt(px, py, 2);
                    }
                }
                t.push_back(c);
            }
    // Seen corner, the opposite edge far beyond two corners of the guard band: cut at three planes, every piece is seen.
    for (int turn = 0; turn < 8; ++turn) {
        const double angle = 0.785398 * turn, far = 40000;
        t.push_back({v.pointAt(r(0, v.width), r(0, v.height), 2),
                     v.pointAt(far * std::cos(angle + 1.6), far * std::sin(angle + 1.6), turn % 2 ? 3 : 2),
                     v.pointAt(far * std::cos(angle), far * std::sin(angle), 2)});
    }
    return sceneOf(t);
}

// The eye among large triangles on all sides: every plane cuts some of them, some at three planes at once.
inline Scene inside(View v) {
    Random r(23);
    std::vector<Corners> t(60);
    for (Corners& c : t) {
        const glm::vec3 centre = r.direction() * float(r(0.5, 6));
        for (glm::vec3& p : c) p = centre + r.direction() * float(r(0.5, 20));
    }
    t.push_back({v.pointAt(0, 0, 64), v.pointAt(0, v.height, 64), v.pointAt(v.width, v.height, 64)});
    return sceneOf(t);
}

// A bumpy sheet with shared vertices: 2 n n triangles, smooth normals, one material.
inline Scene sheet(View v, uint32_t n) {
    Scene s = litScene();
    TriangleMesh mesh;
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i <= n; ++i) {
            const double w = 4 + 0.7 * std::sin(9.0 * i / n) * std::cos(7.0 * j / n);
            mesh.positions.push_back(v.pointAt((0.05 + 0.9 * i / n) * v.width, (0.05 + 0.9 * j / n) * v.height, w));
            mesh.normals.push_back(glm::vec3(glm::normalize(glm::dvec3(std::cos(9.0 * i / n), std::sin(7.0 * j / n), 2))));
            mesh.vertexMaterial.push_back(1);
        }
    for (uint32_t j = 0; j < n; ++j)
        for (uint32_t i = 0; i < n; ++i) {
            const uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1, face = j * n + i;
            mesh.triangles.push_back({{a, c, d}, face});
            mesh.triangles.push_back({{a, d, b}, face});
            mesh.faceCentre.push_back((mesh.positions[a] + mesh.positions[d]) * 0.5f);
            mesh.faceNormal.push_back(mesh.normals[a]);
            mesh.faceMaterial.push_back(1);
            mesh.edges.push_back({a, b});
            mesh.edges.push_back({a, c});
        }
    mesh.boundsMin = mesh.boundsMax = mesh.positions[0];
    for (const glm::vec3& p : mesh.positions) {
        mesh.boundsMin = glm::min(mesh.boundsMin, p);
        mesh.boundsMax = glm::max(mesh.boundsMax, p);
    }
    addObject(s, std::move(mesh));
    s.cullBackFaces = true;
    return s;
}

inline Scene soupSmall(View v) { return soup(v, 1, 300, 12); }
inline Scene soupLarge(View v) { return soup(v, 2, 60, 150); }
inline Scene soupOne(View v) { return soup({v.width, v.height}, 3, 19, double(v.width + v.height)); }
inline Scene sheetOf24(View v) { return sheet(v, 24); }

}  // namespace plumb::suite
