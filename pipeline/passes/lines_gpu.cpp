// SPDX-License-Identifier: MIT
#include "pipeline/passes/lines.h"

#include <spirv/lines.h>

namespace plumb {

void recordLines(Recorder& recorder, const gpu::LinesPush& push, const Specialization& exact, const Buffer<glm::uvec2>& edges,
                 const Buffer<glm::vec4>& positions, const Buffer<gpu::ObjectRecord>& objects, const Buffer<uint32_t>& owners) {
    Specialization constants = exact;
    constants["kHidden"] = false;
    // Without hidden-line removal edgeFaces and surfaces are not read: any buffer of the right kind will do.
    recorder.dispatch(
        "lines", spirv::lines, push.edgeCount, push,
        {texels("edges", edges, View::texelU32x2), texels("positions", positions, View::texelF32x4), storage("Objects", objects),
         storage("Owners", owners), texels("edgeFaces", edges, View::texelU32x2), texels("surfaces", edges, View::texelU32x2)},
        constants);
}

void recordHiddenLines(Recorder& recorder, const gpu::LinesPush& push, const Specialization& exact, const Buffer<glm::uvec2>& edges,
                       const Buffer<glm::vec4>& positions, const Buffer<gpu::ObjectRecord>& objects, const Buffer<uint32_t>& owners,
                       const Buffer<uint32_t>& edgeFaces, const Buffer<glm::uvec2>& surfaces) {
    Specialization constants = exact;
    constants["kHidden"] = true;
    recorder.dispatch(
        "lines", spirv::lines, push.edgeCount, push,
        {texels("edges", edges, View::texelU32x2), texels("positions", positions, View::texelF32x4), storage("Objects", objects),
         storage("Owners", owners), texels("edgeFaces", edgeFaces, View::texelU32), texels("surfaces", surfaces, View::texelU32x2)},
        constants);
}

}  // namespace plumb
