// SPDX-License-Identifier: MIT
#include "pipeline/library/open_scene.h"
#include "pipeline/render/technique.h"

#include <fmt/core.h>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>

namespace plumb {

Scene openScene(const std::filesystem::path& path, const OpenOptions& options) {
    Scene scene = loadScene({path}, options.load);
    const bool bareMesh = isBareMesh(path, options.load);
    options.load.once->clear();
    if (options.size.x != 0 && options.size.y != 0) scene.size = options.size;
    scene.size = sizeFor(scene);
    completeScene(scene, scene.size, options.view, bareMesh);
    return scene;
}

glm::uvec2 sizeFor(const Scene& scene) { return scene.size.x != 0 && scene.size.y != 0 ? scene.size : glm::uvec2(640, 480); }

Shading shadingFor(const Scene& scene, Fill fill, std::string& asked) {
    if (scene.shading) return *scene.shading;
    const std::string why = fill == Fill::notes ? "" : raysAskedBy(scene);
    if (why.empty()) return Shading::phong;
    asked = fmt::format("shading ray: {}", why);
    return Shading::ray;
}

RenderRequest requestFor(const Scene& scene) {
    RenderRequest request;
    const glm::uvec2 size = sizeFor(scene);
    request.width = size.x;
    request.height = size.y;
    request.fill = scene.fill.value_or(request.fill);
    request.shading = shadingFor(scene, request.fill, request.stated.shading);
    request.wire = scene.wire.value_or(request.wire);
    request.wirePerPolygon = scene.wirePerPolygon.value_or(request.wirePerPolygon);
    request.distantViewer = scene.distantViewer.value_or(request.distantViewer);
    request.encoding = scene.encoding.value_or(request.encoding);
    request.background = scene.background.value_or(request.background);
    request.maxDepth = scene.maxDepth;
    request.minWeight = float(scene.minWeight);
    if (!isTraced(request)) return request;
    RayChoices& rays = request.rays;
    rays.sampling = scene.sampling.value_or(rays.sampling);
    rays.jitterReflect = float(scene.jitterReflect.value_or(0));
    rays.jitterRefract = float(scene.jitterRefract.value_or(0));
    rays.jitterShadow = float(scene.jitterShadow.value_or(0));
    rays.seed = scene.seed.value_or(rays.seed);
    rays.cutLevels = scene.cutLevels.value_or(rays.cutLevels);
    return request;
}

}  // namespace plumb
