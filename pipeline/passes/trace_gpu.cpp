// SPDX-License-Identifier: MIT
#include "pipeline/passes/trace.h"

#include <spirv/trace.h>

namespace plumb {

namespace {
// Loops over so few spheres unroll (lavapipe.md, section 4); more of them make the kernel spill.
constexpr size_t kUnrolledSpheres = 4;
}  // namespace

void recordTrace(Recorder& recorder, const gpu::TracePush& push, const TraceScene& scene, const TraceChoices& choices,
                 const Specialization& exact, const TraceBuffers& b) {
    Specialization constants = exact;
    constants[2] = choices.encoding;
    constants[3] = choices.planes;
    constants[4] = choices.colour;
    constants[5] = choices.list;
    constants[6] = scene.far;
    constants[7] = choices.count;
    constants[8] = choices.parts.specular;
    constants[9] = choices.parts.point;
    constants[10] = choices.shadows;
    constants[12] = !scene.nodes.empty();
    constants[11] = scene.spheres.size() <= kUnrolledSpheres ? uint32_t(scene.spheres.size()) : ~0u;
    recorder.dispatch("trace", spirv::trace, push.itemCount, push,
                      {texels(b.spheres, View::texelF32x4), texels(b.planes, View::texelF32x4), texels(b.surfaces, View::texelU32),
                       texels(b.materials, View::texelF32x4), texels(b.lights, View::texelF32x4), texels(b.encodeTable, View::texelU32),
                       storage(b.colours), storage(b.planeWords), storage(b.counters), storage(b.waiting), storage(b.states),
                       texels(b.nodes, View::texelU32x4), texels(b.triangles, View::texelU32x4), texels(b.corners, View::texelF32x4)},
                      constants);
}

}  // namespace plumb
