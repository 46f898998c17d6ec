// SPDX-License-Identifier: MIT
// Lines: the edge that owns each pixel of a wire frame. Contract: shaders/shared/lines.h.
#pragma once

#include "host/recorder.h"
#include "pipeline/passes/draw_list.h"
#include "shaders/shared/lines.h"

#include <span>

namespace plumb {

void linesCpu(const gpu::LinesPush& push, std::span<const glm::uvec2> edges, std::span<const glm::vec4> positions,
              std::span<const gpu::ObjectRecord> objects, std::span<uint32_t> owners);

void recordLines(Recorder& recorder, const gpu::LinesPush& push, const Specialization& exact, const Buffer<glm::uvec2>& edges,
                 const Buffer<glm::vec4>& positions, const Buffer<gpu::ObjectRecord>& objects, const Buffer<uint32_t>& owners);

}  // namespace plumb
