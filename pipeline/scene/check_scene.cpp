// SPDX-License-Identifier: MIT
#include "pipeline/scene/check_scene.h"

#include "host/error.h"
#include "pipeline/scene/affine.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <string_view>
#include <utility>

namespace plumb {

namespace {

bool isUsable(const glm::dvec3& v) {
    return std::abs(v.x) <= kMaxCoordinate && std::abs(v.y) <= kMaxCoordinate && std::abs(v.z) <= kMaxCoordinate;
}

class Judge {
public:
    explicit Judge(const Scene& scene) : scene_(scene), file_(scene.path.empty() ? "memory" : scene.path) {}

    void camera() const {
        if (!scene_.camera) refuse("", "camera", "", "the scene has none: set Scene::camera, by lookAt() or completeScene()");
        const Camera& c = *scene_.camera;
        for (const auto& [name, v] :
             {std::pair("eye", c.eye), std::pair("right", c.right), std::pair("up", c.up), std::pair("forward", c.forward)})
            if (!isUsable(v)) refuse("", "camera", "", fmt::format("{} has a coordinate that is no number up to 2^100", name));
        if (!(c.focalPixels >= 0 && std::isfinite(c.focalPixels)))
            refuse("", "camera", "", fmt::format("focalPixels is {}", c.focalPixels));
        if (c.focalPixels == 0 && !(c.fovYDegrees > 0 && c.fovYDegrees < 180))
            refuse("", "camera", "", fmt::format("fovYDegrees is {}, outside 0 to 180", c.fovYDegrees));
        if (!(c.near >= 0 && std::isfinite(c.near))) refuse("", "camera", "", fmt::format("near is {}", c.near));
        if (!(c.focusDistance > 0 && std::isfinite(c.focusDistance)))
            refuse("", "camera", "", fmt::format("focusDistance is {}", c.focusDistance));
    }

    void object(const Object& o) const {
        if (o.mesh >= scene_.meshes.size())
            refuse(o.location, "object", o.name,
                   fmt::format("mesh is {}; the scene has {}, and the first is 0", o.mesh, scene_.meshes.size()));
        if (!entriesUsable(o.worldFromObject))
            refuse(o.location, "object", o.name, "worldFromObject has an entry that is no number up to 2^100");
    }

    void material(const std::string& location, std::string_view kind, const std::string& name, uint32_t index) const {
        if (index >= scene_.materials.size())
            refuse(location, kind, name,
                   fmt::format("material is {}; the scene has {}, and the first is 0", index, scene_.materials.size()));
    }

    void light(const Light& l) const {
        if (!isUsable(l.directional ? l.direction : l.position))
            refuse(l.location, "light", "",
                   fmt::format("{} has a coordinate that is no number up to 2^100", l.directional ? "direction" : "position"));
        if (l.directional && !(glm::length(l.direction) > 0))
            refuse(l.location, "light", "", "direction is 0 0 0; it points toward the light");
        for (int c = 0; c < 3; ++c)
            if (!(l.intensity[c] >= 0 && l.intensity[c] <= kMaxCoordinate))
                refuse(l.location, "light", "",
                       fmt::format("intensity is {} in channel {}; it is 0 or more, at most 2^100", l.intensity[c], "RGB"[c]));
    }

private:
    [[noreturn]] void refuse(const std::string& location, std::string_view kind, const std::string& name, const std::string& why) const {
        throw inputError(locationOfPart(location, file_, kind, name), why);
    }

    const Scene& scene_;
    const std::string file_;
};

}  // namespace

void checkScene(const Scene& scene) {
    const Judge judge(scene);
    judge.camera();
    for (const Object& object : scene.objects) judge.object(object);
    for (const SphereShape& sphere : scene.spheres) judge.material(sphere.location, "sphere", sphere.name, sphere.material);
    for (const PlaneShape& plane : scene.planes) judge.material(plane.location, "plane", plane.name, plane.material);
    for (const Light& light : scene.lights) judge.light(light);
}

}  // namespace plumb
