// SPDX-License-Identifier: MIT
#include "pipeline/render/prepare.h"

#include "pipeline/passes/long_rows.h"
#include "pipeline/render/notes/polygons.h"
#include "pipeline/render/plan_steps.h"
#include "pipeline/scene/camera.h"
#include "pipeline/scene/flattened.h"
#include "pipeline/scene/plain_floats.h"
#include "pipeline/scene/ray_shares.h"
#include "pipeline/scene/text.h"

#include "pipeline/passes/encode.h"
#include "pipeline/passes/resolve.h"
#include "shaders/shared/spheres.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

namespace {

// From here on a kernel with its lights unrolled pays for the time that it takes to make (decision 71).
constexpr uint64_t kPixelsWorthUnrolling = uint64_t(1) << 23;

struct Pinhole {
    double focal = 0;  // sample pixels
    double near = 0;
    double unit = 1;  // passes count lengths in powers of two of the scene's unit in which 1 <= near < 2: squares of distances
                      // neither overflow nor underflow whatever unit a scene is in, and scaling it by 2^k changes no bit
    glm::dvec3 right, down, forward, eye;
    double width = 0, height = 0;  // samples
};

Pinhole pinholeOf(const Camera& camera, double width, double height, double side) {
    Pinhole v;
    v.width = width;
    v.height = height;
    v.focal = focalOf(camera, height, side);
    v.near = nearOf(camera);
    v.unit = std::ldexp(1.0, -std::ilogb(v.near));
    v.right = camera.right;
    v.down = -camera.up;
    v.forward = camera.forward;
    v.eye = camera.eye;
    return v;
}

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

// Relative to the eye, in binary64: the error scales with the distance to the camera, not to the origin.
glm::dmat4 viewedFromMesh(const glm::dmat4& worldFromMesh, const Pinhole& v) {
    glm::dmat4 m = worldFromMesh;
    m[3] -= glm::dvec4(v.eye, 0);
    return m * v.unit;
}

gpu::LongRecord longRecordOf(const glm::dmat4& worldFromMesh, const TriangleMesh& mesh, const Pinhole& v) {
    const glm::dmat4 m = viewedFromMesh(worldFromMesh, v);
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
    const glm::dmat4 m = viewedFromMesh(worldFromMesh, v);  // rounded once:
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

// All eight corners of the box beyond one side of the view, by a margin that covers the rounding of the passes (a pixel).
bool outsideView(const TriangleMesh& mesh, const glm::dmat4& worldFromMesh, const Pinhole& v) {
    int beyond[5] = {0, 0, 0, 0, 0};
    for (int i = 0; i < 8; ++i) {
        const glm::dvec3 corner(i & 1 ? mesh.boundsMax.x : mesh.boundsMin.x, i & 2 ? mesh.boundsMax.y : mesh.boundsMin.y,
                                i & 4 ? mesh.boundsMax.z : mesh.boundsMin.z);
        const glm::dvec3 p = glm::dvec3(worldFromMesh * glm::dvec4(corner, 1)) - v.eye;
        const double x = glm::dot(v.right, p) * v.focal, y = glm::dot(v.down, p) * v.focal, w = glm::dot(v.forward, p);
        const double halfX = v.width / 2 + 1, halfY = v.height / 2 + 1;
        beyond[0] += w < v.near * (1 - 1e-6);
        beyond[1] += x + halfX * w < -1e-5 * halfX * std::abs(w);
        beyond[2] += halfX * w - x < -1e-5 * halfX * std::abs(w);
        beyond[3] += y + halfY * w < -1e-5 * halfY * std::abs(w);
        beyond[4] += halfY * w - y < -1e-5 * halfY * std::abs(w);
    }
    for (int side : beyond)
        if (side == 8) return true;
    return false;
}

static_assert(Trade::kStandardDepth == gpu::kDepthStandard);

bool isZero(const glm::vec3& c) { return c.x == 0 && c.y == 0 && c.z == 0; }

// How far from the eye anything may reach, in units of the near plane: squares of it and of x = focal * it stay finite.
constexpr double kFarthest = 0x1p60;

void checkReach(const gpu::ObjectRecord& o, const TriangleMesh& mesh, double focal, const std::string& place) {
    const auto reach = [&](const glm::vec4& row) {
        double sum = std::abs(double(row.w));
        for (int i = 0; i < 3; ++i) sum += std::abs(double(row[i])) * std::max(std::abs(mesh.boundsMin[i]), std::abs(mesh.boundsMax[i]));
        return sum;
    };
    bool near = reach(o.rowX) <= kFarthest * focal && reach(o.rowY) <= kFarthest * focal;
    for (const glm::vec4& row : {o.rowW, o.world0, o.world1, o.world2}) near &= reach(row) <= kFarthest;
    if (!near)
        throw inputError(place,
                         "it reaches further from the eye than 2^60 times the near plane: move the object or the camera, or change the "
                         "scale or the near plane");
}

// Place of a material in the list, appended when it is met first.
uint32_t slotOfMaterial(DrawList& list, const Scene& scene, uint32_t material, std::vector<uint32_t>& materialSlot, bool unlit) {
    PLUMB_ASSERT(material < scene.materials.size());
    uint32_t& slot = materialSlot[material];
    if (slot == kNone) {
        slot = uint32_t(list.materials.size());
        const Material& m = scene.materials[material];
        const glm::vec3 base = m.ambient * scene.ambient + m.emission;
        // Unlit draws what a surface shows without a light: its own colour and what it emits.
        list.materials.push_back(
            {base, m.shininess, unlit ? m.diffuse + m.emission : m.diffuse, m.shininess == 0 ? 1.0f : 0.0f, m.specular, 0.0f});
    }
    return slot;
}

void appendObject(DrawList& list, const Scene& scene, uint32_t index, const Pinhole& view, std::vector<uint32_t>& materialSlot,
                  const RenderRequest& request) {
    const bool unlit = request.shading == Shading::unlit;
    const Object& object = scene.objects[index];
    const TriangleMesh& mesh = scene.meshes[object.mesh];
    DrawList::Range r;
    r.sceneObject = index;
    r.record = uint32_t(list.objects.size());
    r.firstVertex = uint32_t(list.positions.size());
    r.vertexCount = uint32_t(mesh.positions.size());
    r.firstTriangle = uint32_t(list.triangles.size());
    r.triangleCount = uint32_t(mesh.triangles.size());
    r.firstFace = uint32_t(list.facePositions.size());
    r.faceCount = uint32_t(mesh.faceCentre.size());
    r.firstEdge = uint32_t(list.edges.size());
    if (list.positions.size() + mesh.positions.size() > 0x7fffffffu || list.triangles.size() + mesh.triangles.size() > 0x7fffffffu)
        throw inputError(scene.path, "the scene has more than 2^31 vertices or triangles");
    const glm::dmat4 toWorld = worldFromMesh(scene, object);
    list.objects.push_back(recordOf(toWorld, view));
    if (list.numbers != Numbers::fp32) list.longs.push_back(longRecordOf(toWorld, mesh, view));
    checkReach(list.objects.back(), mesh, view.focal, placeOfPart(object.place, scene.path, "object", object.name));
    const auto slotOf = [&](uint32_t material) { return slotOfMaterial(list, scene, material, materialSlot, unlit); };
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
        list.positions.emplace_back(mesh.positions[i], 1.0f);
        list.normals.emplace_back(mesh.normals[i], 0.0f);
        list.vertexMaterial.push_back(slotOf(mesh.vertexMaterial[i]));
    }
    const glm::dmat4 viewed = viewedFromMesh(toWorld, view);
    for (size_t f = 0; f < mesh.faceCentre.size(); ++f) {
        list.facePositions.emplace_back(mesh.faceCentre[f], 1.0f);
        list.faceNormals.emplace_back(mesh.faceNormal[f], 0.0f);
        list.faceMaterial.push_back(slotOf(mesh.faceMaterial[f]));
        list.facePrimitive.push_back(uint32_t(f));
        if (request.trade.vectors == Trade::Vectors::face) {
            glm::vec4 place(viewed * glm::dvec4(mesh.faceCentre[f], 1));
            for (int i = 0; i < 3; ++i)
                if (std::abs(place[i]) < std::numeric_limits<float>::min()) place[i] = 0;
            list.facePlaces.push_back(place);
        }
    }
    // Front faces run counter-clockwise as seen in a right-handed world, clockwise in a left-handed one; a mirror swaps.
    const bool swap = scene.leftHanded != mirrors(toWorld);
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
        list.triangles.emplace_back(r.firstVertex + t.vertex[0], r.firstVertex + t.vertex[swap ? 2 : 1],
                                    r.firstVertex + t.vertex[swap ? 1 : 2], slotOf(mesh.faceMaterial[t.face]));
        list.triangleFace.push_back(r.firstFace + t.face);
    }
    if (request.shading == Shading::wire) {
        const bool solid = request.wire == WireView::solid;
        for (const WireEdge& e : wireEdges(mesh, toWorld, view.eye, {request.wirePerPolygon || solid, request.wire == WireView::culled})) {
            list.edges.push_back(e.vertex + r.firstVertex);
            if (solid) list.edgeFace.push_back(r.firstFace + e.face);
        }
        r.edgeCount = uint32_t(list.edges.size() - r.firstEdge);
    }
    list.ranges.push_back(r);
}

// A point light as the framed centre sees it: one direction, and what reaches that place.
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

void planLights(const Scene& scene, const RenderRequest& request, const Pinhole& view, Prepared& p) {
    for (const Light& stated : scene.lights) {
        const Light light = request.trade.vectors == Trade::Vectors::scene ? lampFromCentre(stated, *scene.camera) : stated;
        if (isZero(light.intensity) && !request.keepEverything) {
            p.plan.dropped.push_back({"light", "its intensity is 0"});
            continue;
        }
        gpu::LightRecord l{};
        // Attenuation by 1/d^p with d in the passes' units: the intensity takes unit^p, a power of two.
        const double fade = light.directional ? 1 : std::pow(view.unit, int(light.attenuation));
        for (int i = 0; i < 3; ++i) {
            const double intensity = light.intensity[i] * fade;
            l.intensity[i] = intensity < std::numeric_limits<float>::min() ? 0.0f : float(intensity);
        }
        l.attenuation = float(int(light.attenuation));
        l.kind = light.directional ? 0.0f : 1.0f;
        l.place = light.directional ? glm::vec3(glm::normalize(light.direction)) : glm::vec3((light.position - view.eye) * view.unit);
        if (!light.directional && !(glm::length(glm::dvec3(l.place)) <= kFarthest))
            throw inputError(placeOfPart(stated.place, scene.path, "light", ""),
                             "a point light is further from the eye than 2^60 times the near plane");
        if (!(std::max({l.intensity.x, l.intensity.y, l.intensity.z}) <= 0x1p100f))
            throw inputError(placeOfPart(stated.place, scene.path, "light", ""),
                             "a point light with attenuation is brighter than 2^100 at the near plane's distance: change its "
                             "intensity or the near plane");
        p.list.lights.push_back(l);
    }
    bool diffuse = false, specular = false, point = false;
    for (const gpu::MaterialRecord& m : p.list.materials) {
        diffuse |= !isZero(m.diffuse);
        specular |= !isZero(m.specular);
    }
    for (const gpu::LightRecord& l : p.list.lights) point |= l.kind != 0;
    FillChoices& c = p.choices;
    c.encoding = request.encoding == Encoding::linear ? gpu::kEncodeLinear
                 : request.trade.nativeEncode         ? gpu::kEncodeNative
                                                      : gpu::kEncodeSrgb;
    switch (request.shading) {
        case Shading::wire:
        case Shading::unlit:
            c.shading = gpu::kShadingUnlit;
            break;
        case Shading::flat:
            c.shading = gpu::kShadingFlat;
            break;
        case Shading::gouraud:
            c.shading = gpu::kShadingGouraud;
            break;
        case Shading::ray:
        case Shading::phong:
            c.shading = gpu::kShadingPhong;
            break;
    }
    using Specular = Trade::Specular;
    const Specular specularBy = request.trade.specular;
    c.parts.power = specularBy == Specular::schlick  ? gpu::kPowerSchlick
                    : specularBy == Specular::native ? gpu::kPowerNative
                                                     : gpu::kPowerExact;
    if (c.shading == gpu::kShadingUnlit) {
        c.parts = {false, false, false};
        p.list.lights.clear();
        return;
    }
    if (request.keepEverything || request.shading == Shading::ray) return;
    if (p.list.lights.empty() || (!diffuse && !specular)) {
        p.plan.dropped.push_back({"illumination", p.list.lights.empty() ? "no light" : "no material reflects light"});
        c.parts = {false, false, false};
        p.list.lights.clear();
        // Interpolating equal colours rounds: Gouraud keeps its colours of vertices, the others draw the base colour itself.
        if (c.shading == gpu::kShadingGouraud) return;
        c.shading = gpu::kShadingUnlit;
        for (gpu::MaterialRecord& m : p.list.materials) m.diffuse = m.base;
        return;
    }
    c.parts = {diffuse, specular, point, c.parts.power};
    if (!diffuse) p.plan.dropped.push_back({"diffuse", "Kd is 0 everywhere"});
    if (!specular) p.plan.dropped.push_back({"specular", "Ks is 0 everywhere"});
    if (!point) p.plan.dropped.push_back({"surface position", "no point light"});
    const bool manyPixels = request.repeated || uint64_t(p.width) * p.height >= kPixelsWorthUnrolling;
    if (manyPixels && p.list.lights.size() <= gpu::kUnrolledLights) {
        c.lightCount = uint32_t(p.list.lights.size());
        c.lightKinds = kindsOf(p.list.lights);
    }
    c.oneMaterial = p.list.materials.size() == 1;
}

// Where the first of the spheres and planes is stated.
std::string firstShapePlace(const Scene& scene) {
    const std::string place = !scene.spheres.empty() ? scene.spheres[0].place : !scene.planes.empty() ? scene.planes[0].place : "";
    return place.empty() ? printablePath(scene.path) : place;
}

// What the implicit sphere rendering of the notes can draw.
void checkSpheres(const Scene& scene, const RenderRequest& request) {
    if (request.shading != Shading::phong) throw usageError("--fill notes illuminates spheres at each pixel: --shading phong");
    if (request.samples != 1) throw usageError("--fill notes draws one sample a pixel: leave --samples out");
    if (!scene.objects.empty())
        throw inputError(
            firstShapePlace(scene),
            "it has meshes beside spheres; --fill notes draws spheres in parallel projection and meshes in perspective, so not both");
    if (scene.lights.size() > size_t(gpu::kSphereLights))
        throw inputError(scene.lights[size_t(gpu::kSphereLights)].place.empty() ? printablePath(scene.path)
                                                                                : scene.lights[size_t(gpu::kSphereLights)].place,
                         fmt::format("{} lights; --fill notes draws spheres under at most {}", scene.lights.size(), gpu::kSphereLights));
    if (!(scene.camera->focalPixels > 0))
        throw inputError(firstShapePlace(scene), "--fill notes draws spheres for the viewer of camera.distance, a pixel a unit");
}

}  // namespace

namespace {

// How --sampling names them.
const char* wordsOf(RayChoices::Sampling sampling) {
    switch (sampling) {
        case RayChoices::Sampling::grid:
            return "grid";
        case RayChoices::Sampling::centre:
            return "centre: every ray through the middle of its pixel";
        case RayChoices::Sampling::random:
            return "random: a ray anywhere in each sample's square";
        case RayChoices::Sampling::corners:
            return "corners: a ray through each corner, shared by up to four pixels";
        case RayChoices::Sampling::adaptive:
            return "adaptive: corners, and the 16 samples of a grid where they differ";
        case RayChoices::Sampling::notes:
            return "notes: through the lower right corner of each sample";
    }
    return "";
}

void checkRays(const RenderRequest& request) {
    const RayChoices& rays = request.rays;
    const bool corners = rays.sampling == RayChoices::Sampling::corners, adaptive = rays.sampling == RayChoices::Sampling::adaptive;
    if ((corners || adaptive) && request.samples != 1)
        throw usageError(fmt::format("--sampling {} has its own number of samples; leave --samples out", corners ? "corners" : "adaptive"));
    if (adaptive && std::max(request.width, request.height) > 16384)
        throw usageError("--sampling adaptive: a picture of at most 16384 pixels a side, four samples each");
    if (corners && std::max(request.width, request.height) > 65535)
        throw usageError("--sampling corners: a picture of at most 65535 pixels a side, and one corner more");
    for (const float amount : {rays.jitterReflect, rays.jitterRefract, rays.jitterShadow})
        if (!(amount >= 0 && amount <= 0.5f)) throw usageError("--jitter: an amount is outside 0 to 0.5");
    if (rays.cutLevels && request.encoding != Encoding::linear)
        throw usageError("--levels cut counts bytes as light: it goes with --encode linear");
}

void planRays(const RenderRequest& request, Plan& plan) {
    const RayChoices& rays = request.rays;
    const auto by = [](const std::string& who) { return who.empty() ? "" : fmt::format(" (stated by {})", who); };
    const RenderRequest::StatedBy& stated = request.statedBy;
    if (rays.sampling != RayChoices::Sampling::grid || !stated.sampling.empty())
        plan.choices.push_back(fmt::format("sampling {}{}", wordsOf(rays.sampling), by(stated.sampling)));
    for (const auto& [name, amount] : {std::pair("reflected rays", rays.jitterReflect), std::pair("refracted rays", rays.jitterRefract),
                                       std::pair("shadow feelers", rays.jitterShadow)})
        if (amount > 0) plan.choices.push_back(fmt::format("noise of {:g} on {}, seed {}{}", amount, name, rays.seed, by(stated.jitter)));
    if (!stated.seed.empty()) plan.choices.push_back(fmt::format("seed {}{}", rays.seed, by(stated.seed)));
    if (rays.cutLevels || !stated.levels.empty())
        plan.choices.push_back(
            fmt::format("levels {}{}", rays.cutLevels ? "cut: colours are whole levels, cut after each ray" : "exact", by(stated.levels)));
}

// By the resolve pass itself: a mean of equal samples rounds, and a transparent pixel without a covered sample is black.
void findUndrawn(bool transparent, Prepared& p) {
    p.undrawn = p.background;
    p.undrawnLinear = p.backgroundLinear;
    if (p.side == 1) return;
    const size_t samples = size_t(p.side) * p.side;
    std::vector<float> linear;
    for (size_t i = 0; i < samples; ++i) linear.insert(linear.end(), &p.backgroundLinear.x, &p.backgroundLinear.x + 3);
    const std::vector<int> z(samples, 0);
    resolveCpu(1, 1, p.side, transparent, p.choices.encoding, linear, z, std::span(&p.undrawnLinear.x, 3), std::span(&p.undrawn, 1), 1);
}

}  // namespace

Prepared prepare(const Scene& scene, const RenderRequest& request, RunsOn side) {
    const PlainFloats plain;
    PLUMB_ASSERT(scene.camera.has_value());
    Prepared p;
    p.width = request.width;
    p.height = request.height;
    p.side = request.samples == 16 ? 4 : request.samples == 4 ? 2 : 1;
    if (request.samples != 1 && request.samples != 4 && request.samples != 16) throw usageError("--samples takes 1, 4 or 16");
    if (p.width == 0 || p.height == 0) throw usageError("--size: a picture needs at least 1x1 pixels");
    const double width = double(p.width) * p.side, height = double(p.height) * p.side;
    const double guard = 2.0 * gpu::kGuardPixels;
    if ((width + guard) * (height + guard) >= 0x1p31 || width > 65536 || height > 65536)
        throw usageError(
            fmt::format("--size: {}x{} with {} samples a pixel is beyond the exact grid: (width + 16384) (height + "
                        "16384) must stay below 2^31, each side at most 65536 samples",
                        p.width, p.height, request.samples));
    const Pinhole view = pinholeOf(*scene.camera, width, height, p.side);
    DrawList& list = p.list;
    list.viewport = {float(width / 2), float(height / 2), float(width / 2) + gpu::kGuardPixels, float(height / 2) + gpu::kGuardPixels,
                     float(view.near * view.unit)};
    p.unit = view.unit;
    p.near = float(view.near);
    list.frame = {int(width), int(height), 0, int(height)};
    list.cullBackFaces = scene.cullBackFaces ? 1 : 0;
    list.rayOrigin = glm::vec3(view.forward - view.right * (width / 2 / view.focal) - view.down * (height / 2 / view.focal));
    list.rayX = glm::vec3(view.right / view.focal);
    list.rayY = glm::vec3(view.down / view.focal);
    p.rayOrigin = list.rayOrigin;
    p.rayX = list.rayX;
    p.rayY = list.rayY;
    const Trade& trade = request.trade;
    list.viewport.droppedBits = trade.subpixelBits == 4 ? 4 : 0;
    // Rays have no transform, and --fill notes projects on the host.
    if (request.shading != Shading::ray && request.fill == Fill::exact) list.numbers = trade.numbers;
    p.choices.affine = trade.affine;
    p.choices.depthBits = trade.depthBits;
    if (trade.vectors == Trade::Vectors::scene) {
        list.rayOrigin = glm::vec3(view.forward);
        list.rayX = list.rayY = glm::vec3(0);
    }
    if (request.distantViewer) list.towardViewer = glm::vec3(-view.forward);
    std::vector<uint32_t> materialSlot(scene.materials.size(), kNone);
    p.counters.objects = scene.objects.size();
    const bool rays = request.shading == Shading::ray;
    const bool discs = drawsSpheres(scene, request);
    if (!scene.zBuffer && (request.fill != Fill::notes || request.shading == Shading::wire || discs))
        throw inputError(scene.zBufferPlace.empty() ? printablePath(scene.path) : scene.zBufferPlace,
                         "z_buffer = false is for the polygons of --fill notes; every other picture needs one");
    if (discs) checkSpheres(scene, request);
    if (onlyRaysDraw(scene) && !rays && !discs)
        throw inputError(firstShapePlace(scene), "it has spheres or planes, which only --shading ray draws, spheres --fill notes too");
    for (uint32_t i = 0; discs && i < scene.spheres.size(); ++i)
        list.sphereMaterial.push_back(slotOfMaterial(list, scene, scene.spheres[i].material, materialSlot, false));
    if (rays) checkRays(request);
    if (const std::string asked = leftToRays(scene, request); !asked.empty())
        p.plan.dropped.push_back({"reflection and refraction", asked + "; only --shading ray traces them"});
    for (uint32_t i = 0; !rays && i < scene.objects.size(); ++i) {
        const Object& object = scene.objects[i];
        const TriangleMesh& mesh = scene.meshes[object.mesh];
        p.counters.vertices += mesh.positions.size();
        p.counters.triangles += mesh.triangles.size();
        if (!request.keepEverything && outsideView(mesh, worldFromMesh(scene, object), view)) {
            p.plan.dropped.push_back({fmt::format("object {}", object.name.empty() ? std::to_string(i) : object.name), "outside the view"});
            continue;
        }
        appendObject(list, scene, i, view, materialSlot, request);
    }
    p.counters.objectsDrawn = list.ranges.size();
    if (list.materials.empty()) list.materials.push_back({});
    planLights(scene, request, view, p);
    const bool atPixels = p.choices.shading == gpu::kShadingPhong && request.fill == Fill::exact && !rays;
    p.choices.unitNormals = trade.unitNormals || !atPixels;
    p.choices.coarse = trade.coarse && atPixels;
    using Vectors = Trade::Vectors;
    if (atPixels && (trade.vectors == Vectors::face || trade.vectors == Vectors::vertex)) {
        const char* which = trade.vectors == Vectors::face ? "face" : "vertex";
        if (trade.coarse) throw usageError(fmt::format("light-vector={} shades every pixel: leave rate=1/2 out", which));
        if (trade.native())
            throw usageError(fmt::format(
                "light-vector={} takes none of the device's own functions: leave specular=native and encode=native out", which));
        if (!list.lights.empty() && (p.choices.parts.diffuse || p.choices.parts.specular))
            p.choices.vectors = trade.vectors == Vectors::face ? gpu::kVectorsFace : gpu::kVectorsVertex;
    }
    const float background[3] = {request.background.x, request.background.y, request.background.z};
    p.backgroundLinear = request.background;
    p.background = encodePixelCpu(p.choices.encoding, background, request.transparent ? 0 : 255);
    findUndrawn(request.transparent, p);
    Plan& plan = p.plan;
    if (!request.shadingReason.empty()) plan.choices.push_back(request.shadingReason);
    planSteps(scene, request, side, p);
    const bool raster = !rays && !discs && request.shading != Shading::wire && request.fill == Fill::exact;
    if (raster && p.choices.shading != gpu::kShadingPhong) plan.dropped.push_back({"normals", "no pixel is shaded by its normal"});
    if (request.shading == Shading::wire) {
        if (request.wire == WireView::solid)
            plan.choices.push_back("wire: hidden lines are removed by the filled picture's depth and faces, polygon by polygon");
        if (request.wire == WireView::culled) plan.choices.push_back("wire: edges of polygons that face the viewer");
        if (request.wirePerPolygon) plan.choices.push_back("edges: as often as polygons have them");
    } else if (rays) {
        planRays(request, plan);
    } else if (discs) {
        plan.choices.push_back(fmt::format("fill notes: spheres pixel by pixel in parallel projection, z {}",
                                           scene.wholeSphereHeights ? "rounded to whole numbers" : "not rounded"));
    } else if (request.fill == Fill::notes) {
        plan.choices.push_back(
            "fill notes: corners on whole pixels, both ends of a line painted, what is carried interpolated along edges and lines");
    }
    if (p.side > 1)
        plan.choices.push_back(fmt::format("{} samples a pixel: the frame is drawn at {}x{} and resolved in linear light", request.samples,
                                           uint32_t(width), uint32_t(height)));
    if (request.distantViewer) plan.choices.push_back("viewer: distant, one vector toward it for every point");
    if (trade.specular == Trade::Specular::schlick) plan.choices.push_back("specular: Schlick's quotient in place of the power");
    if (trade.vectors == Trade::Vectors::scene)
        plan.choices.push_back("light-vector: one direction to the eye and to each light for the whole scene");
    if (p.choices.vectors == gpu::kVectorsFace) plan.choices.push_back("light-vector: directions made once a face, at its centre");
    if (p.choices.vectors == gpu::kVectorsVertex)
        plan.choices.push_back("light-vector: directions made at the corners and interpolated, not made unit again");
    if ((trade.vectors == Vectors::face || trade.vectors == Vectors::vertex) && p.choices.vectors == gpu::kVectorsPixel)
        plan.choices.push_back("light-vector: no pixel is lit by a direction of its own; nothing changes");
    if (trade.affine) plan.choices.push_back("interpolation: affine");
    if (list.numbers == Numbers::blockInteger) plan.choices.push_back("transform: block-scaled integers, rounded to float32 once");
    if (list.numbers == Numbers::fp64) plan.choices.push_back("transform: binary64, rounded to float32 at its end");
    if (trade.specular == Trade::Specular::native) plan.choices.push_back("specular: the device's own power (bounded)");
    if (trade.nativeEncode && request.encoding == Encoding::srgb) plan.choices.push_back("encode: the device's own power (bounded)");
    if (!trade.unitNormals)
        plan.choices.push_back(p.choices.unitNormals ? "normals: as interpolated; no pixel is shaded by one"
                                                     : "normals: as interpolated, not made unit at pixels");
    if (trade.coarse) plan.choices.push_back(p.choices.coarse ? "rate: one pixel in 2x2 is shaded" : "rate: 1/2; no pixel is shaded");
    if (trade.depthBits == gpu::kDepthStandard)
        plan.choices.push_back("depth: 1 - n/w in float32");
    else if (trade.depthBits != 32)
        plan.choices.push_back(fmt::format("depth: fixed point of {} bits", trade.depthBits));
    if (trade.subpixelBits != 8) plan.choices.push_back(fmt::format("subpixel: {} bits", trade.subpixelBits));
    plan.choices.push_back(fmt::format("near plane at {}", view.near));
    return p;
}

bool drawsSpheres(const Scene& scene, const RenderRequest& request) {
    return request.fill == Fill::notes && request.shading != Shading::ray && !scene.spheres.empty() && scene.planes.empty();
}

bool onlyRaysDraw(const Scene& scene) { return !scene.spheres.empty() || !scene.planes.empty(); }

static std::string raysAskedByMaterials(const Scene& scene) {
    std::vector<bool> asks(scene.materials.size());
    for (size_t i = 0; i < asks.size(); ++i) asks[i] = asksForRays(scene.materials[i]);
    if (std::find(asks.begin(), asks.end(), true) == asks.end()) return {};
    const auto sentence = [](const Material& m) {
        const RayShares s = raySharesOf(m);
        return s.transmit > 0 ? fmt::format("material '{}' transmits {:g}", printable(m.name, 64), s.transmit)
                              : fmt::format("material '{}' reflects {:g}", printable(m.name, 64), s.reflect);
    };
    for (const Object& object : scene.objects)
        for (const uint32_t material : scene.meshes[object.mesh].faceMaterial)
            if (asks[material]) return sentence(scene.materials[material]);
    for (const SphereShape& sphere : scene.spheres)
        if (asks[sphere.material]) return sentence(scene.materials[sphere.material]);
    return {};
}

std::string raysAskedBy(const Scene& scene) {
    return onlyRaysDraw(scene) ? "the scene has spheres or planes, which only rays meet" : raysAskedByMaterials(scene);
}

std::string leftToRays(const Scene& scene, const RenderRequest& request) {
    if (request.shading == Shading::ray) return {};
    return drawsSpheres(scene, request) ? raysAskedByMaterials(scene) : raysAskedBy(scene);
}

Plan planRender(const Scene& scene, const RenderRequest& request, RunsOn side) { return prepare(scene, request, side).plan; }

}  // namespace plumb
