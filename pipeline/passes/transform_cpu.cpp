// SPDX-License-Identifier: MIT
#include "pipeline/passes/parallel.h"
#include "pipeline/passes/transform.h"
#include "shaders/shared/shade.h"

namespace plumb {

void transformCpu(const gpu::TransformPush& push, Normals writeNormals, std::span<const glm::vec4> positions,
                  std::span<const glm::vec4> normals, std::span<const gpu::ObjectRecord> objects, std::span<gpu::ScreenVertex> screen,
                  std::span<glm::vec4> attributes, uint32_t threads, const LongTransform& longer) {
    const gpu::ObjectRecord& o = objects[push.object];
    parallelBands(push.vertexCount, 4096, threads, [&](uint64_t begin, uint64_t end) {
        for (uint64_t i = push.firstVertex + begin; i < push.firstVertex + end; ++i) {
            const glm::vec3 p(positions[i]);
            glm::vec3 clip(gpu::rowTimesPoint(o.rowX, p), gpu::rowTimesPoint(o.rowY, p), gpu::rowTimesPoint(o.rowW, p));
            if (longer.precision != Precision::fp32) {
                const gpu::LongRecord& record = longer.records[push.object];
                clip = longer.precision == Precision::fp64 ? gpu::doubleClip(record, p) : gpu::blockClip(record, p);
                longer.clipSpace[i] = glm::vec4(clip, 1.0f);
            }
            screen[i] = gpu::project(clip.x, clip.y, clip.z, push.viewport);
            if (writeNormals == Normals::none) continue;
            const glm::vec3 n(normals[i]);
            attributes[i] = {gpu::rowTimesVector(o.normal0, n), gpu::rowTimesVector(o.normal1, n), gpu::rowTimesVector(o.normal2, n), 0.0f};
            if (writeNormals == Normals::unit) gpu::unitVector(attributes[i].x, attributes[i].y, attributes[i].z);
        }
    });
}

}  // namespace plumb
