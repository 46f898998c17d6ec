// SPDX-License-Identifier: MIT
// The host's part of binning (contract: shaders/shared/bin.h): how much room each tile's list gets, what is binned in strips, and the lists
// of crowded tiles, in which not every triangle found room.
#pragma once

#include "pipeline/passes/cull.h"
#include "shaders/shared/bin.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

// Entries of each of `tiles` tiles for `drawn` triangles, so that few tiles are crowded; at least 1, all together at most `most`.
uint32_t roomOfTiles(uint64_t drawn, uint64_t tiles, uint64_t most);

// Tiles x0, y0, x1, y1 of the band that a triangle's box touches; x1 < x0 or y1 < y0: none.
glm::ivec4 boxInBand(const gpu::BinPush& push, const gpu::ScreenVertex& a, const gpu::ScreenVertex& b, const gpu::ScreenVertex& c);

void addStrips(const gpu::BinPush& push, uint32_t place, glm::ivec4 box, std::vector<glm::uvec4>& strips);

// Lists what found no room. A crowded tile's list is moved to where `move` says, and what the marks of the kernels say is added.
class CrowdedTiles {
public:
    CrowdedTiles(const gpu::BinPush& push, std::span<uint32_t> entries)
        : push_(push), entries_(entries), next_(size_t(push.tilesX) * push.tilesY) {}
    void move(uint32_t tile, uint32_t to);
    // Of the set-up pass, which bins in the tiles of the whole frame; marks of places.
    void addSetUp(std::span<const uint32_t> marks, std::span<const gpu::DrawTriangle> draws, std::span<const gpu::ScreenVertex> screen);
    // Of walked triangles: marks[i] belongs to draw list[i], or to draw i when there is no list.
    void addWalked(std::span<const uint32_t> marks, std::span<const PlacedTriangle> list, std::span<const gpu::DrawTriangle> draws,
                   std::span<const gpu::ScreenVertex> screen);
    void addStrips(std::span<const uint32_t> marks, std::span<const glm::uvec4> strips);
    // Where the list of a moved tile ends so far.
    uint32_t endOf(uint32_t tile) const { return next_[tile]; }

private:
    void add(uint32_t tile, uint32_t place);
    gpu::BinPush push_;
    std::span<uint32_t> entries_;
    std::vector<uint32_t> next_;
};

}  // namespace plumb
