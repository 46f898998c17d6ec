// SPDX-License-Identifier: MIT
// The host's part of binning. Contract: shaders/shared/bin.h. It sizes the tiles' lists, cuts large boxes into strips, and completes the
// lists of overflowed tiles, which were too short for their triangles.
#pragma once

#include "pipeline/passes/cull.h"
#include "shaders/shared/bin.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

// Entries of each of `tiles` tiles for `drawn` triangles, so that few tiles overflow; at least 1, all together at most `most`.
uint32_t roomOfTiles(uint64_t drawn, uint64_t tiles, uint64_t most);

// Tiles x0, y0, x1, y1 of the band that a triangle's box touches; none when x1 < x0 or y1 < y0.
glm::ivec4 boxInBand(const gpu::BinPush& push, const gpu::ScreenVertex& a, const gpu::ScreenVertex& b, const gpu::ScreenVertex& c);

void addStrips(const gpu::BinPush& push, uint32_t slot, glm::ivec4 box, std::vector<glm::uvec4>& strips);

// Completes the lists of overflowed tiles: each is moved to where move() says, and the entries of the kernels' overflow bits are added.
class OverflowedTiles {
public:
    OverflowedTiles(const gpu::BinPush& push, std::span<uint32_t> entries)
        : push_(push), entries_(entries), next_(size_t(push.tilesX) * push.tilesY) {}
    void move(uint32_t tile, uint32_t to);
    // Adds what the set-up pass found no room for. overflow[i] belongs to slot i of the draw list: bit 0 its first, bit 1 its second tile.
    // Only for a band that is the whole frame.
    void addSetUp(std::span<const uint32_t> overflow, std::span<const gpu::DrawTriangle> draws, std::span<const gpu::ScreenVertex> screen);
    // Adds what walked triangles found no room for. overflow[i] belongs to draw list[i], or to draw i when there is no list.
    void addWalked(std::span<const uint32_t> overflow, std::span<const SlottedTriangle> list, std::span<const gpu::DrawTriangle> draws,
                   std::span<const gpu::ScreenVertex> screen);
    void addStrips(std::span<const uint32_t> overflow, std::span<const glm::uvec4> strips);
    // End so far of a moved tile's list.
    uint32_t endOf(uint32_t tile) const { return next_[tile]; }

private:
    void add(uint32_t tile, uint32_t slot);
    gpu::BinPush push_;
    std::span<uint32_t> entries_;
    std::vector<uint32_t> next_;
};

}  // namespace plumb
