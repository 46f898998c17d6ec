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
// Records the small triangles, then the large ones. `tiles`: counts (cleared by the caller), or first free entries.
void recordBin(Recorder& recorder, BinStep step, gpu::BinPush push, uint32_t drawCount, uint32_t largeCount,
               const Specialization& exact, const Buffer<gpu::DrawTriangle>& draws, const Buffer<gpu::ScreenVertex>& screen,
               const Buffer<uint32_t>& large, const Buffer<uint32_t>& tiles, const Buffer<uint32_t>& entries);

}  // namespace plumb
