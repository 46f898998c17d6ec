// SPDX-License-Identifier: MIT
// Delta debugging (Zeller and Hildebrandt 2002, without its complements of single parts): runs of parts are left out, half as long each time.
#include "pipeline/suite/reduce.h"

#include "host/error.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

namespace plumb::suite {

namespace {

constexpr uint32_t kLeastSide = 8;  // pixels

// A part of a scene that may be left out.
struct Part {
    enum class Kind { object, sphere, plane, light, triangle } kind;
    uint32_t owner = 0;  // of a triangle: its object
    uint32_t index = 0;
};

uint64_t trianglesOf(const Scene& scene) {
    uint64_t count = 0;
    for (const Object& object : scene.objects) count += scene.meshes[object.mesh].triangles.size();
    return count;
}

// Mesh of some triangles of another, with the vertices and faces that they use.
TriangleMesh partOf(const TriangleMesh& mesh, const std::vector<uint32_t>& triangles) {
    TriangleMesh part;
    part.name = mesh.name;
    part.location = mesh.location;
    part.origin = mesh.origin;
    part.statedMin = mesh.statedMin;
    part.statedMax = mesh.statedMax;
    part.lost = mesh.lost;
    std::vector<uint32_t> vertex(mesh.positions.size(), kNone), face(mesh.faceCentre.size(), kNone);
    for (const uint32_t t : triangles) {
        for (const uint32_t v : mesh.triangles[t].vertex) vertex[v] = 0;
        face[mesh.triangles[t].face] = 0;
    }
    for (size_t v = 0; v < vertex.size(); ++v) {
        if (vertex[v] == kNone) continue;
        vertex[v] = uint32_t(part.positions.size());
        part.positions.push_back(mesh.positions[v]);
        part.normals.push_back(mesh.normals[v]);
        part.vertexMaterial.push_back(mesh.vertexMaterial[v]);
        if (!mesh.stated.empty()) part.stated.push_back(mesh.stated[v]);
    }
    for (size_t f = 0; f < face.size(); ++f) {
        if (face[f] == kNone) continue;
        face[f] = uint32_t(part.faceCentre.size());
        part.faceCentre.push_back(mesh.faceCentre[f]);
        part.faceNormal.push_back(mesh.faceNormal[f]);
        part.faceMaterial.push_back(mesh.faceMaterial[f]);
    }
    for (const uint32_t t : triangles) {
        const TriangleMesh::Triangle& from = mesh.triangles[t];
        part.triangles.push_back({{vertex[from.vertex[0]], vertex[from.vertex[1]], vertex[from.vertex[2]]}, face[from.face]});
    }
    for (const glm::uvec2& e : mesh.edges)
        if (vertex[e.x] != kNone && vertex[e.y] != kNone) part.edges.push_back({vertex[e.x], vertex[e.y]});
    part.boundsMin = part.boundsMax = part.positions[0];
    for (const glm::vec3& p : part.positions) {
        part.boundsMin = glm::min(part.boundsMin, p);
        part.boundsMax = glm::max(part.boundsMax, p);
    }
    return part;
}

std::vector<Part> coarsePartsOf(const Scene& scene) {
    std::vector<Part> parts;
    const auto add = [&](Part::Kind kind, size_t count) {
        for (uint32_t i = 0; i < count; ++i) parts.push_back({kind, 0, i});
    };
    add(Part::Kind::object, scene.objects.size());
    add(Part::Kind::sphere, scene.spheres.size());
    add(Part::Kind::plane, scene.planes.size());
    add(Part::Kind::light, scene.lights.size());
    return parts;
}

std::vector<Part> triangleParts(const Scene& scene) {
    std::vector<Part> parts;
    for (uint32_t o = 0; o < scene.objects.size(); ++o)
        for (uint32_t t = 0; t < scene.meshes[scene.objects[o].mesh].triangles.size(); ++t) parts.push_back({Part::Kind::triangle, o, t});
    return parts;
}

// Scene of those objects, shapes and lights alone.
Scene coarseScene(const Scene& from, const std::vector<Part>& parts) {
    Scene scene = from;
    scene.objects.clear();
    scene.spheres.clear();
    scene.planes.clear();
    scene.lights.clear();
    for (const Part& part : parts) {
        if (part.kind == Part::Kind::object) scene.objects.push_back(from.objects[part.index]);
        if (part.kind == Part::Kind::sphere) scene.spheres.push_back(from.spheres[part.index]);
        if (part.kind == Part::Kind::plane) scene.planes.push_back(from.planes[part.index]);
        if (part.kind == Part::Kind::light) scene.lights.push_back(from.lights[part.index]);
    }
    return scene;
}

// Scene of those triangles, each object with a mesh of its own. Objects without one are left out.
Scene sceneOfTriangles(const Scene& from, const std::vector<Part>& parts) {
    Scene scene = from;
    scene.objects.clear();
    scene.meshes.clear();
    for (size_t i = 0; i < parts.size();) {
        const uint32_t owner = parts[i].owner;
        std::vector<uint32_t> triangles;
        for (; i < parts.size() && parts[i].owner == owner; ++i) triangles.push_back(parts[i].index);
        Object object = from.objects[owner];
        scene.meshes.push_back(partOf(from.meshes[object.mesh], triangles));
        object.mesh = uint32_t(scene.meshes.size() - 1);
        scene.objects.push_back(object);
    }
    return scene;
}

class Reducer {
public:
    Reducer(Device& device, const Scene& scene, const RenderRequest& request, const std::string& pass, std::chrono::milliseconds limit,
            const std::function<void(double)>& onProgress)
        : device_(device), pass_(pass), limit_(limit), onProgress_(onProgress), start_(std::chrono::steady_clock::now()) {
        result_.scene = scene;
        result_.request = request;
        result_.request.onProgress = nullptr;
        result_.triangles = result_.trianglesBefore = trianglesOf(scene);
    }

    Reduced run() {
        shrinkPicture();
        leaveOut(coarsePartsOf(result_.scene), coarseScene);
        leaveOut(triangleParts(result_.scene), sceneOfTriangles);
        shrinkPicture();
        leaveOut(coarsePartsOf(result_.scene), coarseScene);
        result_.triangles = trianglesOf(result_.scene);
        return std::move(result_);
    }

private:
    bool late() const { return std::chrono::steady_clock::now() - start_ >= limit_; }

    // True when the sides still differ in the same pass. False for a picture that cannot be drawn.
    bool stillDiffers(const Scene& scene, const RenderRequest& request) {
        ++result_.tried;
        if (onProgress_)
            onProgress_(std::min(
                1.0, std::chrono::duration<double>(std::chrono::steady_clock::now() - start_) / std::chrono::duration<double>(limit_)));
        try {
            return differingPass(device_, scene, request) == pass_;
        } catch (const Error& error) {
            if (error.exit() == Exit::interrupted) throw;
            return false;
        }
    }

    bool take(RenderRequest request) {
        if (late() || !stillDiffers(result_.scene, request)) return false;
        result_.request = std::move(request);
        return true;
    }

    void shrinkPicture() {
        RenderRequest request = result_.request;
        if (request.samples > 1) request.samples = 1, take(request);
        for (bool smaller = true; smaller;) {
            smaller = false;
            for (const auto& [x, y] : {std::pair(2u, 2u), std::pair(2u, 1u), std::pair(1u, 2u)}) {
                request = result_.request;
                request.width = std::max(request.width / x, std::min(request.width, kLeastSide));
                request.height = std::max(request.height / y, std::min(request.height, kLeastSide));
                if (request.width == result_.request.width && request.height == result_.request.height) continue;
                smaller = smaller || take(request);
            }
        }
    }

    template <class SceneOf>
    void leaveOut(std::vector<Part> parts, const SceneOf& sceneOf) {
        const Scene from = result_.scene;
        for (size_t run = parts.size(); run > 0; run = run > 1 ? (run + 1) / 2 : 0) {
            for (bool again = true; again;) {
                again = false;
                for (size_t first = 0; first < parts.size() && !late();) {
                    std::vector<Part> fewer(parts.begin(), parts.begin() + ptrdiff_t(first));
                    fewer.insert(fewer.end(), parts.begin() + ptrdiff_t(std::min(parts.size(), first + run)), parts.end());
                    Scene scene = sceneOf(from, fewer);
                    if (stillDiffers(scene, result_.request)) {
                        parts = std::move(fewer);
                        result_.scene = std::move(scene);
                        again = run == 1;  // what was needed before may be left out now
                    } else {
                        first += run;
                    }
                }
            }
        }
    }

    Device& device_;
    const std::string pass_;
    const std::chrono::milliseconds limit_;
    const std::function<void(double)>& onProgress_;
    const std::chrono::steady_clock::time_point start_;
    Reduced result_;
};

}  // namespace

std::string differingPass(Device& device, const Scene& scene, const RenderRequest& request) {
    try {
        const VerifyReport report = verifyRender(device, scene, request);
        return report.mismatches.empty() ? std::string() : report.mismatches[0].pass;
    } catch (const Error& error) {
        if (error.exit() != Exit::failed) throw;
        const std::string what = error.what();
        return "failed: " + what.substr(0, what.find(':'));
    }
}

Reduced reduce(Device& device, const Scene& scene, const RenderRequest& request, const std::string& pass, std::chrono::milliseconds limit,
               const std::function<void(double)>& onProgress) {
    return Reducer(device, scene, request, pass, limit, onProgress).run();
}

}  // namespace plumb::suite
