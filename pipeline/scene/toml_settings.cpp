// SPDX-License-Identifier: MIT
// Settings of the whole scene, choices for rays, the camera.
#include "pipeline/scene/toml_scene.h"

#include "pipeline/scene/affine.h"

#include <fmt/format.h>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <utility>

namespace plumb::scene_file {

using glm::dvec3;

namespace {

constexpr uint32_t kMaxImageSide = 65536;
constexpr int64_t kMaxRayDepth = 64;  // counters of rays are kept for each depth
constexpr double kMostJitter = 0.5;   // share of a unit vector: no disturbed one is near 0

}  // namespace

void SceneFile::readSettings(const toml::table& root) {
    if (const auto* node = root.get("handedness"))
        scene_.leftHanded = choiceOf<bool>(*node, "handedness", {{"right", false}, {"left", true}});
    if (const auto* node = root.get("up")) scene_.up = unitVector(axisOf(*node, "up"));
    if (const auto* node = root.get("ambient")) scene_.ambient = colourOf(*node, "ambient", kMaxCoordinate);
    if (const auto* node = root.get("background")) scene_.background = colourOf(*node, "background", 1);
    if (const auto* node = root.get("encoding")) scene_.encoding = chosenOf(*node, "encoding", kEncodings);
    if (const auto* node = root.get("shading")) scene_.shading = chosenOf(*node, "shading", kShadings);
    if (const auto* node = root.get("max_depth")) scene_.maxDepth = uint32_t(integerOf(*node, "max_depth", 1, kMaxRayDepth));
    if (const auto* node = root.get("min_weight")) scene_.minWeight = numberOf(*node, "min_weight", 0, 1);
    readRays(root);
    if (const auto* node = root.get("shadows")) scene_.shadows = booleanOf(*node, "shadows");
    if (const auto* node = root.get("fill")) scene_.fill = chosenOf(*node, "fill", kFills), scene_.fillLocation = location(*node);
    if (const auto* node = root.get("wire")) scene_.wire = chosenOf(*node, "wire", kWireViews);
    if (const auto* node = root.get("edges")) scene_.wirePerPolygon = chosenOf(*node, "edges", kEdgeCounts);
    if (const auto* node = root.get("viewer"))
        scene_.distantViewer = chosenOf(*node, "viewer", kViewers), scene_.viewerLocation = location(*node);
    if (const auto* node = root.get("z_buffer")) scene_.zBuffer = booleanOf(*node, "z_buffer"), scene_.zBufferLocation = location(*node);
    if (const auto* node = root.get("sphere_heights"))
        scene_.wholeSphereHeights = choiceOf<bool>(*node, "sphere_heights", {{"exact", false}, {"whole", true}});
    if (const auto* node = root.get("cull")) scene_.cullBackFaces = booleanOf(*node, "cull");
    if (const auto* node = root.get("size")) {
        const toml::array& size = arrayOf(*node, "size");
        if (size.size() != 2) refuse(*node, fmt::format("size has {} numbers, not 2", size.size()));
        scene_.size = {uint32_t(integerOf(size[0], "size[0]", 1, kMaxImageSide)),
                       uint32_t(integerOf(size[1], "size[1]", 1, kMaxImageSide))};
    }
}

// Reads where rays pass through a pixel, their noise, and whole levels.
void SceneFile::readRays(const toml::table& root) {
    if (const auto* node = root.get("sampling")) scene_.sampling = chosenOf(*node, "sampling", kSamplings);
    if (const auto* node = root.get("jitter")) {
        const toml::table& jitter = tableOf(*node, "jitter");
        allowKeys(jitter, "jitter", {"reflect", "refract", "shadow"});
        if (jitter.empty()) refuse(*node, "jitter holds nothing; write { reflect = X, refract = X, shadow = X }, each optional");
        for (const auto& [key, amount] : {std::pair("reflect", &scene_.jitterReflect), std::pair("refract", &scene_.jitterRefract),
                                          std::pair("shadow", &scene_.jitterShadow)})
            if (const auto* value = jitter.get(key)) *amount = numberOf(*value, std::string("jitter.") + key, 0, kMostJitter);
    }
    if (const auto* node = root.get("seed")) scene_.seed = uint32_t(integerOf(*node, "seed", 0, 0xffffffff));
    if (const auto* node = root.get("levels")) {
        scene_.cutLevels = chosenOf(*node, "levels", kLevelForms);
        if (*scene_.cutLevels && scene_.encoding != Encoding::linear)
            refuse(*node, "levels = \"cut\" counts bytes as light: it goes with encoding = \"linear\"");
    }
}

void SceneFile::readCamera(const toml::table& table) {
    allowKeys(table, "[camera]", {"distance", "eye", "at", "up", "fov", "near"});
    Camera camera;
    if (const auto* distance = table.get("distance")) {
        for (const char* key : {"eye", "at", "up", "fov"})
            if (const auto* other = table.get(key))
                refuse(*other, fmt::format("camera.{} beside camera.distance: the notes' viewer is fixed", key));
        if (!scene_.leftHanded) refuse(*distance, "camera.distance is the notes' viewer; it needs handedness = \"left\"");
        const double d = numberOf(*distance, "camera.distance", 0, kMaxCoordinate);
        if (d == 0) refuse(*distance, "camera.distance is 0");
        camera.eye = {0, 0, -d};
        camera.right = {1, 0, 0};
        camera.up = {0, 1, 0};
        camera.forward = {0, 0, 1};
        camera.focalPixels = d;
        camera.focusDistance = d;
    } else {
        camera.eye = vectorOf(required(table, "eye", "camera"), "camera.eye");
        const toml::node& at = required(table, "at", "camera");
        const dvec3 toward = vectorOf(at, "camera.at") - camera.eye;
        if (largestMagnitude(toward) == 0) refuse(at, "camera.at is the same point as camera.eye");
        const auto* upNode = table.get("up");
        const dvec3 up = upNode ? unitVector(axisOf(*upNode, "camera.up")) : scene_.up;
        camera.forward = unitVector(toward);
        const dvec3 right = scene_.leftHanded ? glm::cross(up, camera.forward) : glm::cross(camera.forward, up);
        if (largestMagnitude(right) < kMinCross)
            refuse(upNode ? *upNode : at,
                   fmt::format("camera.up is parallel to the view direction{}", upNode ? "" : "; state another camera.up"));
        camera.right = unitVector(right);
        camera.up = scene_.leftHanded ? glm::cross(camera.forward, camera.right) : glm::cross(camera.right, camera.forward);
        if (const auto* node = table.get("fov")) {
            camera.fovYDegrees = numberOf(*node, "camera.fov", 0, 180);
            if (camera.fovYDegrees < 1e-3 || camera.fovYDegrees > 179)
                refuse(*node, fmt::format("camera.fov is {:g}, outside 0.001 to 179 degrees", camera.fovYDegrees));
        }
        const double scale = largestMagnitude(toward);
        camera.focusDistance = glm::length(toward / scale) * scale;
    }
    if (const auto* node = table.get("near")) {
        camera.near = numberOf(*node, "camera.near", 0, kMaxCoordinate);
        if (camera.near == 0) refuse(*node, "camera.near is 0");
    }
    scene_.camera = camera;
}

}  // namespace plumb::scene_file
