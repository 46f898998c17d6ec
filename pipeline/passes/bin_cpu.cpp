// SPDX-License-Identifier: MIT
#include "pipeline/passes/bin.h"

#include <algorithm>

namespace plumb {

// Plain twin: every tile of a triangle's box, each edge at the tile's pixel that is most inside, in 64-bit integers.
TileLists binCpu(const gpu::BinPush& push, std::span<const gpu::DrawTriangle> draws, std::span<const gpu::ScreenVertex> screen) {
    TileLists lists;
    lists.counts.assign(size_t(push.tilesX) * push.tilesY, 0);
    std::vector<uint32_t> next;
    for (int step = 0; step < 2; ++step) {
        for (uint32_t d = 0; d < draws.size(); ++d) {
            const uint32_t* v = draws[d].vertex;
            if (v[0] == v[1]) continue;
            int64_t x[3], y[3];
            for (int i = 0; i < 3; ++i) x[i] = screen[v[i]].x, y[i] = screen[v[i]].y;
            const int lowX = int(std::min({x[0], x[1], x[2]})), highX = int(std::max({x[0], x[1], x[2]}));
            const int lowY = int(std::min({y[0], y[1], y[2]})), highY = int(std::max({y[0], y[1], y[2]}));
            const int firstX = std::max(gpu::firstPixel(lowX), 0), lastX = std::min(gpu::lastPixel(highX), push.frame.width - 1);
            const int firstY = std::max(gpu::firstPixel(lowY), push.frame.firstRow) - push.frame.firstRow;
            const int lastY = std::min(gpu::lastPixel(highY) - push.frame.firstRow, push.frame.rows - 1);
            if (firstX > lastX || firstY > lastY) continue;
            for (int ty = firstY / gpu::kTileHeight; ty <= lastY / gpu::kTileHeight; ++ty)
                for (int tx = firstX / gpu::kTileWidth; tx <= lastX / gpu::kTileWidth; ++tx) {
                    const int64_t cx = int64_t(tx) * gpu::kTileWidth * gpu::kSubpixels + gpu::kHalfPixel;
                    const int64_t cy = (int64_t(ty) * gpu::kTileHeight + push.frame.firstRow) * gpu::kSubpixels + gpu::kHalfPixel;
                    bool touched = true;
                    for (int i = 0; i < 3; ++i) {
                        const int j = (i + 1) % 3;
                        const int64_t a = y[j] - y[i], b = x[i] - x[j];
                        const int64_t bestX = cx + (a > 0 ? (gpu::kTileWidth - 1) * gpu::kSubpixels : 0);
                        const int64_t bestY = cy + (b > 0 ? (gpu::kTileHeight - 1) * gpu::kSubpixels : 0);
                        touched &= a * (bestX - x[i]) + b * (bestY - y[i]) >= gpu::edgeBias(int(a), int(b));
                    }
                    if (!touched) continue;
                    const size_t tile = size_t(ty) * push.tilesX + tx;
                    if (step == 0)
                        ++lists.counts[tile];
                    else
                        lists.entries[next[tile]++] = d;
                }
        }
        if (step == 0) {
            uint32_t total = 0;
            for (uint32_t count : lists.counts) {
                next.push_back(total);
                total += count;
            }
            lists.entries.resize(total);
        }
    }
    return lists;
}

}  // namespace plumb
