// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/tiles.h"

#include "host/error.h"
#include "pipeline/passes/tile_lists.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <utility>
#include <vector>

namespace plumb {

namespace {

// Least number of medium triangles for a dispatch of their own: cutting fewer into strips on the host costs less.
constexpr size_t kFewMedium = 2048;
constexpr size_t kFewStrips = size_t(1) << 16;  // fit any device

}  // namespace

void Tiles::begin(const gpu::FrameBox& band) {
    band_ = band;
    binned_ = false;
    tilesX_ = uint32_t(band.width + gpu::kTileWidth - 1) / gpu::kTileWidth;
    tilesY_ = uint32_t(band.rows + gpu::kTileHeight - 1) / gpu::kTileHeight;
}

SetupTiles Tiles::forSetup(uint32_t drawCount, const gpu::FrameBox& frame) {
    binned_ = band_.firstRow == 0 && band_.rows == frame.height && band_.width == frame.width;
    setupOverflow_.reserve(device_, binned_ ? std::max(1u, drawCount) : 1, "overflow bits of the set-up");
    tiles_.reserve(device_, std::max(1u, tilesX_ * tilesY_), "tiles");
    entries_.reserve(device_, 1, "tile lists");
    if (binned_) makeRoom(drawCount);
    return {binned_ ? tilesX_ : 0, room_, tiles_, entries_, setupOverflow_};
}

void Tiles::makeRoom(uint32_t drawCount) {
    const uint32_t tiles = tilesX_ * tilesY_;
    room_ = std::min(mostRoom_, roomOfTiles(drawCount, tiles, budget_.mostEntries()));
    tiles_.reserve(device_, tiles, "tiles");
    entries_.reserve(device_, uint64_t(tiles) * room_, "tile lists");
    std::fill_n(tiles_.span().begin(), tiles, 0u);
}

// The host cuts boxes of large triangles into strips, one invocation each. On the device every large triangle would have to test every tile
// row.
void Tiles::makeStrips(Geometry& geometry) {
    strips_.clear();
    const gpu::BinPush push = pushFor(geometry);
    const std::span<const gpu::ScreenVertex> screen = std::as_const(geometry.screen()).span();
    const auto add = [&](uint32_t slot, uint32_t a, uint32_t b, uint32_t c) {
        addStrips(push, slot, boxInBand(push, screen[a], screen[b], screen[c]), strips_);
    };
    const auto addSlotted = [&](const SlottedTriangle& p) {
        const glm::uvec4& corners = geometry.chunk().triangles[p.triangle];
        add(p.slot, corners.x, corners.y, corners.z);
    };
    std::for_each(geometry.slots().large.begin(), geometry.slots().large.end(), addSlotted);
    if (binned_ && geometry.slots().medium.size() < kFewMedium)
        std::for_each(geometry.slots().medium.begin(), geometry.slots().medium.end(), addSlotted);
    for (const gpu::ClipJob& job : geometry.slots().jobs)
        for (uint32_t slot = job.slot; slot < job.slot + gpu::kClipFan; ++slot) {
            const uint32_t* v = std::as_const(geometry.draws()).span()[slot].vertex;
            if (v[0] != v[1]) add(slot, v[0], v[1], v[2]);
        }
}

void Tiles::bin(Geometry& geometry) {
    const DrawSlots& slots = geometry.slots();
    makeStrips(geometry);
    // Run the recorded commands first: the calls below may reallocate their buffers, or throw TooLarge and start over with a smaller chunk.
    if (!binned_ || strips_.size() > kFewStrips) recorder_.run(watchdogMs_);
    if (!binned_) makeRoom(slots.drawCount);
    const bool mediumWalk = binned_ && slots.medium.size() >= kFewMedium;
    const uint32_t walked = mediumWalk ? uint32_t(slots.medium.size()) : binned_ ? 0u : slots.drawCount;
    budget_.check("strips of large triangles", strips_.size(), sizeof(glm::uvec4));
    put<SlottedTriangle>(device_, medium_, mediumWalk ? std::span<const SlottedTriangle>(slots.medium) : std::span<const SlottedTriangle>(),
                         "medium triangles");
    put<glm::uvec4>(device_, stripBuffer_, strips_, "strips");
    walkOverflow_.reserve(device_, std::max(1u, walked), "overflow bits of triangles");
    stripOverflow_.reserve(device_, std::max<uint64_t>(1, strips_.size()), "overflow bits of strips");
    recordBin(recorder_, pushFor(geometry), {walked, mediumWalk, uint32_t(strips_.size()), geometry.wide()}, {},
              {geometry.draws(), geometry.screen(), medium_, stripBuffer_, tiles_, entries_, walkOverflow_, stripOverflow_});
    recorder_.run(watchdogMs_);
    collectLists(geometry, walked, std::exchange(binned_, false));
}

void Tiles::collectLists(Geometry& geometry, uint32_t walked, bool binned) {
    const std::span<const uint32_t> counts = std::as_const(tiles_).span();
    tileRecords_.clear();
    binEntries_ = 0;
    overflowed_ = 0;
    uint64_t end = uint64_t(tilesX_) * tilesY_ * room_;
    for (uint32_t y = 0, t = 0; y < tilesY_; ++y)
        for (uint32_t x = 0; x < tilesX_; ++x, ++t) {
            const uint32_t count = counts[t];
            if (count == 0) continue;
            const bool overflowed = count > room_;
            tileRecords_.emplace_back(x | y << 16, uint32_t(overflowed ? end : uint64_t(t) * room_), count, 0u);
            binEntries_ += count;
            overflowed_ += overflowed;
            end += overflowed ? count : 0;
        }
    if (overflowed_) listOverflowed(geometry, end, walked, binned);
}

void Tiles::listOverflowed(Geometry& geometry, uint64_t end, uint32_t walked, bool binned) {
    if (end > entries_.count()) {
        // only when the buffer must grow: the 25 % that reserve() added may hold the list although check() would refuse it
        budget_.check("tile-list entries", end, 4);
        const std::vector<uint32_t> entries(entries_.span().begin(), entries_.span().end());
        entries_.reserve(device_, end, "tile lists");
        entries_.upload(entries);
    }
    const auto tileOf = [&](const glm::uvec4& record) { return (record.x >> 16) * tilesX_ + (record.x & 0xffffu); };
    OverflowedTiles overflowed(pushFor(geometry), entries_.span().first(end));
    for (const glm::uvec4& record : tileRecords_)
        if (record.z > room_) overflowed.move(tileOf(record), record.y);
    const std::span<const gpu::DrawTriangle> draws = std::as_const(geometry.draws()).span();
    const std::span<const gpu::ScreenVertex> screen = std::as_const(geometry.screen()).span();
    if (binned) overflowed.addSetUp(std::as_const(setupOverflow_).span().first(geometry.slots().drawCount), draws, screen);
    const bool listed = binned && walked != 0;
    overflowed.addWalked(std::as_const(walkOverflow_).span().first(walked),
                         listed ? std::span<const SlottedTriangle>(geometry.slots().medium) : std::span<const SlottedTriangle>(), draws,
                         screen);
    overflowed.addStrips(std::as_const(stripOverflow_).span().first(strips_.size()), strips_);
    for (const glm::uvec4& record : tileRecords_)
        if (record.z > room_ && overflowed.endOf(tileOf(record)) != record.y + record.z)
            throw renderError("bin: an overflowed tile's list is not complete");
}

TileLists Tiles::lists() const {
    TileLists lists;
    lists.counts.assign(size_t(tilesX_) * tilesY_, 0);
    for (const glm::uvec4& record : tileRecords_) {
        lists.counts[(record.x >> 16) * tilesX_ + (record.x & 0xffffu)] = record.z;
        const auto first = entries_.span().begin() + ptrdiff_t(record.y);
        lists.entries.insert(lists.entries.end(), first, first + ptrdiff_t(record.z));
        std::sort(lists.entries.end() - ptrdiff_t(record.z), lists.entries.end());
    }
    return lists;
}

gpu::BinPush Tiles::pushFor(const Geometry& geometry) const {
    gpu::BinPush push{};
    push.tilesX = tilesX_;
    push.tilesY = tilesY_;
    push.room = room_;
    push.firstClippedVertex = uint32_t(geometry.chunk().positions.size());
    push.frame = band_;
    return push;
}

}  // namespace plumb
