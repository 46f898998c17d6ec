// SPDX-License-Identifier: MIT
#include "pipeline/passes/tile_lists.h"

#include "host/error.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb {

uint32_t roomOfTiles(uint64_t drawn, uint64_t tiles, uint64_t most) {
    // Capacity is 24 times the mean: often only a third of the tiles hold triangles, a triangle is in 1.3 tiles, and tiles at silhouettes
    // hold many.
    constexpr uint64_t kTimesMean = 24, kLeast = 16;
    const uint64_t room = std::min(std::max(kLeast, kTimesMean * drawn / tiles), std::max<uint64_t>(1, drawn));
    return uint32_t(std::max<uint64_t>(1, std::min(room, most / tiles)));
}

glm::ivec4 boxInBand(const gpu::BinPush& push, const gpu::ScreenVertex& a, const gpu::ScreenVertex& b, const gpu::ScreenVertex& c) {
    const gpu::FrameBox& f = push.frame;
    const auto [lowX, highX] = std::minmax({a.x, b.x, c.x});
    const auto [lowY, highY] = std::minmax({a.y, b.y, c.y});
    const int lastRow = std::min(gpu::lastPixel(highY) - f.firstRow, f.rows - 1), lastColumn = std::min(gpu::lastPixel(highX), f.width - 1);
    const int firstRow = std::max(gpu::firstPixel(lowY) - f.firstRow, 0), firstColumn = std::max(gpu::firstPixel(lowX), 0);
    if (lastRow < firstRow || lastColumn < firstColumn) return {0, 0, -1, -1};
    return {firstColumn / gpu::kTileWidth, firstRow / gpu::kTileHeight, lastColumn / gpu::kTileWidth, lastRow / gpu::kTileHeight};
}

void addStrips(const gpu::BinPush& push, uint32_t slot, glm::ivec4 box, std::vector<glm::uvec4>& strips) {
    PLUMB_ASSERT(box.z < int(push.tilesX) && box.w < int(push.tilesY));
    for (int y = box.y; y <= box.w; ++y)
        for (int x = box.x; x <= box.z; x += int(gpu::kStripTiles))
            strips.emplace_back(slot, uint32_t(x) | uint32_t(y) << 16, std::min(uint32_t(box.z - x + 1), gpu::kStripTiles), 0u);
}

void OverflowedTiles::move(uint32_t tile, uint32_t to) {
    const auto from = entries_.begin() + ptrdiff_t(uint64_t(tile) * push_.room);
    std::copy(from, from + push_.room, entries_.begin() + ptrdiff_t(to));
    next_[tile] = to + push_.room;
}

void OverflowedTiles::add(uint32_t tile, uint32_t slot) {
    // An overflow bit of a tile that was not moved, or more bits than were counted, would write over other lists.
    if (tile >= next_.size() || next_[tile] == 0 || next_[tile] >= entries_.size())
        throw renderError("bin: a tile's overflow bits and its count disagree");
    entries_[next_[tile]++] = slot;
}

void OverflowedTiles::addSetUp(std::span<const uint32_t> overflow, std::span<const gpu::DrawTriangle> draws,
                               std::span<const gpu::ScreenVertex> screen) {
    for (size_t slot = 0; slot < overflow.size(); ++slot) {
        if (overflow[slot] == 0) continue;
        const uint32_t* v = draws[slot].vertex;
        const glm::ivec4 box = boxInBand(push_, screen[v[0]], screen[v[1]], screen[v[2]]);
        for (uint32_t left = overflow[slot]; left; left &= left - 1) {
            const bool last = std::countr_zero(left) != 0;  // the second of its one or two tiles
            add(uint32_t(last ? box.w : box.y) * push_.tilesX + uint32_t(last ? box.z : box.x), uint32_t(slot));
        }
    }
}

void OverflowedTiles::addWalked(std::span<const uint32_t> overflow, std::span<const SlottedTriangle> list,
                                std::span<const gpu::DrawTriangle> draws, std::span<const gpu::ScreenVertex> screen) {
    for (size_t i = 0; i < overflow.size(); ++i) {
        if (overflow[i] == 0) continue;
        const uint32_t slot = list.empty() ? uint32_t(i) : list[i].slot;
        const uint32_t* v = draws[slot].vertex;
        const glm::ivec4 box = boxInBand(push_, screen[v[0]], screen[v[1]], screen[v[2]]);
        const int columns = box.z - box.x + 1;
        for (uint32_t left = overflow[i]; left; left &= left - 1) {
            const int k = std::countr_zero(left);
            add(uint32_t(box.y + k / columns) * push_.tilesX + uint32_t(box.x + k % columns), slot);
        }
    }
}

void OverflowedTiles::addStrips(std::span<const uint32_t> overflow, std::span<const glm::uvec4> strips) {
    for (size_t i = 0; i < overflow.size(); ++i)
        for (uint32_t left = overflow[i]; left; left &= left - 1)
            add((strips[i].y >> 16) * push_.tilesX + (strips[i].y & 0xffffu) + uint32_t(std::countr_zero(left)), strips[i].x);
}

}  // namespace plumb
