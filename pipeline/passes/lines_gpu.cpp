// SPDX-License-Identifier: MIT
#include "pipeline/passes/lines.h"

#include <spirv/lines.h>

namespace plumb {

void recordLines(Recorder& recorder, const gpu::LinesPush& push, const Specialization& exact, const Buffer<glm::uvec2>& edges,
                 const Buffer<glm::vec4>& positions, const Buffer<gpu::ObjectRecord>& objects, const Buffer<uint32_t>& owners) {
    // The last two are not read: any buffer of the right kind will do.
    recorder.dispatch("lines", spirv::lines, push.edgeCount, push,
                      {texels(edges, View::texelU32x2), texels(positions, View::texelF32x4), storage(objects), storage(owners),
                       texels(edges, View::texelU32x2), texels(edges, View::texelU32x2)},
                      exact);
}

void recordHiddenLines(Recorder& recorder, const gpu::LinesPush& push, const Specialization& exact, const Buffer<glm::uvec2>& edges,
                       const Buffer<glm::vec4>& positions, const Buffer<gpu::ObjectRecord>& objects, const Buffer<uint32_t>& owners,
                       const Buffer<uint32_t>& edgeFaces, const Buffer<glm::uvec2>& surfaces) {
    Specialization constants = exact;
    constants[2] = 1;
    recorder.dispatch("lines", spirv::lines, push.edgeCount, push,
                      {texels(edges, View::texelU32x2), texels(positions, View::texelF32x4), storage(objects), storage(owners),
                       texels(edgeFaces, View::texelU32), texels(surfaces, View::texelU32x2)},
                      constants);
}

}  // namespace plumb
