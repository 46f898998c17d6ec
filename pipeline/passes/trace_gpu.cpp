// SPDX-License-Identifier: MIT
#include "pipeline/passes/trace.h"

#include <bit>
#include <spirv/trace.h>
#include <spirv/trace_ballot.h>

namespace plumb {

namespace {
// Loops over so few spheres and planes unroll, and records of fewer stay in registers; more of them make lavapipe's kernel spill.
constexpr size_t kUnrolledSpheres = 24, kUnrolledPlanes = 2, kHeldSpheres = 4, kHeldPlanes = 1;
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
    constants[13] = choices.sampling;
    constants[14] = choices.side;
    constants[15] = !choices.pixels.empty();
    constants[16] = choices.cutLevels;
    constants[17] = gpu::ubitsOf(choices.jitterMirror);
    constants[18] = gpu::ubitsOf(choices.jitterPass);
    constants[19] = gpu::ubitsOf(choices.jitterFeeler);
    constants[12] = !scene.nodes.empty();
    const size_t spheres = scene.spheres.size(), planes = scene.planes.size();
    constants[11] = spheres <= kUnrolledSpheres ? uint32_t(spheres) : ~0u;
    constants[20] = planes <= kUnrolledPlanes ? uint32_t(planes) : ~0u;
    constants[21] = spheres <= kHeldSpheres && planes <= kHeldPlanes;
    constants[22] = uint32_t(std::bit_width(scene.lights.size()));
    recorder.dispatch("trace", choices.ballot ? spirv::trace_ballot : spirv::trace, push.itemCount, push,
                      {texels(b.spheres, View::texelF32x4), texels(b.planes, View::texelF32x4), texels(b.surfaces, View::texelU32),
                       texels(b.materials, View::texelF32x4), texels(b.lights, View::texelF32x4), texels(b.encodeTable, View::texelU32),
                       storage(b.colours), storage(b.planeWords), storage(b.counters), storage(b.waiting), storage(b.states),
                       texels(b.nodes, View::texelU32x4), texels(b.triangles, View::texelU32x4), texels(b.corners, View::texelF32x4),
                       texels(b.pixels, View::texelU32)},
                      constants);
}

}  // namespace plumb
