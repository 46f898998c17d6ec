// SPDX-License-Identifier: MIT
#include "pipeline/bench/meshes.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <numbers>
#include <utility>

namespace plumb {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFovY = 0.9;  // radians
constexpr uint32_t kLayers = 20;
constexpr uint32_t kMostLights = 64;

struct Maker {
    TriangleMesh mesh;

    void vertex(const glm::dvec3& position, const glm::dvec3& normal) {
        mesh.positions.emplace_back(position);
        mesh.normals.emplace_back(glm::normalize(normal));
        mesh.vertexMaterial.push_back(0);
    }
    void triangle(uint32_t a, uint32_t b, uint32_t c) {
        mesh.triangles.push_back({{a, b, c}, uint32_t(mesh.triangles.size())});
        const glm::vec3 &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
        const glm::vec3 area = glm::cross(q - p, r - p);
        const float length = glm::length(area);
        mesh.faceCentre.push_back((p + q + r) / 3.0f);
        mesh.faceNormal.push_back(length > 0 ? area / length : glm::vec3(0, 0, 1));
        mesh.faceMaterial.push_back(0);
    }
    // Adds quads between rows of `columns` + 1 vertices.
    void grid(uint32_t rows, uint32_t columns) {
        for (uint32_t j = 0; j < rows; ++j)
            for (uint32_t i = 0; i < columns; ++i) {
                const uint32_t a = j * (columns + 1) + i, b = a + 1, c = a + columns + 1, d = c + 1;
                triangle(a, b, c);
                triangle(b, d, c);
            }
    }
    TriangleMesh finished() {
        mesh.boundsMin = mesh.boundsMax = mesh.positions.front();
        for (const glm::vec3& p : mesh.positions) {
            mesh.boundsMin = glm::min(mesh.boundsMin, p);
            mesh.boundsMax = glm::max(mesh.boundsMax, p);
        }
        return std::move(mesh);
    }
};

// Sphere of 4 rows^2 triangles. `bumps`: amplitude by which the radius varies.
TriangleMesh sphere(uint32_t rows, double bumps) {
    Maker maker;
    const uint32_t columns = 2 * rows;
    for (uint32_t j = 0; j <= rows; ++j)
        for (uint32_t i = 0; i <= columns; ++i) {
            const double u = i * 2 * kPi / columns, v = j * kPi / rows;
            const glm::dvec3 outward(std::sin(v) * std::cos(u), std::cos(v), std::sin(v) * std::sin(u));
            maker.vertex(outward * (1 + bumps * std::sin(9 * u) * std::sin(7 * v)), outward);
        }
    maker.grid(rows, columns);
    return maker.finished();
}

glm::dvec3 knotCentre(double t) {
    const double r = 0.55 + 0.22 * std::cos(3 * t);
    return {r * std::cos(2 * t), r * std::sin(2 * t), 0.3 * std::sin(3 * t)};
}

// Tube about a trefoil knot: 16 around^2 triangles.
TriangleMesh knot(uint32_t around) {
    Maker maker;
    const uint32_t along = 8 * around;
    for (uint32_t i = 0; i <= along; ++i) {
        const double t = i * 2 * kPi / along;
        const glm::dvec3 centre = knotCentre(t);
        const glm::dvec3 tangent = glm::normalize(knotCentre(t + 1e-3) - centre);
        const glm::dvec3 across = glm::normalize(glm::dvec3(-tangent.y, tangent.x, 0));
        const glm::dvec3 third = glm::cross(tangent, across);
        for (uint32_t j = 0; j <= around; ++j) {
            const double a = j * 2 * kPi / around;
            const glm::dvec3 outward = across * std::cos(a) + third * std::sin(a);
            maker.vertex(centre + outward * 0.13, outward);
        }
    }
    maker.grid(along, around);
    return maker.finished();
}

// Quads that fill the view of a camera at z = 3, each in front of or behind the one before.
TriangleMesh layers(uint32_t count, bool backToFront, double aspect) {
    Maker maker;
    const double reach = std::tan(kFovY / 2) * 0.999;
    for (uint32_t l = 0; l < count; ++l) {
        const double z = backToFront ? -1.0 + double(l) / count : -double(l) / count;
        const double y = reach * (3.0 - z), x = y * aspect;
        const uint32_t first = 4 * l;
        for (const glm::dvec2 corner : {glm::dvec2(-1, -1), glm::dvec2(1, -1), glm::dvec2(1, 1), glm::dvec2(-1, 1)})
            maker.vertex({corner.x * x, corner.y * y, z}, {corner.x * 0.6, corner.y * 0.6, 1});
        maker.triangle(first, first + 1, first + 2);
        maker.triangle(first, first + 2, first + 3);
    }
    return maker.finished();
}

Scene sceneOf(TriangleMesh mesh, double distance, const std::string& name) {
    Scene scene;
    scene.path = name;
    Material material;
    material.ambient = glm::vec3(0.1f);
    material.diffuse = {0.7f, 0.5f, 0.3f};
    material.specular = glm::vec3(0.5f);
    material.shininess = 32;
    scene.materials = {material};
    scene.meshes.push_back(std::move(mesh));
    Object object;
    object.name = name;
    scene.objects = {object};
    Light light;
    light.direction = {0.4, 0.6, 0.69282};
    scene.lights = {light};
    Camera camera;
    camera.eye = {0, 0, distance};
    camera.fovYDegrees = kFovY * 180 / kPi;
    camera.focusDistance = distance;
    scene.camera = camera;
    return scene;
}

// Sphere of 10^5 triangles under `count` lights from all around, directional and point lights in turn, together no brighter than one light.
Scene lit(uint32_t count, const std::string& name) {
    Scene scene = sceneOf(sphere(uint32_t(std::lround(std::sqrt(1e5) / 2)), 0), 2.6, name);
    scene.lights.clear();
    for (uint32_t i = 0; i < count; ++i) {
        const double a = i * 2 * kPi / count;
        Light light;
        light.directional = i % 2 == 0;
        light.direction = light.position = glm::dvec3(3 * std::cos(a), 3 * std::sin(a), 2);
        light.intensity = glm::vec3(float(1.0 / count));
        scene.lights.push_back(light);
    }
    return scene;
}

// Number behind `prefix` in a name, such as 1e5; 0 when there is none.
double numberBehind(const std::string& name, const std::string& prefix) {
    if (!name.starts_with(prefix)) return 0;
    double number = 0;
    const char* end = name.data() + name.size();
    return std::from_chars(name.data() + prefix.size(), end, number).ptr == end ? number : 0;
}
double sizeBehind(const std::string& name, const std::string& prefix) {
    const double size = numberBehind(name, prefix);
    return size >= 1e3 && size <= 1e7 ? size : 0;
}

}  // namespace

std::vector<std::string> benchSceneNames() {
    return {"sphere1e3",    "sphere1e4", "sphere1e5",   "knot1e5",    "sphere1e6",
            "displaced1e6", "knot1e6",   "full-screen", "layers-b2f", "layers-f2b"};
}

std::optional<Scene> benchScene(const std::string& name, double aspect) {
    if (const double size = sizeBehind(name, "sphere"); size > 0)
        return sceneOf(sphere(uint32_t(std::lround(std::sqrt(size) / 2)), 0), 2.6, name);
    if (const double size = sizeBehind(name, "displaced"); size > 0)
        return sceneOf(sphere(uint32_t(std::lround(std::sqrt(size) / 2)), 0.15), 2.6, name);
    if (const double size = sizeBehind(name, "knot"); size > 0) return sceneOf(knot(uint32_t(std::lround(std::sqrt(size) / 4))), 2.2, name);
    if (const double count = numberBehind(name, "lights"); count >= 1 && count <= kMostLights && count == std::floor(count))
        return lit(uint32_t(count), name);
    if (name == "full-screen") return sceneOf(layers(1, true, aspect), 3, name);
    if (name == "layers-b2f") return sceneOf(layers(kLayers, true, aspect), 3, name);
    if (name == "layers-f2b") return sceneOf(layers(kLayers, false, aspect), 3, name);
    return std::nullopt;
}

}  // namespace plumb
