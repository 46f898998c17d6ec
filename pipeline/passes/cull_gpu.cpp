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
    recorder.dispatch("cull", spirv::cull, lanes, push,
                      {texels(triangles, View::texelU32x4), texels(screen, View::texelU32x4), storage(records)}, exact);
}

void recordSetup(Recorder& recorder, const gpu::SetupPush& push, bool bothSides, const Specialization& exact,
                 const Buffer<glm::uvec4>& triangles, const Buffer<gpu::ScreenVertex>& screen, const Buffer<uint32_t>& sources,
                 const Buffer<gpu::DrawTriangle>& draws, const Buffer<uint32_t>& tiles, const Buffer<uint32_t>& entries,
                 const Buffer<uint32_t>& marks) {
    Specialization constants = exact;
    constants[2] = push.tilesX != 0;
    constants[3] = bothSides;
    recorder.dispatch("setup", spirv::setup, push.placeCount, push,
                      {texels(triangles, View::texelU32x4), texels(screen, View::texelU32x4), texels(sources, View::texelU32),
                       storage(draws), storage(tiles), storage(entries), storage(marks)},
                      constants);
}

void recordClip(Recorder& recorder, const gpu::ClipPush& push, const Specialization& exact, const Buffer<glm::uvec4>& triangles,
                const Buffer<glm::vec4>& positions, const Buffer<gpu::ObjectRecord>& objects,
                const Buffer<gpu::ClipJob>& jobs, const Buffer<gpu::ScreenVertex>& screen, const Buffer<glm::vec4>& carried,
                const Buffer<gpu::DrawTriangle>& draws, const Buffer<uint32_t>& kinds, const Buffer<glm::vec4>* given) {
    if (given == nullptr)
        recorder.dispatch("clip", spirv::clip, push.jobCount, push,
                          {texels(triangles, View::texelU32x4), texels(positions, View::texelF32x4), storage(objects), storage(jobs),
                           storage(screen), storage(carried), storage(draws), storage(kinds)},
                          exact);
    else
        recorder.dispatch("clip", spirv::clip_given, push.jobCount, push,
                          {texels(triangles, View::texelU32x4), texels(positions, View::texelF32x4), storage(objects), storage(jobs),
                           storage(screen), storage(carried), storage(draws), storage(kinds), storage(*given)},
                          exact);
}

}  // namespace plumb
