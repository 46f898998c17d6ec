// SPDX-License-Identifier: MIT
// Lines: the edge that owns each pixel of a wire frame. Contract: shaders/shared/lines.h.
#pragma once

#include "host/recorder.h"
#include "pipeline/passes/draw_list.h"
#include "shaders/shared/lines.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace plumb {

// Input for removing hidden lines: the polygon of each edge, and z bits and face of each pixel. The rows begin at push.surfaceRow; the
// push.surfaceRows of them include those next to the band. Empty: every line is drawn.
struct HiddenLines {
    std::span<const uint32_t> edgeFaces;
    std::span<const glm::uvec2> surfaces;
};
void linesCpu(const gpu::LinesPush& push, std::span<const glm::uvec2> edges, std::span<const glm::vec4> positions,
              std::span<const gpu::ObjectRecord> objects, std::span<uint32_t> owners, const HiddenLines& hidden = {});

void recordLines(Recorder& recorder, const gpu::LinesPush& push, const Specialization& exact, const Buffer<glm::uvec2>& edges,
                 const Buffer<glm::vec4>& positions, const Buffer<gpu::ObjectRecord>& objects, const Buffer<uint32_t>& owners);
void recordHiddenLines(Recorder& recorder, const gpu::LinesPush& push, const Specialization& exact, const Buffer<glm::uvec2>& edges,
                       const Buffer<glm::vec4>& positions, const Buffer<gpu::ObjectRecord>& objects, const Buffer<uint32_t>& owners,
                       const Buffer<uint32_t>& edgeFaces, const Buffer<glm::uvec2>& surfaces);

}  // namespace plumb
