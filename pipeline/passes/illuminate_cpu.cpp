// SPDX-License-Identifier: MIT
#include "pipeline/passes/illuminate.h"
#include "pipeline/passes/parallel.h"

namespace plumb {

gpu::Reflectance reflectanceOf(const gpu::MaterialRecord& m) {
    return {m.diffuse.x, m.diffuse.y, m.diffuse.z, m.specular.x, m.specular.y, m.specular.z, m.shininess, m.zeroPower};
}

void illuminateCpu(const gpu::IlluminatePush& push, const gpu::ShadeParts& parts, std::span<const glm::vec4> positions,
                   std::span<const glm::vec4> normals, std::span<const uint32_t> pointMaterials, std::span<const gpu::ObjectRecord> objects,
                   std::span<const gpu::MaterialRecord> materials, std::span<const gpu::LightRecord> lights, std::span<glm::vec4> colours,
                   uint32_t threads) {
    parallelBands(push.pointCount, 1024, threads, [&](uint64_t begin, uint64_t end) {
        for (uint64_t i = push.firstPoint + begin; i < push.firstPoint + end; ++i) {
            const glm::vec4 &p = positions[i], &n = normals[i];
            const gpu::MaterialRecord& m = materials[pointMaterials[i]];
            const gpu::Surface surface =
                gpu::surfaceOfPoint(objects[push.object], push.toward != glm::vec3(0), push.toward, p.x, p.y, p.z, n.x, n.y, n.z);
            gpu::Colour c{m.base.x, m.base.y, m.base.z};
            for (const gpu::LightRecord& light : lights)
                gpu::addLight(glm::vec4(light.position, light.kind), glm::vec4(light.intensity, light.attenuation), surface,
                              reflectanceOf(m), parts, c);
            colours[i] = {c.r, c.g, c.b, 0.0f};
        }
    });
}

}  // namespace plumb
