// SPDX-License-Identifier: MIT
// Transform: object-space vertices -> screen vertices (snapped) and world normals. Contract: shaders/shared/transform.h.
#pragma once

#include "host/recorder.h"
#include "pipeline/passes/draw_list.h"

#include <span>

namespace plumb {

// World normals that a transform leaves in `carried`.
enum class Normals : uint32_t { none, direction, unit };

// One object.
void transformCpu(const gpu::TransformPush& push, Normals writeNormals, std::span<const glm::vec4> positions,
                  std::span<const glm::vec4> normals, std::span<const gpu::ObjectRecord> objects,
                  std::span<gpu::ScreenVertex> screen, std::span<glm::vec4> carried, uint32_t threads);

void recordTransform(Recorder& recorder, const gpu::TransformPush& push, Normals writeNormals, const Specialization& exact,
                     const Buffer<glm::vec4>& positions, const Buffer<glm::vec4>& normals,
                     const Buffer<gpu::ObjectRecord>& objects, const Buffer<gpu::ScreenVertex>& screen,
                     const Buffer<glm::vec4>& carried);

}  // namespace plumb
