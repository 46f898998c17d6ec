// SPDX-License-Identifier: MIT
// What of a picture fits a device at once: functions of its limits and its memory, which need no device to be asked.
#pragma once

#include "host/device.h"
#include "pipeline/passes/draw_list.h"

#include <cstdint>
#include <string>

namespace plumb {

// Thrown when the chunk or the band does not fit the device's ranges: the caller halves it.
struct TooLarge {
    std::string what;
};

// Clipped corners for which there is memory at first; more is made when needed.
inline constexpr uint64_t kClipCornersAtFirst = 4096;

// Words of a sample in planes: gpu::kFillPlane bits.
uint32_t planeCount(uint32_t planes);

class Budget {
public:
    Budget(const DeviceLimits& limits, uint64_t memoryBytes) : limits_(limits), memoryBytes_(memoryBytes) {}

    // Largest chunk, whatever vertices its triangles have.
    uint64_t chunkTriangles() const;
    // True when the whole list may be one chunk, by its own counts rather than the most that its triangles could need. The set-up and the tiles' lists
    // may still find more drawn than a binding holds.
    bool holdsWhole(const DrawList& list, uint32_t planes) const;
    // Rows of a band, a multiple of 8.
    uint32_t bandRows(const gpu::FrameBox& frame, uint32_t planes) const;
    // Rows of a band of a frame whose bands lie in one buffer. 0: all bands are too much for one.
    uint32_t bandRowsInPlace(const gpu::FrameBox& frame) const;
    // Entries of all tiles' lists together.
    uint64_t mostEntries() const;
    // Throws TooLarge where a buffer of so many elements exceeds a binding.
    void check(const char* what, uint64_t count, uint64_t elementBytes) const;

private:
    const DeviceLimits limits_;
    const uint64_t memoryBytes_;
};

}  // namespace plumb
