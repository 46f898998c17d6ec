// SPDX-License-Identifier: MIT
// The tiles of a band and the lists of the triangles in each, on the device.
#pragma once

#include "pipeline/passes/bin.h"
#include "pipeline/render/raster/geometry.h"

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

class Tiles {
public:
    Tiles(Device& device, Recorder& recorder, const Budget& budget, double watchdogMs)
        : device_(device), recorder_(recorder), budget_(budget), watchdogMs_(watchdogMs) {}

    void begin(const gpu::FrameBox& band);
    uint32_t across() const { return tilesX_; }
    uint32_t down() const { return tilesY_; }
    const gpu::FrameBox& band() const { return band_; }

    // Where the set-up pass lists `drawCount` triangles: nowhere, unless the band is the whole frame.
    SetupTiles forSetup(uint32_t drawCount, const gpu::FrameBox& frame);
    bool binned() const { return binned_; }  // the set-up has listed small triangles for the next bin()
    // Lists of the chunk in the band. Throws TooLarge.
    void bin(Geometry& geometry);

    std::span<const glm::uvec4> records() const { return tileRecords_; }  // tiles with a list: x | y << 16, first entry, entries
    const Buffer<uint32_t>& entries() const { return entries_; }
    uint64_t entryCount() const { return binEntries_; }
    TileLists lists() const;  // lists of the last bin(), each ascending
    gpu::BinPush pushFor(const Geometry& geometry) const;

    // Limits the entries of a tile's list (tests of overflow).
    void limitRoom(uint32_t most) { mostRoom_ = most; }
    uint32_t overflowed() const { return overflowed_; }  // tiles without room for all their entries, of the last bin()
    size_t stripCount() const { return strips_.size(); }

private:
    void makeRoom(uint32_t drawCount);
    void makeStrips(Geometry& geometry);
    void collectLists(Geometry& geometry, uint32_t walked, bool binned);
    void listOverflowed(Geometry& geometry, uint64_t end, uint32_t walked, bool binned);

    Device& device_;
    Recorder& recorder_;
    const Budget& budget_;
    const double watchdogMs_;
    gpu::FrameBox band_{};
    uint32_t tilesX_ = 0, tilesY_ = 0;
    uint32_t room_ = 0, mostRoom_ = 0xffffffffu,
             overflowed_ = 0;  // entries a list has, and may have at most; overflowed tiles of the last bin()
    uint64_t binEntries_ = 0;
    bool binned_ = false;  // tiles_ and entries_ hold the small triangles of the chunk in this band
    std::vector<glm::uvec4> strips_;
    std::vector<glm::uvec4> tileRecords_;
    Buffer<uint32_t> tiles_, entries_, setupOverflow_, walkOverflow_, stripOverflow_;
    Buffer<SlottedTriangle> medium_;
    Buffer<glm::uvec4> stripBuffer_;
};

}  // namespace plumb
