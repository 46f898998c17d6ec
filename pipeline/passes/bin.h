// SPDX-License-Identifier: MIT
// Bin: for each tile the drawn triangles that may cover one of its pixels. Contract: shaders/shared/bin.h.
#pragma once

#include "host/recorder.h"
#include "pipeline/passes/cull.h"
#include "shaders/shared/bin.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

// Counts of each tile of the band (row-major), and the lists one after another, each list ascending.
struct TileLists {
    std::vector<uint32_t> counts, entries;
};
TileLists binCpu(const gpu::BinPush& push, std::span<const gpu::DrawTriangle> draws, std::span<const gpu::ScreenVertex> screen);

struct BinBuffers {
    const Buffer<gpu::DrawTriangle>& draws;
    const Buffer<gpu::ScreenVertex>& screen;
    // triangles to walk when the set-up pass has binned the small ones; otherwise all draws are walked
    const Buffer<SlottedTriangle>& listed;
    const Buffer<glm::uvec4>& strips;
    const Buffer<uint32_t>& tiles;  // counts; cleared by the caller, or as the set-up pass left them
    const Buffer<uint32_t>& entries;
    const Buffer<uint32_t>& walkOverflow;   // overflow bits, a word a walked triangle
    const Buffer<uint32_t>& stripOverflow;  // overflow bits, a word a strip
};
struct BinCounts {
    uint32_t walked = 0;
    bool listed = false;
    uint32_t strips = 0;
    bool wide = false;  // some triangle needs the 64-bit set-up
};
void recordBin(Recorder& recorder, gpu::BinPush push, const BinCounts& counts, const Specialization& exact, const BinBuffers& buffers);

}  // namespace plumb
