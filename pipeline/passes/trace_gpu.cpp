// SPDX-License-Identifier: MIT
#include "pipeline/passes/trace.h"

#include <algorithm>
#include <bit>
#include <spirv/trace.h>
#include <spirv/trace_ballot.h>

namespace plumb {

namespace {
// A walk of eye rays together keeps node << 8 | children on its way back, and two levels of the way in each invocation of a subgroup.
bool walksTogether(const TraceScene& scene, uint32_t lanes) {
    return !scene.nodes.empty() && scene.depth <= 2 * lanes && scene.nodes.size() / (2 * gpu::kNodeChildren) < (1u << 24);
}

// Loops over so few spheres and planes unroll, and records of fewer stay in registers of each invocation, those of more in
// the registers of a subgroup.
constexpr size_t kUnrolledSpheres = 24, kUnrolledPlanes = 2, kHeldSpheres = 4;
constexpr uint32_t kMostSamples = 4;      // of an invocation
constexpr uint64_t kLoopSteps = 50000;    // of them all; lavapipe ends loops after 65,535
constexpr size_t kFewLights = 4;          // feelers of more walk a tree alone: all those steps for one sample
// Whether some hit may send on a ray of this share.
bool sends(const gpu::TracePush& push, const TraceScene& scene, float gpu::TraceMaterial::* share) {
    return push.maxDepth > 1 && std::any_of(scene.materials.begin(), scene.materials.end(), [&](const gpu::TraceMaterial& m) { return m.*share > 0; });
}
}  // namespace

uint32_t samplesOfInvocation(const gpu::TracePush& push, const TraceScene& scene, const TraceChoices& choices) {
    if (!choices.tiles || choices.list) return 1;
    if (walksTogether(scene, choices.lanes))
        return scene.lights.size() > kFewLights || sends(push, scene, &gpu::TraceMaterial::reflect) || sends(push, scene, &gpu::TraceMaterial::transmit) ? 1 : 2;
    if (!scene.nodes.empty()) return 1;
    const uint64_t objects = scene.spheres.size() + scene.planes.size() + 2;
    const uint64_t steps = (objects + 1) * (scene.lights.size() + 1) * push.maxDepth;
    return steps * kMostSamples < kLoopSteps ? kMostSamples : 1;
}

void recordTrace(Recorder& recorder, const gpu::TracePush& push, const TraceScene& scene, const TraceChoices& choices,
                 const Specialization& exact, const TraceBuffers& b) {
    Specialization constants = exact;
    constants[2] = choices.encoding;
    constants[3] = choices.planes;
    constants[4] = choices.colour;
    constants[5] = choices.list;
    constants[6] = scene.far;
    constants[35] = scene.close;
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
    constants[21] = spheres <= kHeldSpheres ? 1u : spheres <= kUnrolledSpheres && choices.lanes && !choices.list ? 2u : 0u;
    constants[22] = uint32_t(std::bit_width(scene.lights.size()));
    const bool refracts = sends(push, scene, &gpu::TraceMaterial::transmit);
    constants[23] = std::max(1u, choices.lanes);
    constants[24] = !scene.lights.empty();
    constants[25] = refracts || sends(push, scene, &gpu::TraceMaterial::reflect);
    constants[26] = refracts;
    constants[27] = walksTogether(scene, choices.lanes);
    constants[28] = choices.tiles;
    constants[29] = scene.depth > choices.lanes;
    constants[30] = push.maxDepth > choices.lanes;
    constants[31] = samplesOfInvocation(push, scene, choices);
    constants[32] = std::any_of(scene.materials.begin(), scene.materials.end(), [](const gpu::TraceMaterial& m) { return m.transmit > 0; });
    constants[33] = scene.lights.size() == 1;
    constants[34] = planes == 1;
    recorder.dispatch("trace", choices.lanes ? spirv::trace_ballot : spirv::trace, push.itemCount, push,
                      {texels(b.spheres, View::texelF32x4), texels(b.planes, View::texelF32x4), texels(b.surfaces, View::texelU32),
                       texels(b.materials, View::texelF32x4), texels(b.lights, View::texelF32x4), texels(b.encodeTable, View::texelU32),
                       storage(b.colours), storage(b.planeWords), storage(b.counters), storage(b.waiting), storage(b.states),
                       texels(b.nodes, View::texelU32x4), texels(b.triangles, View::texelU32x4), texels(b.corners, View::texelF32x4),
                       texels(b.pixels, View::texelU32), texels(b.leaves, View::texelU32x4), texels(b.powers, View::texelF32)},
                      constants);
}

}  // namespace plumb
