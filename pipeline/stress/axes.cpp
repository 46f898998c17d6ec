// SPDX-License-Identifier: MIT
#include "pipeline/stress/axes.h"

#include "host/error.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/camera.h"
#include "pipeline/scene/text.h"
#include "pipeline/stress/move.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>

namespace plumb::stress {
namespace {

constexpr double kPi = 3.14159265358979323846;
// What the format takes (docs/scene-format.md).
constexpr double kLargestCoordinate = kMaxCoordinate, kLeastFov = 0.01, kLargestFov = 179, kLeastNear = 1e-30, kLargestNear = 1e30;
constexpr double kMostShininess = 1e6, kMostDepth = 64;
// Weakest light: products of its intensity with two colours stay above the least normal float32.
constexpr double kWeakestLight = 0x1p-100;
// Relative spacing of binary64: a closer layer is the same layer.
constexpr double kLeastGap = 0x1p-52;
// Pictures larger than this take their truth more than a second.
constexpr double kMostPixels = 0x1p22, kMostTriangles = 0x1p21;
// Share of the focus distance that is rounding of the eye and the axis.
constexpr double kNoPlace = 0x1p-40;
// Field of view that no arithmetic minds.
constexpr double kMildFov = 45;
// Angle at which a face counts as seen when nothing is stretched.
constexpr double kSeenAngle = 45;

double radians(double degrees) { return degrees * kPi / 180; }
double powerOfTwoIn(double x) { return std::exp2(std::floor(std::log2(x))); }
glm::dvec3 signsOf(const glm::dvec3& v) { return {v.x < 0 ? -1 : 1, v.y < 0 ? -1 : 1, v.z < 0 ? -1 : 1}; }
const Camera& cameraOf(const Picture& p) { return *p.scene.camera; }

std::string never(const Picture&) { return ""; }

// --- meshes -----------------------------------------------------------------------------------------------------------------------------

glm::dvec3 middleOf(const TriangleMesh& mesh) { return mesh.statedMin * 0.5 + mesh.statedMax * 0.5; }
bool hasVertices(const TriangleMesh& mesh) { return mesh.shape == nullptr && !mesh.triangles.empty(); }

std::string withoutVertices(const Picture& p) {
    for (const TriangleMesh& mesh : p.scene.meshes)
        if (hasVertices(mesh)) return "";
    return "the scene has no mesh of its own vertices: shapes lie around their own 0";
}

double vertexOffset(const Picture& p) {
    double most = 0;
    for (const TriangleMesh& mesh : p.scene.meshes)
        if (hasVertices(mesh)) most = std::max(most, largestOf(middleOf(mesh)));
    return most;
}

double meshExtent(const Picture& p) {
    double most = 0;
    for (const TriangleMesh& mesh : p.scene.meshes)
        if (hasVertices(mesh)) most = std::max(most, largestOf(mesh.statedMax - mesh.statedMin));
    return most;
}

// The middle of each mesh's box comes to (x, x, x), each coordinate with the sign that it has; matrices bring the object back.
void offsetVertices(Picture& p, double value) {
    std::vector<glm::dvec3> by(p.scene.meshes.size(), glm::dvec3(0));
    for (size_t i = 0; i < by.size(); ++i) {
        TriangleMesh& mesh = p.scene.meshes[i];
        if (!hasVertices(mesh)) continue;
        const glm::dvec3 middle = middleOf(mesh), move = signsOf(middle) * value - middle;
        by[i] = move;
        restate(mesh, [&move](const glm::dvec3& v) { return v + move; });
    }
    for (Object& object : p.scene.objects) {
        glm::dmat4& m = object.worldFromObject;
        const glm::dvec3& o = by[object.mesh];
        m[3] -= m[0] * o.x + m[1] * o.y + m[2] * o.z;
    }
}

// Vertices lie at x as above, and a face without area at -x: no origin serves both.
void spreadVertices(Picture& p, double value) {
    offsetVertices(p, value);
    for (TriangleMesh& mesh : p.scene.meshes)
        if (hasVertices(mesh)) addFarFace(mesh, signsOf(middleOf(mesh)) * -value);
}

double trianglesOf(const Picture& p) {
    double count = 0;
    for (const TriangleMesh& mesh : p.scene.meshes)
        if (hasVertices(mesh)) count += double(mesh.triangles.size());
    return count;
}

std::string withoutFaces(const Picture& p) {
    const std::string why = withoutVertices(p);
    return why.empty() ? "" : "the scene has no mesh of its own faces";
}

void makeDense(Picture& p, double value) {
    for (TriangleMesh& mesh : p.scene.meshes)
        if (hasVertices(mesh)) mesh = cutFaces(mesh, uint32_t(value));
}

std::string unstretched(const Picture& p) {
    if (!p.scene.spheres.empty() || !p.scene.planes.empty()) return "spheres and planes cannot be stretched";
    return p.scene.objects.empty() ? "the scene has no object" : "";
}

// --- places -----------------------------------------------------------------------------------------------------------------------------

// Distance of the point that the camera looks at from 0; 0 where rounding alone keeps it from there.
double placeOf(const Picture& p) {
    const double place = largestOf(centreOf(cameraOf(p)));
    return place < kNoPlace * cameraOf(p).focusDistance ? 0 : place;
}

void moveAway(Picture& p, double value) {
    const glm::dvec3 centre = centreOf(cameraOf(p));
    translate(p.scene, signsOf(centre) * value - centre);
}

double fovOf(const Picture& p) {
    const double half = p.request.height / 2.0;
    return 2 * std::atan(half / focalOf(cameraOf(p), p.request.height)) * 180 / kPi;
}

void setFov(Picture& p, double degrees) {
    Camera& camera = *p.scene.camera;
    if (camera.focalPixels > 0)
        camera.focalPixels = p.request.height / 2.0 / std::tan(radians(degrees / 2));
    else
        camera.fovYDegrees = degrees;
}

// Distance at which the framed centre is seen as large as now by a field of view.
double distanceFor(const Picture& p, double degrees) {
    return cameraOf(p).focusDistance * std::tan(radians(fovOf(p) / 2)) / std::tan(radians(degrees / 2));
}

void backAway(Picture& p, double value) {
    const double now = cameraOf(p).focusDistance, degrees = 2 * std::atan(std::tan(radians(fovOf(p) / 2)) * now / value) * 180 / kPi;
    setFov(p, degrees);
    Camera& camera = *p.scene.camera;
    camera.eye += camera.forward * (now - value);
    camera.focusDistance = value;
}

// Depths are stretched by `factor` and the field of view narrowed alike: each vertex stays where it is on the screen, and faces are seen at
// flatter angles.
void flatten(Picture& p, double value) {
    const double factor = std::tan(radians(kSeenAngle)) / std::tan(radians(value));
    setFov(p, 2 * std::atan(std::tan(radians(fovOf(p) / 2)) / factor) * 180 / kPi);
    stretch(p.scene, factor);
}

double flattestAngle(const Picture& p) {
    const double factor = std::tan(radians(fovOf(p) / 2)) / std::tan(radians(kLeastFov / 2));
    return std::atan(std::tan(radians(kSeenAngle)) / factor) * 180 / kPi;
}

std::string withoutNear(const Picture& p) { return isTraced(p.request) ? "rays start at the eye, and no near plane cuts them" : ""; }

// --- surfaces and lights ----------------------------------------------------------------------------------------------------------------

std::vector<bool> usedMaterials(const Scene& scene) {
    std::vector<bool> used(scene.materials.size(), false);
    for (const Object& object : scene.objects)
        for (const uint32_t m : scene.meshes[object.mesh].faceMaterial) used[m] = true;
    for (const SphereShape& sphere : scene.spheres) used[sphere.material] = true;
    for (const PlaneShape& plane : scene.planes)
        used[plane.material] = used[plane.square > 0 ? plane.otherMaterial : plane.material] = true;
    return used;
}

bool shines(const Material& m) { return m.shininess > 0 && m.specular != glm::vec3(0); }

double largestExponent(const Picture& p) {
    const std::vector<bool> used = usedMaterials(p.scene);
    double most = 0;
    for (size_t i = 0; i < used.size(); ++i)
        if (used[i] && shines(p.scene.materials[i])) most = std::max(most, double(p.scene.materials[i].shininess));
    return most;
}

std::string withoutHighlight(const Picture& p) {
    if (p.scene.lights.empty()) return "the scene has no light";
    return largestExponent(p) > 0 ? "" : "no material has a highlight: Ks or Ns is 0";
}

void sharpen(Picture& p, double value) {
    const double factor = value / largestExponent(p);
    for (Material& m : p.scene.materials)
        if (shines(m)) m.shininess = float(std::min(m.shininess * factor, kMostShininess));
}

double nearestLight(const Picture& p) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Light& light : p.scene.lights)
        if (!light.directional) nearest = std::min(nearest, glm::length(light.position - centreOf(cameraOf(p))));
    return nearest;
}

std::string withoutPointLight(const Picture& p) {
    const double nearest = nearestLight(p);
    return nearest == 0             ? "a light stands at the point that the camera looks at"
           : std::isfinite(nearest) ? ""
                                    : "the scene has no point light";
}

double strongestLight(const Picture& p) {
    double most = 0;
    for (const Light& light : p.scene.lights)
        most = std::max({most, double(light.intensity.x), double(light.intensity.y), double(light.intensity.z)});
    return most;
}

std::string withoutLight(const Picture& p) { return strongestLight(p) > 0 ? "" : "the scene has no light"; }

void strengthen(Picture& p, double value) {
    const double factor = value / strongestLight(p);
    for (Light& light : p.scene.lights) light.intensity = glm::vec3(glm::dvec3(light.intensity) * factor);
}

// --- pictures ---------------------------------------------------------------------------------------------------------------------------

void resize(Picture& p, double value) {
    const double factor = value / p.request.width;
    p.request.width = uint32_t(value);
    p.request.height = std::max(1u, uint32_t(std::lround(p.request.height * factor)));
    p.scene.camera->focalPixels *= factor;
}

std::string withoutDepth(const Picture& p) {
    if (!isTraced(p.request)) return "no ray is followed: the picture is not traced";
    const std::vector<bool> used = usedMaterials(p.scene);
    for (size_t i = 0; i < used.size(); ++i)
        if (used[i] && (p.scene.materials[i].reflect > 0 || p.scene.materials[i].transmit > 0)) return "";
    return "no material mirrors or refracts, so that rays end where they hit";
}

// --- the table --------------------------------------------------------------------------------------------------------------------------

constexpr const char* kCoordinateWhy = "the largest coordinate that the format takes";

const std::vector<AxisRow> kRows = {
    {"vertices", "offset of vertices", "", true, false, withoutVertices,
     [](const Picture& p) -> std::optional<double> { return vertexOffset(p); },
     [](const Picture& p) { return std::max(powerOfTwoIn(meshExtent(p)), vertexOffset(p)); },
     [](const Picture&) -> Reach {
         return {kLargestCoordinate, kCoordinateWhy};
     },
     [](const Picture&) { return 0.0; }, offsetVertices},
    {"extent", "extent of a mesh from its middle", "", true, false, withoutVertices,
     [](const Picture& p) -> std::optional<double> { return meshExtent(p) / 2; },
     [](const Picture& p) { return powerOfTwoIn(meshExtent(p)); },
     [](const Picture&) -> Reach {
         return {kLargestCoordinate, kCoordinateWhy};
     },
     nullptr, spreadVertices},
    {"place", "offset of scene and camera", "", true, false, never, [](const Picture& p) -> std::optional<double> { return placeOf(p); },
     [](const Picture& p) { return std::max(powerOfTwoIn(cameraOf(p).focusDistance), placeOf(p)); },
     [](const Picture&) -> Reach {
         return {kLargestCoordinate, kCoordinateWhy};
     },
     [](const Picture&) { return 0.0; }, moveAway},
    {"apart", "distance of scene and camera", "", true, false, never,
     [](const Picture& p) -> std::optional<double> { return cameraOf(p).focusDistance; },
     [](const Picture& p) { return cameraOf(p).focusDistance; },
     [](const Picture& p) -> Reach {
         return {distanceFor(p, kLeastFov), "where the field of view is the least that the format takes"};
     },
     [](const Picture& p) { return distanceFor(p, kMildFov); }, backAway},
    {"size", "size, growing", "times", true, false, never, [](const Picture&) -> std::optional<double> { return 1; },
     [](const Picture&) { return 1.0; },
     [](const Picture&) -> Reach {
         return {kLargestCoordinate, kCoordinateWhy};
     },
     nullptr, [](Picture& p, double value) { enlarge(p.scene, value); }},
    {"size", "size, shrinking", "times", false, false, never, [](const Picture&) -> std::optional<double> { return 1; },
     [](const Picture&) { return 1.0; },
     [](const Picture&) -> Reach {
         return {1 / kLargestCoordinate, "the inverse of the largest coordinate"};
     },
     nullptr, [](Picture& p, double value) { enlarge(p.scene, value); }},
    {"fov", "field of view, narrowing", "degrees", false, false, never, [](const Picture& p) -> std::optional<double> { return fovOf(p); },
     fovOf,
     [](const Picture&) -> Reach {
         return {kLeastFov, "the least that the format takes"};
     },
     [](const Picture&) { return kMildFov; }, setFov},
    {"fov", "field of view, widening", "degrees", true, false, never, [](const Picture& p) -> std::optional<double> { return fovOf(p); },
     fovOf,
     [](const Picture&) -> Reach {
         return {kLargestFov, "the largest that the format takes"};
     },
     [](const Picture&) { return kMildFov; }, setFov},
    {"near", "near plane, to the eye", "", false, false, withoutNear,
     [](const Picture& p) -> std::optional<double> { return nearOf(cameraOf(p)); }, [](const Picture& p) { return nearOf(cameraOf(p)); },
     [](const Picture&) -> Reach {
         return {kLeastNear, "the least that the format takes"};
     },
     [](const Picture& p) { return nearestDepth(p.scene); }, [](Picture& p, double value) { p.scene.camera->near = value; }},
    {"near", "near plane, to the scene", "", true, false, withoutNear,
     [](const Picture& p) -> std::optional<double> { return nearOf(cameraOf(p)); }, [](const Picture& p) { return nearOf(cameraOf(p)); },
     [](const Picture&) -> Reach {
         return {kLargestNear, "the largest that the format takes"};
     },
     [](const Picture&) { return kLeastNear; }, [](Picture& p, double value) { p.scene.camera->near = value; }},
    {"gap", "gap of two layers", "of the distance", false, false, never,
     [](const Picture&) -> std::optional<double> { return std::nullopt; }, [](const Picture&) { return 1.0; },
     [](const Picture&) -> Reach {
         return {kLeastGap, "the spacing of binary64"};
     },
     nullptr, [](Picture& p, double value) { addLayer(p.scene, value); }},
    {"grazing", "grazing angle", "degrees", false, false, unstretched, [](const Picture&) -> std::optional<double> { return kSeenAngle; },
     [](const Picture&) { return kSeenAngle; },
     [](const Picture& p) -> Reach {
         return {flattestAngle(p), "where the field of view is the least that the format takes"};
     },
     nullptr, flatten},
    {"exponent", "exponent of the highlight", "", true, false, withoutHighlight,
     [](const Picture& p) -> std::optional<double> { return largestExponent(p); }, largestExponent,
     [](const Picture&) -> Reach {
         return {kMostShininess, "the largest that the format takes"};
     },
     [](const Picture&) { return 1.0; }, sharpen},
    {"light-distance", "distance of lights, growing", "", true, false, withoutPointLight,
     [](const Picture& p) -> std::optional<double> { return nearestLight(p); }, nearestLight,
     [](const Picture&) -> Reach {
         return {kLargestCoordinate, kCoordinateWhy};
     },
     [](const Picture& p) { return cameraOf(p).focusDistance; },
     [](Picture& p, double value) { moveLights(p.scene, centreOf(cameraOf(p)), value / nearestLight(p)); }},
    {"light-distance", "distance of lights, shrinking", "", false, false, withoutPointLight,
     [](const Picture& p) -> std::optional<double> { return nearestLight(p); }, nearestLight,
     [](const Picture& p) -> Reach {
         return {cameraOf(p).focusDistance * kLeastGap, "the spacing of binary64"};
     },
     [](const Picture& p) { return cameraOf(p).focusDistance; },
     [](Picture& p, double value) { moveLights(p.scene, centreOf(cameraOf(p)), value / nearestLight(p)); }},
    {"light-strength", "strength of lights, rising", "", true, false, withoutLight,
     [](const Picture& p) -> std::optional<double> { return strongestLight(p); }, strongestLight,
     [](const Picture&) -> Reach {
         return {kLargestCoordinate, "the largest that the format takes"};
     },
     [](const Picture&) { return 1.0; }, strengthen},
    {"light-strength", "strength of lights, falling", "", false, false, withoutLight,
     [](const Picture& p) -> std::optional<double> { return strongestLight(p); }, strongestLight,
     [](const Picture&) -> Reach {
         return {kWeakestLight, "far below a step of the picture"};
     },
     [](const Picture&) { return 1.0; }, strengthen},
    {"resolution", "width of the picture", "pixels", true, true, never,
     [](const Picture& p) -> std::optional<double> { return p.request.width; }, [](const Picture& p) { return double(p.request.width); },
     [](const Picture& p) -> Reach {
         return {std::floor(p.request.width * std::sqrt(kMostPixels / (double(p.request.width) * p.request.height * p.request.samples))),
                 "the most that is tried"};
     },
     nullptr, resize},
    {"density", "mesh density", "parts of an edge", true, true, withoutFaces, [](const Picture&) -> std::optional<double> { return 1; },
     [](const Picture&) { return 1.0; },
     [](const Picture& p) -> Reach {
         return {std::max(1.0, std::floor(std::sqrt(kMostTriangles / trianglesOf(p)))), "the most that is tried"};
     },
     nullptr, makeDense},
    {"depth", "depth of rays, falling", "rays", false, true, withoutDepth,
     [](const Picture& p) -> std::optional<double> { return p.request.maxDepth; },
     [](const Picture& p) { return double(p.request.maxDepth); },
     [](const Picture&) -> Reach {
         return {1, "the least that the format takes"};
     },
     [](const Picture&) { return kMostDepth; }, [](Picture& p, double value) { p.request.maxDepth = uint32_t(value); }},
    {"depth", "depth of rays, rising", "rays", true, true, withoutDepth,
     [](const Picture& p) -> std::optional<double> { return p.request.maxDepth; },
     [](const Picture& p) { return double(p.request.maxDepth); },
     [](const Picture&) -> Reach {
         return {kMostDepth, "the most that the format takes"};
     },
     nullptr, [](Picture& p, double value) { p.request.maxDepth = uint32_t(value); }},
};

}  // namespace

std::span<const AxisRow> axisRows() { return kRows; }

std::vector<const AxisRow*> rowsOf(const std::vector<std::string>& names) {
    std::vector<std::string> known;
    for (const AxisRow& row : kRows)
        if (known.empty() || known.back() != row.name) known.emplace_back(row.name);
    for (const std::string& name : names)
        if (std::find(known.begin(), known.end(), name) == known.end())
            throw usageError(fmt::format("--axis: '{}' is refused; accepted: {}", printable(name), fmt::join(known, ", ")));
    std::vector<const AxisRow*> rows;
    for (const AxisRow& row : kRows)
        if (names.empty() || std::find(names.begin(), names.end(), row.name) != names.end()) rows.push_back(&row);
    return rows;
}

}  // namespace plumb::stress
