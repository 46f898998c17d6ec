// SPDX-License-Identifier: MIT
// Bin: for each tile the drawn triangles that may cover one of its pixels. Contract: shaders/shared/bin.h.
#pragma once

#include "host/recorder.h"
#include "pipeline/passes/draw_list.h"
#include "shaders/shared/bin.h"

#include <span>
#include <vector>

namespace plumb {

// Counts of each tile of the band (row-major), and the lists one after another; each list ascending.
struct TileLists {
    std::vector<uint32_t> counts, entries;
};
TileLists binCpu(const gpu::BinPush& push, std::span<const gpu::DrawTriangle> draws, std::span<const gpu::ScreenVertex> screen);

enum class BinStep { count, list };
struct BinBuffers {
    const Buffer<gpu::DrawTriangle>& draws;
    const Buffer<gpu::ScreenVertex>& screen;
    const Buffer<uint32_t>& large;       // places that are binned row by row
    const Buffer<uint32_t>& medium;      // places that are walked when the set-up pass has counted the small ones; otherwise all are
    const Buffer<uint32_t>& tiles;       // counts (cleared by the caller); for lists the first entry of each tile, and from push.ends on its end
    const Buffer<uint32_t>& entries;
    const Buffer<glm::uvec4>& slots;     // of small triangles that the set-up pass has counted
};
inline constexpr uint32_t kLowRows = 16;
struct BinCounts {
    uint32_t drawn = 0, medium = 0, large = 0;
    uint32_t low = 0;                    // the first of the large ones, which span at most kLowRows tile rows
    bool counted = false;                // the set-up pass has counted the small triangles
};
void recordBin(Recorder& recorder, BinStep step, gpu::BinPush push, const BinCounts& counts, const Specialization& exact,
               const BinBuffers& buffers);

}  // namespace plumb
