// SPDX-License-Identifier: MIT
// Scenes of spheres and planes for tests of rays.
#pragma once

#include "tests/support/scenes.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>

namespace plumb::test {

inline Scene rayScene() {
    Scene s;
    s.path = "test";
    s.shading = Shading::ray;
    s.materials.push_back({});
    s.materials[0].local = 1;
    Camera camera;
    camera.eye = {0, 1, 6};
    camera.focusDistance = 6;
    s.camera = camera;
    s.background = glm::vec3(0.3f, 0.4f, 0.9f);
    s.ambient = glm::vec3(0.3f);
    Light point;
    point.directional = false;
    point.position = {-3, 6, 4};
    point.intensity = glm::vec3(0.7f, 0.6f, 0.5f);
    Light sun;
    sun.direction = {0.4, 1, 0.3};
    sun.intensity = glm::vec3(0.3f);
    s.lights = {point, sun};
    return s;
}

inline uint32_t addRayMaterial(Scene& s, glm::vec3 colour, float reflect, float transmit, float index, float shininess = 40) {
    Material m;
    m.ambient = m.diffuse = colour;
    m.specular = glm::vec3(0.5f);
    m.shininess = shininess;
    m.reflect = reflect;
    m.transmit = transmit;
    m.local = 1 - reflect - transmit;
    m.refractiveIndex = index;
    s.materials.push_back(m);
    return uint32_t(s.materials.size() - 1);
}

inline SphereShape ball(glm::dvec3 centre, double radius, uint32_t material) { return {"", centre, radius, material}; }

inline PlaneShape floorAt(double y, uint32_t material, uint32_t other, double square) {
    PlaneShape p;
    p.point = {0, y, 0};
    p.material = material;
    p.square = square;
    p.otherMaterial = other;
    return p;
}

// Mirrors only: every hit has one child at most.
inline Scene mirrors() {
    Scene s = rayScene();
    const uint32_t red = addRayMaterial(s, {0.8f, 0.1f, 0.1f}, 0.3f, 0, 1), white = addRayMaterial(s, glm::vec3(0.8f), 0, 0, 1, 0);
    const uint32_t metal = addRayMaterial(s, {0.2f, 0.3f, 0.6f}, 0.7f, 0, 1, 200);
    s.planes.push_back(floorAt(-1, red, white, 0.5));
    s.planes.back().uMin = -4, s.planes.back().uMax = 3, s.planes.back().vMin = -9, s.planes.back().vMax = 5;
    PlaneShape wall;
    wall.point = {0, 0, -8};
    wall.normal = {0.1, 0.05, 1};
    wall.normal = glm::normalize(wall.normal);
    wall.u = glm::normalize(glm::dvec3(1, 0, 0) - wall.normal * wall.normal.x);
    wall.v = glm::cross(wall.u, wall.normal);
    wall.twoSided = false;
    wall.material = metal;
    wall.square = 1.3;
    wall.otherMaterial = white;
    wall.mirrored = true;
    s.planes.push_back(wall);
    s.spheres = {ball({-1.2, 0, 0}, 1, metal),       ball({1.1, -0.3, 1}, 0.7, red),   ball({0.2, 1.5, -2}, 1.2, metal),
                 ball({0.4, -0.8, 2.2}, 0.2, white), ball({2.6, 0.4, -1}, 0.9, metal), ball({-3, 2, -3}, 0.8, red)};
    return s;
}

// Glass among mirrors: trees, total reflection, translucent blockers, a sphere in a sphere, one sphere meeting another.
inline Scene glass() {
    Scene s = mirrors();
    const uint32_t clear = addRayMaterial(s, glm::vec3(0.05f), 0.15f, 0.8f, 1.5f),
                   air = addRayMaterial(s, glm::vec3(0.02f), 0.2f, 0.75f, 0.6f);
    const uint32_t tinted = addRayMaterial(s, {0.1f, 0.5f, 0.2f}, 0, 0.5f, 1.0f);
    s.spheres.push_back(ball({-0.3, 0.3, 2.8}, 0.8, clear));
    s.spheres.push_back(ball({-0.3, 0.3, 2.8}, 0.5, air));
    s.spheres.push_back(ball({0.9, 0.9, 2.0}, 0.7, air));
    s.spheres.push_back(ball({0.0, 2.4, 1.4}, 0.6, tinted));
    s.maxDepth = 7;
    return s;
}

// The eye within glass, and a window pane: a plane that refracts.
inline Scene inGlass() {
    Scene s = glass();
    s.spheres.push_back(ball(s.camera->eye + glm::dvec3(0.3, 0.2, 0.1), 1.1, 4));
    PlaneShape pane;
    pane.point = {0, 0, -3.5};
    pane.normal = {0, 0, 1};
    pane.v = {0, -1, 0};
    pane.material = 4;
    pane.uMin = -2, pane.uMax = 2, pane.vMin = -3, pane.vMax = 3;
    s.planes.push_back(pane);
    s.maxDepth = 6;
    return s;
}

// Spheres a million radii away beside near ones, seen through a narrow lens.
inline Scene farAway() {
    Scene s = mirrors();
    Random r(91);
    for (int i = 0; i < 12; ++i) s.spheres.push_back(ball({r(-4, 4), r(0, 8), -1e4 * (i + 1)}, r(0.2, 1.5), 3));
    s.spheres.push_back(ball({0, -6.371e6, 0}, 6.37e6, 1));
    s.camera->fovYDegrees = 2;
    s.camera->near = 0.01;
    return s;
}

// The eye `gap` above the top of a sphere (below it, inside, where gap < 0), with a ball, a board and a lamp of the gap's own size around it.
inline Scene closeTo(double radius, double gap) {
    Scene s = rayScene();
    const double size = std::abs(gap), up = gap < 0 ? -size : size;
    const uint32_t ground = addRayMaterial(s, {0.8f, 0.5f, 0.2f}, 0, 0, 1), metal = addRayMaterial(s, {0.2f, 0.3f, 0.6f}, 0.5f, 0, 1, 60);
    const uint32_t white = addRayMaterial(s, glm::vec3(0.8f), 0, 0, 1, 0);
    s.camera->eye = {0, gap, 0};
    s.camera->focusDistance = 3 * size;
    s.camera->near = size / 64;
    s.spheres = {ball({0, -radius, 0}, radius, ground), ball({-size, 0.7 * up, -4 * size}, 0.6 * size, metal)};
    PlaneShape board;
    board.point = {1.5 * size, 0, -6 * size};
    board.normal = glm::normalize(glm::dvec3(-0.4, 0, 1));
    board.u = glm::normalize(glm::dvec3(1, 0, 0.4));
    board.v = {0, 1, 0};
    board.material = metal;
    board.square = 0.37 * size;
    board.otherMaterial = white;
    board.uMin = -1.5 * size, board.uMax = 1.5 * size, board.vMin = -size, board.vMax = 3 * size;
    s.planes = {board};
    s.lights[0].position = {3 * size, 4 * up, -size};
    s.lights[1].direction = {-0.4, gap < 0 ? -0.8 : 0.8, 0.4};
    s.maxDepth = 3;
    return s;
}
inline Scene closeOutside() { return closeTo(1e9, 2); }
inline Scene closeInside() { return closeTo(6.371e6, -1.5); }

// Closed meshes among mirrors: one of them a mirror, one of glass, one turned inside out by its matrix, one twice.
inline Scene meshesAmongMirrors() {
    Scene s = mirrors();
    const uint32_t clear = addRayMaterial(s, glm::vec3(0.05f), 0.15f, 0.8f, 1.4f);
    const std::filesystem::path folder = std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes/procedural";
    const auto place = [&](uint32_t mesh, glm::dvec3 at, double size, bool flip) {
        Object o;
        o.mesh = mesh;
        o.worldFromObject = glm::dmat4(size);
        o.worldFromObject[0] *= flip ? -0.5 : 1.0;
        o.worldFromObject[1] = glm::dvec4(0, 0.8 * size, 0.6 * size, 0);
        o.worldFromObject[2] = glm::dvec4(0, -0.6 * size, 0.8 * size, 0);
        o.worldFromObject[3] = glm::dvec4(at, 1);
        s.objects.push_back(o);
    };
    const auto paint = [&](uint32_t mesh, uint32_t material) {
        for (uint32_t& m : s.meshes[mesh].faceMaterial) m = material;
    };
    const uint32_t ball = addMeshFile(s, folder / "icosphere.ply", {}), glassBall = addMeshFile(s, folder / "icosphere.ply", {});
    const uint32_t ring = addMeshFile(s, folder / "torus.obj", {});
    paint(ball, 3);
    paint(glassBall, clear);
    place(ball, {1.6, 1.6, 1}, 0.6, false);
    place(glassBall, {-0.4, 0.2, 3}, 0.7, false);
    place(ring, {0, 0.4, 1.5}, 0.8, true);
    place(ball, {-2, 0.2, 1.5}, 0.5, true);
    return s;
}

// Meshes alone: more triangles than the others, nothing else to meet.
inline Scene meshesAlone() {
    Scene s = meshesAmongMirrors();
    s.spheres.clear();
    s.planes.clear();
    return s;
}

// Nothing above the floor, the eye in the floor's plane: every ray that is level is undecided.
inline Scene level() {
    Scene s = rayScene();
    s.camera->eye = {0, 0, 6};
    s.planes.push_back(floorAt(0, 0, 0, 0));
    return s;
}

}  // namespace plumb::test
