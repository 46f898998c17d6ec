// SPDX-License-Identifier: MIT
#include "pipeline/passes/lines.h"

#include <spirv/lines.h>

namespace plumb {

void recordLines(Recorder& recorder, const gpu::LinesPush& push, const Specialization& exact, const Buffer<glm::uvec2>& edges,
                 const Buffer<glm::vec4>& positions, const Buffer<gpu::ObjectRecord>& objects, const Buffer<uint32_t>& owners) {
    recorder.dispatch("lines", spirv::lines, push.edgeCount, push,
                      {texels(edges, View::texelU32x2), texels(positions, View::texelF32x4), storage(objects), storage(owners)}, exact);
}

}  // namespace plumb
