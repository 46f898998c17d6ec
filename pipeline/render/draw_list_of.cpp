// SPDX-License-Identifier: MIT
#include "pipeline/render/draw_list_of.h"

#include "pipeline/passes/long_rows.h"
#include "pipeline/render/drops.h"
#include "pipeline/scene/flattened.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

namespace {

// Adjugate transpose, turned round for a matrix that mirrors: proportional to the inverse transpose, defined for singular matrices too.
// Scaled by a power of two so that its largest entry is in [0.5, 1).
glm::dmat3 normalMatrix(const glm::dmat3& m, bool mirrored) {
    glm::dmat3 c;
    c[0] = glm::cross(m[1], m[2]);
    c[1] = glm::cross(m[2], m[0]);
    c[2] = glm::cross(m[0], m[1]);
    double largest = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) largest = std::max(largest, std::abs(c[i][j]));
    if (largest > 0) {
        int exponent = 0;
        std::frexp(largest, &exponent);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) c[i][j] = std::ldexp(c[i][j], -exponent) * (mirrored ? -1 : 1);
    }
    return c;
}

gpu::LongRecord longRecordOf(const glm::dmat4& worldFromMesh, const TriangleMesh& mesh, const Pinhole& v) {
    const glm::dmat4 m = v.viewedFromMesh(worldFromMesh);
    double reach = 0;
    for (int i = 0; i < 3; ++i) reach = std::max({reach, std::abs(double(mesh.boundsMin[i])), std::abs(double(mesh.boundsMax[i]))});
    const int exponent = blockExponent(reach);
    const auto row = [&](const glm::dvec3& axis, double scale) {
        glm::dvec4 r;
        for (int i = 0; i < 4; ++i) r[i] = scale * glm::dot(axis, glm::dvec3(m[i]));
        return longRow(r, exponent);
    };
    return {row(v.right, v.focal), row(v.down, v.focal), row(v.forward, 1), float(std::ldexp(1.0, -exponent))};
}

gpu::ObjectRecord recordOf(const glm::dmat4& worldFromMesh, const Pinhole& v) {
    const glm::dmat4 m = v.viewedFromMesh(worldFromMesh);  // rounded once:
    const auto row = [&](const glm::dvec3& axis, double scale) {
        glm::vec4 r;
        for (int i = 0; i < 4; ++i) {
            const double exact = scale * glm::dot(axis, glm::dvec3(m[i]));
            r[i] = std::abs(exact) < std::numeric_limits<float>::min() ? 0.0f : float(exact);  // no denormals (docs/accuracy.md)
        }
        return r;
    };
    gpu::ObjectRecord o{};
    o.rowX = row(v.right, v.focal);
    o.rowY = row(v.down, v.focal);
    o.rowW = row(v.forward, 1);
    o.world0 = row({1, 0, 0}, 1);
    o.world1 = row({0, 1, 0}, 1);
    o.world2 = row({0, 0, 1}, 1);
    const glm::dmat3 m3(m);
    const glm::dmat3 n = normalMatrix(m3, mirrors(m));
    const auto normalRow = [&](int i) { return glm::vec4(float(n[0][i]), float(n[1][i]), float(n[2][i]), 0.0f); };
    o.normal0 = normalRow(0);
    o.normal1 = normalRow(1);
    o.normal2 = normalRow(2);
    return o;
}

// False for what is further from the eye than the passes count.
bool reaches(const gpu::ObjectRecord& o, const TriangleMesh& mesh, double focal) {
    const auto reach = [&](const glm::vec4& row) {
        double sum = std::abs(double(row.w));
        for (int i = 0; i < 3; ++i) sum += std::abs(double(row[i])) * std::max(std::abs(mesh.boundsMin[i]), std::abs(mesh.boundsMax[i]));
        return sum;
    };
    bool near = reach(o.rowX) <= kFarthest * focal && reach(o.rowY) <= kFarthest * focal;
    for (const glm::vec4& row : {o.rowW, o.world0, o.world1, o.world2}) near &= reach(row) <= kFarthest;
    return near;
}

// A point light as the framed centre sees it: one direction, and what reaches that point.
Light lampFromCentre(const Light& light, const Camera& camera) {
    if (light.directional) return light;
    const glm::dvec3 toLamp = light.position - (camera.eye + camera.forward * camera.focusDistance);
    const double distance = glm::length(toLamp);
    if (!(distance > 0)) return light;  // it stands there: no direction
    Light far = light;
    far.directional = true;
    far.direction = toLamp;
    far.attenuation = Attenuation::none;
    far.intensity = glm::vec3(glm::dvec3(light.intensity) / std::pow(distance, int(light.attenuation)));
    return far;
}

}  // namespace

ListBuilder::ListBuilder(const Scene& scene, const RenderRequest& request, const Pinhole& view, Prepared& prepared)
    : scene_(scene), request_(request), view_(view), p_(prepared), list_(prepared.list), slots_(scene.materials.size(), kNone) {}

void ListBuilder::setPrecisions(std::vector<Precision> precisions) {
    precisions_ = std::move(precisions);
    list_.anyLong = std::any_of(precisions_.begin(), precisions_.end(), [](Precision p) { return p != Precision::fp32; });
}

// Front faces run counter-clockwise as seen in a right-handed world, clockwise in a left-handed one; a mirror swaps.
bool ListBuilder::isTurned(const glm::dmat4& worldFromMesh) const { return scene_.leftHanded != mirrors(worldFromMesh); }

void ListBuilder::addObjects(bool keepOutside) {
    uint64_t inside = 0;
    for (uint32_t i = 0; i < scene_.objects.size(); ++i) {
        const Object& object = scene_.objects[i];
        const TriangleMesh& mesh = scene_.meshes[object.mesh];
        p_.counters.vertices += mesh.positions.size();
        p_.counters.triangles += mesh.triangles.size();
        const DropRow* left = p_.leftOut[i];
        if (left == nullptr || left != &dropRow("outside")) ++inside;
        if (left != nullptr && !(keepOutside && reaches(recordOf(worldFromMesh(scene_, object), view_), mesh, view_.focal)))
            stateDrop(*left, p_.plan, fmt::format("object {}", object.name.empty() ? std::to_string(i) : object.name),
                      left == &dropRow("outside") ? "outside the view" : "wholly behind a face of another object",
                      countOf(mesh.positions.size(), "vertex", "vertices"));
        else
            addObject(i);
    }
    p_.counters.objectsDrawn = inside;
}

bool ListBuilder::placeObjects() {
    // The index of a triangle over the whole scene counts the objects of the list, which then are those of the view.
    const bool exactly = request_.planes & kPlaneTriangle;
    std::vector<bool> listed(scene_.objects.size()), outside(scene_.objects.size());
    for (const DrawList::Range& r : list_.ranges) listed[r.sceneObject] = true;
    for (size_t i = 0; i < listed.size(); ++i) {
        outside[i] = p_.leftOut[i] != nullptr;
        const bool missing = !outside[i] && !listed[i], needless = outside[i] && listed[i];
        if (missing || (needless && exactly)) return false;
    }
    p_.counters.objectsDrawn = uint64_t(std::count(outside.begin(), outside.end(), false));
    list_.faceCentres.clear();
    for (const DrawList::Range& r : list_.ranges) {
        const Object& object = scene_.objects[r.sceneObject];
        const TriangleMesh& mesh = scene_.meshes[object.mesh];
        const glm::dmat4 toWorld = worldFromMesh(scene_, object);
        if (isTurned(toWorld) != r.turned) return false;
        if (!precisions_.empty() && precisions_[r.sceneObject] != r.precision) return false;
        list_.objects[r.record] = recordOf(toWorld, view_);
        if (r.precision != Precision::fp32) list_.longs[r.record] = longRecordOf(toWorld, mesh, view_);
        if (!reaches(list_.objects[r.record], mesh, view_.focal)) return false;
        addCentres(mesh, toWorld);
    }
    return true;
}

void ListBuilder::addSphereMaterials() {
    for (const SphereShape& sphere : scene_.spheres) list_.sphereMaterial.push_back(slotOf(sphere.material));
}

uint32_t ListBuilder::slotOf(uint32_t material) {
    PLUMB_ASSERT(material < scene_.materials.size());
    uint32_t& slot = slots_[material];
    if (slot == kNone) {
        slot = uint32_t(list_.materials.size());
        const Material& m = scene_.materials[material];
        const glm::vec3 base = m.ambient * scene_.ambient + m.emission;
        // Unlit draws what a surface shows without a light: its own colour and what it emits.
        const bool unlit = request_.shading == Shading::unlit;
        list_.materials.push_back(
            {base, m.shininess, unlit ? m.diffuse + m.emission : m.diffuse, m.shininess == 0 ? 1.0f : 0.0f, m.specular, 0.0f});
    }
    return slot;
}

void ListBuilder::addObject(uint32_t index) {
    const Object& object = scene_.objects[index];
    const TriangleMesh& mesh = scene_.meshes[object.mesh];
    DrawList::Range r;
    r.sceneObject = index;
    r.record = uint32_t(list_.objects.size());
    r.firstVertex = uint32_t(list_.positions.size());
    r.vertexCount = uint32_t(mesh.positions.size());
    r.firstTriangle = uint32_t(list_.triangles.size());
    r.triangleCount = uint32_t(mesh.triangles.size());
    r.firstFace = uint32_t(list_.facePositions.size());
    r.faceCount = uint32_t(mesh.faceCentre.size());
    if (list_.positions.size() + mesh.positions.size() > 0x7fffffffu || list_.triangles.size() + mesh.triangles.size() > 0x7fffffffu)
        throw inputError(scene_.path, "the scene has more than 2^31 vertices or triangles");
    const glm::dmat4 toWorld = worldFromMesh(scene_, object);
    list_.objects.push_back(recordOf(toWorld, view_));
    if (!precisions_.empty()) r.precision = precisions_[index];
    if (list_.anyLong) list_.longs.push_back(r.precision != Precision::fp32 ? longRecordOf(toWorld, mesh, view_) : gpu::LongRecord{});
    if (!reaches(list_.objects.back(), mesh, view_.focal))
        throw inputError(locationOfPart(object.location, scene_.path, "object", object.name),
                         "it reaches further from the eye than 2^60 times the near plane: move the object or the camera, or change the "
                         "scale or the near plane");
    addStreams(mesh);
    addFaces(mesh);
    addCentres(mesh, toWorld);
    const bool swap = r.turned = isTurned(toWorld);
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
        list_.triangles.emplace_back(r.firstVertex + t.vertex[0], r.firstVertex + t.vertex[swap ? 2 : 1],
                                     r.firstVertex + t.vertex[swap ? 1 : 2], slotOf(mesh.faceMaterial[t.face]));
        list_.triangleFace.push_back(r.firstFace + t.face);
    }
    list_.ranges.push_back(r);
}

void ListBuilder::addStreams(const TriangleMesh& mesh) {
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
        list_.positions.emplace_back(mesh.positions[i], 1.0f);
        list_.normals.emplace_back(mesh.normals[i], 0.0f);
        list_.vertexMaterial.push_back(slotOf(mesh.vertexMaterial[i]));
    }
}

void ListBuilder::addFaces(const TriangleMesh& mesh) {
    for (size_t f = 0; f < mesh.faceCentre.size(); ++f) {
        list_.facePositions.emplace_back(mesh.faceCentre[f], 1.0f);
        list_.faceNormals.emplace_back(mesh.faceNormal[f], 0.0f);
        list_.faceMaterial.push_back(slotOf(mesh.faceMaterial[f]));
        list_.facePrimitive.push_back(uint32_t(f));
    }
}

void ListBuilder::addCentres(const TriangleMesh& mesh, const glm::dmat4& worldFromMesh) {
    if (request_.trade.vectors != Trade::Vectors::face) return;
    const glm::dmat4 viewed = view_.viewedFromMesh(worldFromMesh);
    for (const glm::vec3& centre : mesh.faceCentre) {
        glm::vec4 seen(viewed * glm::dvec4(centre, 1));
        for (int i = 0; i < 3; ++i)
            if (std::abs(seen[i]) < std::numeric_limits<float>::min()) seen[i] = 0;
        list_.faceCentres.push_back(seen);
    }
}

void ListBuilder::addLights() {
    for (const Light& stated : scene_.lights) addLight(stated);
}

void ListBuilder::addLight(const Light& stated) {
    const Light light = request_.trade.vectors == Trade::Vectors::scene ? lampFromCentre(stated, *scene_.camera) : stated;
    if (light.intensity == glm::vec3(0) && !request_.knobs.keepEverything)
        return stateDrop(dropRow("dark"), p_.plan, "", "its intensity is 0",
                         fmt::format("1 of {} at each illumination", countOf(scene_.lights.size(), "light", "lights")));
    gpu::LightRecord l{};
    // Attenuation by 1/d^p with d in the passes' units: the intensity takes unit^p, a power of two.
    const double fade = light.directional ? 1 : std::pow(view_.unit, int(light.attenuation));
    for (int i = 0; i < 3; ++i) {
        const double intensity = light.intensity[i] * fade;
        l.intensity[i] = intensity < std::numeric_limits<float>::min() ? 0.0f : float(intensity);
    }
    l.attenuation = float(int(light.attenuation));
    l.kind = light.directional ? 0.0f : 1.0f;
    l.position = light.directional ? glm::vec3(glm::normalize(light.direction)) : glm::vec3((light.position - view_.eye) * view_.unit);
    const auto refuse = [&](const char* why) { throw inputError(locationOfPart(stated.location, scene_.path, "light", ""), why); };
    if (!light.directional && !(glm::length(glm::dvec3(l.position)) <= kFarthest))
        refuse("a point light is further from the eye than 2^60 times the near plane");
    if (!(std::max({l.intensity.x, l.intensity.y, l.intensity.z}) <= 0x1p100f))
        refuse(
            "a point light with attenuation is brighter than 2^100 at the near plane's distance: change its intensity or the near plane");
    list_.lights.push_back(l);
}

}  // namespace plumb
