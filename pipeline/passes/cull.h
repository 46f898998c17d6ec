// SPDX-License-Identifier: MIT
// Cull, set-up and clip: which triangles are drawn, and their list. Contracts: shaders/shared/cull.h, setup.h.
#pragma once

#include "host/recorder.h"
#include "pipeline/passes/draw_list.h"
#include "shaders/shared/setup.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

void cullCpu(const gpu::CullPush& push, std::span<const glm::uvec4> triangles, std::span<const gpu::ScreenVertex> screen,
             std::span<gpu::CullRecord> records, uint32_t threads);
void recordCull(Recorder& recorder, const gpu::CullPush& push, const Specialization& exact, const Buffer<glm::uvec4>& triangles,
                const Buffer<gpu::ScreenVertex>& screen, const Buffer<gpu::CullRecord>& records);

// Slot of the draw list and the triangle of the chunk that is drawn there.
struct SlottedTriangle {
    uint32_t slot, triangle;
};

// Result of the host's step between cull and set-up, the same for device and twin: slots in the draw list, clip jobs, counts.
struct DrawSlots {
    std::vector<uint32_t> first;  // first slot of each CullRecord
    std::vector<gpu::ClipJob> jobs;
    std::vector<SlottedTriangle> large;   // large or wide: binned in strips
    std::vector<SlottedTriangle> medium;  // triangles that a binning set-up leaves to the bin pass
    uint32_t drawCount = 0;               // entries of the draw list
    uint32_t clippedVertices = 0;
    uint64_t drawn = 0, backFacing = 0, zeroArea = 0, outside = 0;
    bool wide = false;
};
DrawSlots drawSlotsOf(std::span<const gpu::CullRecord> records, const DrawList& list, uint32_t firstClippedVertex);

void setupCpu(std::span<const gpu::CullRecord> records, const DrawSlots& slots, std::span<const glm::uvec4> triangles,
              std::span<const gpu::ScreenVertex> screen, std::span<gpu::DrawTriangle> draws, uint32_t threads);
// Lists the triangle of each slot of the draw list, gpu::kNoTriangle in slots of clip fans.
void listDrawn(std::span<const gpu::CullRecord> records, std::span<uint32_t> sources);
// Records the set-up pass. When push.tilesX is not 0 it bins small triangles too: counts in `tiles`, lists in `entries`, overflow bits in
// `overflow` (shared/bin.h).
void recordSetup(Recorder& recorder, const gpu::SetupPush& push, bool bothSides, const Specialization& exact,
                 const Buffer<glm::uvec4>& triangles, const Buffer<gpu::ScreenVertex>& screen, const Buffer<uint32_t>& sources,
                 const Buffer<gpu::DrawTriangle>& draws, const Buffer<uint32_t>& tiles, const Buffer<uint32_t>& entries,
                 const Buffer<uint32_t>& overflow);

// Clips the triangles of `jobs`. Writes their corners to screen and attributes at job.vertex, the fan to draws at job.slot; kinds[job] = wide
// | number of drawn triangles << 1. `given`: clip-space x, y, w that a more accurate transform left; empty: they are computed in float32.
void clipCpu(const gpu::ClipPush& push, std::span<const gpu::ClipJob> jobs, std::span<const glm::uvec4> triangles,
             std::span<const glm::vec4> positions, std::span<const gpu::ObjectRecord> objects, std::span<gpu::ScreenVertex> screen,
             std::span<glm::vec4> attributes, std::span<gpu::DrawTriangle> draws, std::span<uint32_t> kinds, uint32_t threads,
             std::span<const glm::vec4> given = {});
void recordClip(Recorder& recorder, const gpu::ClipPush& push, const Specialization& exact, const Buffer<glm::uvec4>& triangles,
                const Buffer<glm::vec4>& positions, const Buffer<gpu::ObjectRecord>& objects, const Buffer<gpu::ClipJob>& jobs,
                const Buffer<gpu::ScreenVertex>& screen, const Buffer<glm::vec4>& attributes, const Buffer<gpu::DrawTriangle>& draws,
                const Buffer<uint32_t>& kinds, const Buffer<glm::vec4>* given = nullptr);

}  // namespace plumb
