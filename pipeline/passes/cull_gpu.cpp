// SPDX-License-Identifier: MIT
#include "pipeline/passes/cull.h"

#include <spirv/clip.h>
#include <spirv/clip_given.h>
#include <spirv/cull.h>
#include <spirv/setup.h>

namespace plumb {

void recordCull(Recorder& recorder, const gpu::CullPush& push, const Specialization& exact, const Buffer<glm::uvec4>& triangles,
                const Buffer<gpu::ScreenVertex>& screen, const Buffer<gpu::CullRecord>& records) {
    const uint64_t lanes = (uint64_t(push.triangleCount) + gpu::kTrianglesPerLane - 1) / gpu::kTrianglesPerLane;
    recorder.dispatch(
        "cull", spirv::cull, lanes, push,
        {texels("triangles", triangles, View::texelU32x4), texels("screen", screen, View::texelU32x4), storage("Records", records)}, exact);
}

void recordSetup(Recorder& recorder, const gpu::SetupPush& push, bool bothSides, const Specialization& exact,
                 const Buffer<glm::uvec4>& triangles, const Buffer<gpu::ScreenVertex>& screen, const Buffer<uint32_t>& sources,
                 const Buffer<gpu::DrawTriangle>& draws, const Buffer<uint32_t>& tiles, const Buffer<uint32_t>& entries,
                 const Buffer<uint32_t>& overflow) {
    Specialization constants = exact;
    constants["kBin"] = push.tilesX != 0;
    constants["kBothSides"] = bothSides;
    recorder.dispatch("setup", spirv::setup, push.slotCount, push,
                      {texels("triangles", triangles, View::texelU32x4), texels("screen", screen, View::texelU32x4),
                       texels("sources", sources, View::texelU32), storage("Draws", draws), storage("Tiles", tiles),
                       storage("Entries", entries), storage("Overflow", overflow)},
                      constants);
}

void recordClip(Recorder& recorder, const gpu::ClipPush& push, const Specialization& exact, const Buffer<glm::uvec4>& triangles,
                const Buffer<glm::vec4>& positions, const Buffer<gpu::ObjectRecord>& objects, const Buffer<gpu::ClipJob>& jobs,
                const Buffer<gpu::ScreenVertex>& screen, const Buffer<glm::vec4>& attributes, const Buffer<gpu::DrawTriangle>& draws,
                const Buffer<uint32_t>& kinds, const Buffer<glm::vec4>* given) {
    std::vector<Binding> bindings = {texels("triangles", triangles, View::texelU32x4),
                                     texels("positions", positions, View::texelF32x4),
                                     storage("Objects", objects),
                                     storage("Jobs", jobs),
                                     storage("Screen", screen),
                                     storage("Attributes", attributes),
                                     storage("Draws", draws),
                                     storage("Kinds", kinds)};
    if (given != nullptr) bindings.push_back(storage("Given", *given));
    recorder.dispatch("clip", given != nullptr ? spirv::clip_given : spirv::clip, push.jobCount, push, bindings, exact);
}

}  // namespace plumb
