// SPDX-License-Identifier: MIT
#include "pipeline/passes/trace.h"

#include <spirv/trace.h>
#include <spirv/trace_ballot.h>
#include <algorithm>
#include <bit>

namespace plumb {

namespace {
// True when the eye rays of a subgroup walk the BVH together. Its stack holds node << 8 | children, two levels in each invocation of the
// subgroup.
bool walksTogether(const TraceScene& scene, uint32_t lanes) {
    return !scene.nodes.empty() && scene.depth <= 2 * lanes && scene.nodes.size() / (2 * gpu::kNodeChildren) < (1u << 24);
}

// Loops over up to kUnrolledSpheres spheres and kUnrolledPlanes planes unroll. Records of up to kHeldSpheres spheres stay in registers of
// each invocation, those of more in the registers of a subgroup.
constexpr size_t kUnrolledSpheres = 24, kUnrolledPlanes = 2, kHeldSpheres = 4;
constexpr uint32_t kMostSamples = 4;    // most samples of an invocation
constexpr uint64_t kLoopSteps = 50000;  // most loop steps of all its samples; lavapipe ends loops after 65,535
constexpr size_t kFewLights = 4;        // with more lights each shadow ray walks the BVH by itself: all those steps for one sample
// True when some hit may send a ray on.
bool sends(const gpu::TracePush& push, const TraceChoices& choices) { return push.maxDepth > 1 && (choices.mirrors || choices.passes); }
}  // namespace

uint32_t samplesOfInvocation(const gpu::TracePush& push, const TraceScene& scene, const TraceChoices& choices) {
    if (!choices.tiles || choices.list) return 1;
    if (walksTogether(scene, choices.lanes)) return scene.lights.size() > kFewLights || sends(push, choices) ? 1 : 2;
    if (!scene.nodes.empty()) return 1;
    const uint64_t objects = scene.spheres.size() + scene.planes.size() + 2;
    const uint64_t steps = (objects + 1) * (scene.lights.size() + 1) * push.maxDepth;
    return steps * kMostSamples < kLoopSteps ? kMostSamples : 1;
}

void recordTrace(Recorder& recorder, const gpu::TracePush& push, const TraceScene& scene, const TraceChoices& choices,
                 const Specialization& exact, const TraceBuffers& b) {
    Specialization constants = exact;
    constants["kEncoding"] = choices.encoding;
    constants["kPlanes"] = choices.planes;
    constants["kColour"] = choices.colour;
    constants["kList"] = choices.list;
    constants["kFar"] = scene.far;
    constants["kClose"] = scene.close;
    constants["kCount"] = choices.count;
    constants["kSpecular"] = choices.parts.specular;
    constants["kPointLights"] = choices.parts.point;
    constants["kShadows"] = choices.shadows;
    constants["kSampling"] = choices.sampling;
    constants["kSide"] = choices.side;
    constants["kListed"] = !choices.pixels.empty();
    constants["kCutLevels"] = choices.cutLevels;
    constants["kJitterMirror"] = gpu::ubitsOf(choices.jitterMirror);
    constants["kJitterPass"] = gpu::ubitsOf(choices.jitterPass);
    constants["kJitterShadow"] = gpu::ubitsOf(choices.jitterShadow);
    constants["kMeshes"] = !scene.nodes.empty();
    const size_t spheres = scene.spheres.size(), planes = scene.planes.size();
    constants["kSpheres"] = spheres <= kUnrolledSpheres ? uint32_t(spheres) : ~0u;
    constants["kBoards"] = planes <= kUnrolledPlanes ? uint32_t(planes) : ~0u;
    constants["kHeldSpheres"] = spheres <= kHeldSpheres ? 1u : spheres <= kUnrolledSpheres && choices.lanes && !choices.list ? 2u : 0u;
    constants["kLanes"] = std::max(1u, choices.lanes);
    constants["kLights"] = !scene.lights.empty();
    constants["kChildren"] = sends(push, choices);
    constants["kRefracts"] = push.maxDepth > 1 && choices.passes;
    constants["kEyeTogether"] = walksTogether(scene, choices.lanes);
    constants["kTiles"] = choices.tiles;
    constants["kDeep"] = scene.depth > choices.lanes;
    constants["kLongPaths"] = push.maxDepth > choices.lanes;
    constants["kTurns"] = samplesOfInvocation(push, scene, choices);
    constants["kDims"] =
        std::any_of(scene.materials.begin(), scene.materials.end(), [](const gpu::TraceMaterial& m) { return m.transmit > 0; });
    constants["kOneLight"] = scene.lights.size() == 1;
    constants["kOneBoard"] = planes == 1;
    recorder.dispatch(
        "trace", choices.lanes ? spirv::trace_ballot : spirv::trace, push.itemCount, push,
        {texels("spheres", b.spheres, View::texelF32x4), texels("boards", b.planes, View::texelF32x4),
         texels("surfaces", b.surfaces, View::texelU32), texels("materials", b.materials, View::texelF32x4),
         texels("lights", b.lights, View::texelF32x4), texels("encodeTable", b.encodeTable, View::texelU32), storage("Colours", b.colours),
         storage("Planes", b.planeWords), storage("Counters", b.counters), storage("Waiting", b.waiting), storage("States", b.states),
         texels("nodes", b.nodes, View::texelU32x4), texels("triangles", b.triangles, View::texelU32x4),
         texels("corners", b.corners, View::texelF32x4), texels("pixels", b.pixels, View::texelU32),
         texels("leaves", b.leaves, View::texelU32x4), texels("powers", b.powers, View::texelF32)},
        constants);
}

}  // namespace plumb
