// SPDX-License-Identifier: MIT
// Camera and lights for scenes that state none.
#include "pipeline/scene/load.h"
#include "pipeline/scene/plain_floats.h"
#include "pipeline/scene/text.h"
#include "pipeline/transform/degrees.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumb {
namespace {

// Field of view along the shorter side: a 38 mm lens on film 24 mm high. Mild perspective, parallels still converge.
constexpr double kFovShorterDegrees = 35;

// Share of the shorter side that the larger of the object's two extents covers. It is inside the promised 35 to 80 %. A line or a covered
// sample exceeds the projection by half a pixel, so it stays below 80.
constexpr double kCoverShorter = 0.72;

// Least distance of the object from the eye, as a share of the object's radius, so that near planes of 2^-10 of the focus distance never
// cut the object. It matters only for needles seen end on.
constexpr double kLeastClearance = 0.1;

// Three-quarter view: from the right and above, as product photographs are taken.
constexpr double kAzimuthDegrees = 30, kElevationDegrees = 20;

// Directions of a bare mesh's lights, in the camera's axes (right, up, toward the eye). Key light: from above and a little from the left,
// 54 degrees off the view. Fill light: from the lower right, 30 degrees off. The direction to the eye lies between the two, in their plane.
// So every surface that faces the eye faces at least one of them: nothing visible is black for want of light. In the three-quarter view the
// top, front and right side of a box get 0.37, 0.27 and 0.08: three distinct greys.
constexpr glm::dvec3 kKeyDirection{-0.45, 0.85, 0.7}, kFillDirection{0.27, -0.51, 1.0};

// Intensities (linear). With Ka = Kd = Ks = 1 and Ns >= 1 no normal that faces the eye gets more than 0.99, which encodes to less than 255
// (a unit test sweeps them). The default material's brightest point is 0.37, sRGB 163.
constexpr float kKeyIntensity = 0.42f, kFillIntensity = 0.11f, kAmbientIntensity = 0.1f;

struct Axes {
    glm::dvec3 right, up, back;  // back: from the framed centre toward the eye
};

// Front of a mesh: +Z when +Y is up. For another up direction, +Z after the smallest rotation that takes +Y there. So -Y is the front when
// +Z is up, as CAD programs have it. In a left-handed world the front is -Z: the notes' viewer at (0, 0, -d).
Axes frontAxes(const Scene& scene) {
    const double length = glm::length(scene.up);
    const glm::dvec3 u = length > 0 ? scene.up / length : glm::dvec3(0, 1, 0);
    glm::dvec3 right(1, 0, 0), back(0, 0, 1);
    if (u.y > -1 + 1e-12) {
        // Rodrigues' formula for the rotation from +Y to u, applied to X and Z.
        const double k = 1 / (1 + u.y);
        right = {1 - k * u.x * u.x, -u.x, -k * u.x * u.z};
        back = {-k * u.x * u.z, -u.z, 1 - k * u.z * u.z};
    } else {
        back = {0, 0, -1};
    }
    return {right, u, scene.leftHanded ? -back : back};
}

struct Angles {
    double azimuth, elevation;  // degrees; azimuth toward the right of the front
};

Angles anglesOfView(const std::string& view) {
    static const std::pair<const char*, Angles> kNamed[] = {
        {"", {kAzimuthDegrees, kElevationDegrees}},
        {"front", {0, 0}},
        {"right", {90, 0}},
        {"back", {180, 0}},
        {"left", {270, 0}},
        {"top", {0, 90}},
        {"bottom", {0, -90}},
        {"iso", {45, 35.264389682754654}},  // arctan(1/sqrt 2): a cube's diagonal
    };
    for (const auto& [name, angles] : kNamed)
        if (view == name) return angles;
    const size_t comma = view.find(',');
    float azimuth = 0, elevation = 0;
    if (comma == std::string::npos || !parseFloat(std::string_view(view).substr(0, comma), azimuth) ||
        !parseFloat(std::string_view(view).substr(comma + 1), elevation) || !std::isfinite(azimuth) || !(std::abs(elevation) <= 90))
        throw usageError(
            fmt::format("view '{}' is not front, back, left, right, top, bottom, iso, or AZIMUTH,ELEVATION in degrees "
                        "(elevation from -90 to 90)",
                        printable(view, 40)));
    return {azimuth, elevation};
}

}  // namespace

Camera frameCamera(const Scene& scene, double aspect, const std::string& view) {
    const Angles angles = anglesOfView(view);
    const Axes front = frontAxes(scene);
    const SineCosine azimuth = sineCosineOfDegrees(angles.azimuth), elevation = sineCosineOfDegrees(angles.elevation);
    const glm::dvec3 level = azimuth.cosine * front.back + azimuth.sine * front.right;
    const glm::dvec3 back = glm::normalize(elevation.cosine * level + elevation.sine * front.up);
    const glm::dvec3 up = glm::normalize(elevation.cosine * front.up - elevation.sine * level);

    Camera camera;
    camera.forward = -back;
    camera.up = up;
    camera.right = scene.leftHanded ? glm::cross(up, -back) : glm::cross(-back, up);
    const SineCosine half = sineCosineOfDegrees(kFovShorterDegrees / 2);
    const double shorter = half.sine / half.cosine;
    camera.fovYDegrees = aspect >= 1 ? kFovShorterDegrees : glm::degrees(2 * std::atan(shorter / aspect));

    // Eye for which all points are inside the square of slope t about its axis. For an eye at (ex, ey, ez) a point (x, y, z) in camera axes
    // is inside when |x - ex| <= t (z - ez) and |y - ey| <= t (z - ez). Each of the four is a bound on ex - t ez or ex + t ez, so the
    // extremes below give the nearest such eye. The extent that decides is met on both sides.
    const double t = kCoverShorter * shorter;
    constexpr double kFar = std::numeric_limits<double>::infinity();
    glm::dvec2 lowest(-kFar), highest(kFar);
    glm::dvec3 least(kFar), most(-kFar);
    const auto include = [&](const glm::dvec3& world) {
        const glm::dvec3 p(glm::dot(world, camera.right), glm::dot(world, camera.up), glm::dot(world, camera.forward));
        lowest = glm::max(lowest, glm::dvec2(p) - t * p.z);
        highest = glm::min(highest, glm::dvec2(p) + t * p.z);
        least = glm::min(least, p);
        most = glm::max(most, p);
    };
    for (const Object& object : scene.objects) {
        const glm::dmat4 toWorld = worldFromMesh(scene, object);
        for (const glm::vec3& position : scene.meshes[object.mesh].positions) include(glm::dvec3(toWorld * glm::dvec4(position, 1)));
    }
    // Box of a sphere. Planes have no end to frame.
    for (const SphereShape& sphere : scene.spheres)
        for (int i = 0; i < 8; ++i) include(sphere.centre + sphere.radius * glm::dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    if (!(least.x <= most.x)) least = most = glm::dvec3(0), lowest = highest = glm::dvec2(0);  // nothing to frame

    const double radius = glm::length(most - least) / 2;
    const double clearance = radius > 0 ? kLeastClearance * radius : 1.0;
    glm::dvec3 eye((lowest + highest) / 2.0, 0);
    eye.z = std::min({(highest.x - lowest.x) / (2 * t), (highest.y - lowest.y) / (2 * t), least.z - clearance});
    camera.eye = camera.right * eye.x + camera.up * eye.y + camera.forward * eye.z;
    camera.focusDistance = (least.z + most.z) / 2 - eye.z;
    return camera;
}

std::vector<Light> defaultLights(const Scene&, const Camera& camera) {
    const auto directional = [&](const glm::dvec3& d, float intensity) {
        Light light;
        light.direction = glm::normalize(camera.right * d.x + camera.up * d.y - camera.forward * d.z);
        light.intensity = glm::vec3(intensity);
        return light;
    };
    return {directional(kKeyDirection, kKeyIntensity), directional(kFillDirection, kFillIntensity)};
}

void completeScene(Scene& scene, glm::uvec2 size, const std::string& view, bool bareMesh) {
    const PlainFloats plain;
    PLUMB_ASSERT(size.x > 0 && size.y > 0);
    if (!scene.camera || !view.empty()) scene.camera = frameCamera(scene, double(size.x) / size.y, view);
    if (bareMesh && scene.lights.empty()) {
        scene.lights = defaultLights(scene, *scene.camera);
        scene.ambient = glm::vec3(kAmbientIntensity);
    }
}

}  // namespace plumb
