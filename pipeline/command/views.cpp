// SPDX-License-Identifier: MIT
#include "pipeline/command/views.h"

#include "host/error.h"
#include "pipeline/library/open_scene.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/look_at.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <charconv>
#include <cstdint>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <vector>

namespace plumb {
namespace {

void applyFlags(Camera& camera, const Scene& scene, const Options& options) {
    if (options.eye || options.at) {
        const glm::dvec3 at = options.at.value_or(camera.eye + camera.forward * camera.focusDistance);
        camera.eye = options.eye.value_or(camera.eye);
        camera.focusDistance = glm::length(at - camera.eye);
        if (!(camera.focusDistance > 0)) throw usageError("--eye and --at are the same point");
        orient(camera, at - camera.eye, scene.up, scene.leftHanded);
    } else if (options.up && options.views.empty()) {
        orient(camera, camera.forward, scene.up, scene.leftHanded);
    }
    if (options.fovDegrees) {
        camera.fovYDegrees = *options.fovDegrees;
        camera.focalPixels = 0;
    }
    if (options.near) camera.near = *options.near;
}

// The camera after a turn by `angle` about the axis `up` through the point it looks at.
Camera turned(Camera camera, const glm::dvec3& up, double angle) {
    const glm::dvec3 centre = camera.eye + camera.forward * camera.focusDistance;
    const glm::dmat3 turn(glm::rotate(glm::dmat4(1), angle, glm::normalize(up)));
    camera.eye = centre + turn * (camera.eye - centre);
    camera.right = turn * camera.right;
    camera.up = turn * camera.up;
    camera.forward = turn * camera.forward;
    return camera;
}

}  // namespace

glm::uvec2 sizeOf(const Scene& scene, const Options& options) { return options.size.value_or(sizeFor(scene)); }

std::vector<Viewpoint> viewsOf(Scene& scene, glm::uvec2 size, const Options& options, bool bareMesh) {
    if (options.up) scene.up = glm::normalize(*options.up);
    if (options.cull) scene.cullBackFaces = *options.cull;
    const bool unlit = bareMesh && scene.lights.empty();
    const auto view = [&](const std::string& name, const Camera& camera) {
        return Viewpoint{name, camera, unlit ? defaultLights(scene, camera) : scene.lights};
    };
    const std::vector<std::string> names = options.views.empty() ? std::vector<std::string>{""} : options.views;
    std::vector<Viewpoint> views;
    for (const std::string& name : names) {
        completeScene(scene, size, name, bareMesh);
        Camera camera = *scene.camera;
        applyFlags(camera, scene, options);
        views.push_back(view(name, camera));
    }
    if (options.turntable != 0) {
        const Viewpoint first = views[0];
        views.clear();
        for (uint32_t i = 0; i < options.turntable; ++i)
            views.push_back(view(first.name, turned(first.camera, scene.up, glm::radians(360.0 * i / options.turntable))));
    }
    return views;
}

bool hasPlaceholder(const std::string& pattern, const char* name) {
    return pattern.find(fmt::format("{{{}}}", name)) != pattern.npos || pattern.find(fmt::format("{{{}:", name)) != pattern.npos;
}

std::string filledIn(const std::string& pattern, const PlaceholderValues& values) {
    std::string out;
    for (size_t at = 0; at < pattern.size();) {
        const size_t open = pattern.find('{', at);
        out += pattern.substr(at, open - at);
        if (open == pattern.npos) break;
        const size_t close = pattern.find('}', open);
        if (close == pattern.npos) return out + pattern.substr(open);
        const std::string name = pattern.substr(open + 1, close - open - 1);
        uint32_t digits = values.digits;
        const bool sized = name.starts_with("n:") &&
                           std::from_chars(name.data() + 2, name.data() + name.size(), digits).ptr == name.data() + name.size() &&
                           digits <= 20;
        if (name == "n" || sized)
            out += fmt::format("{:0{}}", values.number, digits);
        else if (name == "view")
            out += values.view;
        else if (name == "aov")
            out += values.aov;
        else if (name == "eye")
            out += values.eye;
        else if (name == "field")
            out += values.field;
        else if (name == "ink")
            out += values.ink;
        else
            throw usageError(
                fmt::format("--output: '{{{}}}' is not known; placeholders: {{n}}, {{n:4}}, {{view}}, {{aov}}, {{eye}}, {{field}}, {{ink}}",
                            printable(name)));
        at = close + 1;
    }
    return out;
}

}  // namespace plumb
