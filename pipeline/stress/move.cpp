// SPDX-License-Identifier: MIT
#include "pipeline/stress/move.h"

#include "pipeline/scene/camera.h"
#include "pipeline/scene/mesh_origin.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace plumb::stress {
namespace {

// Coordinates of a plane beyond this have no bound.
constexpr double kUnbounded = 1e299;
// Least length of an interpolated normal. Below it the corners' normals are opposite, and the face's own is taken.
constexpr double kLeastNormal = 0x1p-10;

float flushed(double x) {
    const auto rounded = float(x);
    return std::abs(rounded) < std::numeric_limits<float>::min() ? 0.0f : rounded;
}
glm::vec3 flushed(const glm::dvec3& v) { return {flushed(v.x), flushed(v.y), flushed(v.z)}; }

// Sets what follows from positions as a file states them: origin, float32 positions, boxes and what float32 lost.
void settle(TriangleMesh& mesh, std::vector<glm::dvec3> stated) {
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
    for (const glm::dvec3& p : stated) low = glm::min(low, p), high = glm::max(high, p);
    mesh.statedMin = low;
    mesh.statedMax = high;
    mesh.origin = originOfBox(low, high);
    mesh.lost = glm::dvec3(0);
    mesh.positions.resize(stated.size());
    for (size_t i = 0; i < stated.size(); ++i) {
        const glm::dvec3 exact = stated[i] - mesh.origin;
        mesh.positions[i] = flushed(exact);
        mesh.lost = glm::max(mesh.lost, glm::abs(exact - glm::dvec3(mesh.positions[i])));
    }
    mesh.boundsMin = flushed(low - mesh.origin);
    mesh.boundsMax = flushed(high - mesh.origin);
    if (mesh.lost == glm::dvec3(0)) stated.clear();
    mesh.stated = std::move(stated);
}

glm::dmat4 translation(const glm::dvec3& by) {
    glm::dmat4 m(1);
    m[3] = glm::dvec4(by, 1);
    return m;
}

double bounded(double value, double factor) { return std::abs(value) >= kUnbounded ? value : value * factor; }

// Power of the distance by which a light fades.
int fadeOf(const Light& light) { return light.directional ? 0 : int(light.attenuation); }

// Corners of a triangle's parts: row i from corner a, place j in the row.
struct Grid {
    uint32_t parts;
    uint32_t at(uint32_t i, uint32_t j) const { return i * (i + 1) / 2 + j; }
    uint32_t count() const { return (parts + 1) * (parts + 2) / 2; }
};

}  // namespace

glm::dvec3 centreOf(const Camera& camera) { return camera.eye + camera.forward * camera.focusDistance; }

double largestOf(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

void restate(TriangleMesh& mesh, const std::function<glm::dvec3(const glm::dvec3&)>& to) {
    std::vector<glm::dvec3> stated(mesh.positions.size()), centres(mesh.faceCentre.size());
    for (size_t i = 0; i < stated.size(); ++i) stated[i] = to(mesh.statedAt(i));
    for (size_t f = 0; f < centres.size(); ++f) centres[f] = to(mesh.origin + glm::dvec3(mesh.faceCentre[f]));
    settle(mesh, std::move(stated));
    for (size_t f = 0; f < centres.size(); ++f) mesh.faceCentre[f] = flushed(centres[f] - mesh.origin);
}

void addFarFace(TriangleMesh& mesh, const glm::dvec3& at) {
    std::vector<glm::dvec3> stated(mesh.positions.size()), centres(mesh.faceCentre.size());
    for (size_t i = 0; i < stated.size(); ++i) stated[i] = mesh.statedAt(i);
    for (size_t f = 0; f < centres.size(); ++f) centres[f] = mesh.origin + glm::dvec3(mesh.faceCentre[f]);
    const auto vertex = uint32_t(stated.size());
    mesh.triangles.push_back({{vertex, vertex, vertex}, uint32_t(centres.size())});
    stated.push_back(at);
    centres.push_back(at);
    mesh.normals.emplace_back(0, 0, 1);
    mesh.faceNormal.emplace_back(0, 0, 1);
    mesh.vertexMaterial.push_back(mesh.vertexMaterial.front());
    mesh.faceMaterial.push_back(mesh.faceMaterial.front());
    ++mesh.degenerateFaces;
    settle(mesh, std::move(stated));
    mesh.faceCentre.resize(centres.size());
    for (size_t f = 0; f < centres.size(); ++f) mesh.faceCentre[f] = flushed(centres[f] - mesh.origin);
}

TriangleMesh cutFaces(const TriangleMesh& mesh, uint32_t parts) {
    TriangleMesh out;
    out.name = mesh.name;
    out.location = mesh.location;
    const Grid grid{parts};
    std::vector<glm::dvec3> stated;
    stated.reserve(mesh.triangles.size() * grid.count());
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
        const auto first = uint32_t(stated.size());
        const glm::dvec3 a = mesh.statedAt(t.vertex[0]), b = mesh.statedAt(t.vertex[1]), c = mesh.statedAt(t.vertex[2]);
        for (uint32_t i = 0; i <= parts; ++i)
            for (uint32_t j = 0; j <= i; ++j) {
                // Weights are whole and their sum is `parts`. On an edge one is 0, and both triangles of the edge compute the same bits.
                const double u = parts - i, v = i - j, w = j;
                stated.push_back((a * u + b * v + c * w) / double(parts));
                const glm::dvec3 n = glm::dvec3(mesh.normals[t.vertex[0]]) * u + glm::dvec3(mesh.normals[t.vertex[1]]) * v +
                                     glm::dvec3(mesh.normals[t.vertex[2]]) * w;
                const double length = glm::length(n) / parts;
                out.normals.push_back(length < kLeastNormal ? mesh.faceNormal[t.face] : flushed(n / (length * parts)));
                out.vertexMaterial.push_back(mesh.vertexMaterial[t.vertex[0]]);
            }
        const auto add = [&](uint32_t p, uint32_t q, uint32_t r) {
            out.triangles.push_back({{first + p, first + q, first + r}, uint32_t(out.faceNormal.size())});
            out.faceNormal.push_back(mesh.faceNormal[t.face]);
            out.faceMaterial.push_back(mesh.faceMaterial[t.face]);
        };
        for (uint32_t i = 0; i < parts; ++i)
            for (uint32_t j = 0; j <= i; ++j) {
                add(grid.at(i, j), grid.at(i + 1, j), grid.at(i + 1, j + 1));
                if (j < i) add(grid.at(i, j), grid.at(i + 1, j + 1), grid.at(i, j + 1));
            }
    }
    settle(out, std::move(stated));
    for (const TriangleMesh::Triangle& t : out.triangles) {
        glm::dvec3 sum(0);
        for (const uint32_t v : t.vertex) sum += glm::dvec3(out.positions[v]);
        out.faceCentre.push_back(flushed(sum / 3.0));
    }
    return out;
}

void translate(Scene& scene, const glm::dvec3& by) {
    transformObjects(scene, translation(by));
    for (SphereShape& sphere : scene.spheres) sphere.centre += by;
    for (PlaneShape& plane : scene.planes) plane.point += by;
    for (Light& light : scene.lights) light.position += by;
    scene.camera->eye += by;
}

void enlarge(Scene& scene, double factor) {
    glm::dmat4 m(factor);
    m[3][3] = 1;
    transformObjects(scene, m);
    for (SphereShape& sphere : scene.spheres) sphere.centre *= factor, sphere.radius *= factor;
    for (PlaneShape& plane : scene.planes) {
        plane.point *= factor;
        for (double* const at : {&plane.uMin, &plane.uMax, &plane.vMin, &plane.vMax}) *at = bounded(*at, factor);
        plane.square *= factor;
    }
    for (Light& light : scene.lights) {
        light.position *= factor;
        light.intensity = glm::vec3(glm::dvec3(light.intensity) * std::pow(factor, fadeOf(light)));
    }
    Camera& camera = *scene.camera;
    camera.eye *= factor;
    camera.focusDistance *= factor;
    camera.near *= factor;
}

void transformObjects(Scene& scene, const glm::dmat4& world) {
    for (Object& object : scene.objects) object.worldFromObject = world * object.worldFromObject;
}

void stretch(Scene& scene, double factor) {
    const Camera& camera = *scene.camera;
    const glm::dvec3 f = camera.forward;
    glm::dmat4 m(1);
    for (int c = 0; c < 3; ++c) m[c] += glm::dvec4(f * ((factor - 1) * f[c]), 0);
    m[3] -= glm::dvec4(f * ((factor - 1) * glm::dot(f, camera.eye)), 0);
    transformObjects(scene, m);
    for (Light& light : scene.lights) light.position += f * ((factor - 1) * glm::dot(f, light.position - camera.eye));
    scene.camera->focusDistance *= factor;
    scene.camera->near *= factor;
}

void addLayer(Scene& scene, double gap) {
    const glm::dvec3 eye = scene.camera->eye;
    const double factor = 1 - gap;
    glm::dmat4 toward(factor);
    toward[3] = glm::dvec4(eye * gap, 1);
    const size_t objects = scene.objects.size(), spheres = scene.spheres.size(), planes = scene.planes.size();
    for (size_t i = 0; i < objects; ++i) {
        Object copy = scene.objects[i];
        if (!copy.name.empty()) copy.name += " (layer)";
        copy.worldFromObject = toward * copy.worldFromObject;
        scene.objects.push_back(std::move(copy));
    }
    for (size_t i = 0; i < spheres; ++i) {
        SphereShape copy = scene.spheres[i];
        copy.centre = copy.centre * factor + eye * gap;
        copy.radius *= factor;
        scene.spheres.push_back(std::move(copy));
    }
    for (size_t i = 0; i < planes; ++i) {
        PlaneShape copy = scene.planes[i];
        copy.point = copy.point * factor + eye * gap;
        for (double* const at : {&copy.uMin, &copy.uMax, &copy.vMin, &copy.vMax}) *at = bounded(*at, factor);
        copy.square *= factor;
        scene.planes.push_back(std::move(copy));
    }
}

void moveLights(Scene& scene, const glm::dvec3& centre, double factor) {
    for (Light& light : scene.lights) {
        if (light.directional) continue;
        light.position = centre + (light.position - centre) * factor;
        light.intensity = glm::vec3(glm::dvec3(light.intensity) * std::pow(factor, fadeOf(light)));
    }
}

double nearestDepth(const Scene& scene) {
    const Camera& camera = *scene.camera;
    double nearest = std::numeric_limits<double>::infinity();
    for (const Object& object : scene.objects) {
        const TriangleMesh& mesh = scene.meshes[object.mesh];
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 p(corner & 1 ? mesh.statedMax.x : mesh.statedMin.x, corner & 2 ? mesh.statedMax.y : mesh.statedMin.y,
                               corner & 4 ? mesh.statedMax.z : mesh.statedMin.z);
            const glm::dvec3 world(object.worldFromObject * glm::dvec4(p, 1));
            nearest = std::min(nearest, glm::dot(world - camera.eye, camera.forward));
        }
    }
    return std::isfinite(nearest) ? std::max(nearest, nearOf(camera)) : nearOf(camera);
}

}  // namespace plumb::stress
