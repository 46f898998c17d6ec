// SPDX-License-Identifier: MIT
// Transform: object-space vertices -> screen vertices (snapped) and world normals. Contract: shaders/shared/transform.h.
#pragma once

#include "host/recorder.h"
#include "pipeline/passes/draw_list.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace plumb {

// World normals that a transform leaves in `attributes`.
enum class Normals : uint32_t { none, direction, unit };

// Input and output of the more accurate transforms: records of the objects, and clip-space x, y, w of the vertices, with 1 behind them. A
// clip-space vector of zeros is that of a vertex in float32, which clipping computes again.
struct LongTransform {
    Precision precision = Precision::fp32;  // fp32: the other fields are not read
    std::span<const gpu::LongRecord> records;
    std::span<glm::vec4> clipSpace;
};
struct LongBuffers {
    Precision precision;
    const Buffer<gpu::LongRecord>& records;
    const Buffer<glm::vec4>& clipSpace;
};

// Transforms the vertices of one object.
void transformCpu(const gpu::TransformPush& push, Normals writeNormals, std::span<const glm::vec4> positions,
                  std::span<const glm::vec4> normals, std::span<const gpu::ObjectRecord> objects, std::span<gpu::ScreenVertex> screen,
                  std::span<glm::vec4> attributes, uint32_t threads, const LongTransform& longer = {});

void recordTransform(Recorder& recorder, const gpu::TransformPush& push, Normals writeNormals, const Specialization& exact,
                     const Buffer<glm::vec4>& positions, const Buffer<glm::vec4>& normals, const Buffer<gpu::ObjectRecord>& objects,
                     const Buffer<gpu::ScreenVertex>& screen, const Buffer<glm::vec4>& attributes);
// Transforms in another number format than fp32. Throws Error(usage) for fp64 on a device that has no binary64, or no exact one.
void recordLongTransform(Recorder& recorder, Device& device, const gpu::TransformPush& push, Normals writeNormals,
                         const Specialization& exact, const Buffer<glm::vec4>& positions, const Buffer<glm::vec4>& normals,
                         const Buffer<gpu::ObjectRecord>& objects, const Buffer<gpu::ScreenVertex>& screen,
                         const Buffer<glm::vec4>& attributes, const LongBuffers& longer);

}  // namespace plumb
