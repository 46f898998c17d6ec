// SPDX-License-Identifier: MIT
// A witness that shares no code with the passes: lavapipe's own fixed-function rasteriser (its graphics pipeline, host/graphics.h). It snaps to 8
// sub-pixel bits and follows the top-left rule; clip coordinates that are exact multiples of 1/256 px after the viewport transform reach it
// unrounded when the frame's sides are powers of two and |x|, |y| <= kGuard w. It has no guard band of its own (what leaves the viewport is
// clipped, with new vertices made in floats), so the viewport is kGuard times the frame and the frame is its middle.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace plumb::oracle {

struct ClipPosition {
    float x, y, z, w;  // Vulkan clip space: x to the right, y down, 0 <= z <= w; depth is z / w, 1 is nearest
};

inline constexpr float kGuard = 4.0f;  // frames up to 16384 / kGuard pixels a side
inline constexpr uint32_t kNothingDrawn = 0xffffffffu;

struct DrawnFrame {
    uint32_t width = 0, height = 0;
    std::vector<uint32_t> ids;  // kNothingDrawn where nothing is drawn
    std::vector<float> depth;   // 0 where nothing is drawn
};

class FixedFunction {
public:
    // Throws when there is no lavapipe: a missing witness fails, it is not skipped.
    FixedFunction();
    ~FixedFunction();
    FixedFunction(const FixedFunction&) = delete;
    FixedFunction& operator=(const FixedFunction&) = delete;

    // Three vertices a triangle, in order; triangle t writes ids[t]. x = -w is the frame's left side, y = -w its top. Both windings are drawn. Greater depth wins, the earlier triangle on a tie.
    DrawnFrame draw(uint32_t width, uint32_t height, std::span<const ClipPosition> vertices, std::span<const uint32_t> ids);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace plumb::oracle
