// SPDX-License-Identifier: MIT
#include "pipeline/passes/lines.h"

#include <algorithm>

namespace plumb {

void linesCpu(const gpu::LinesPush& push, std::span<const glm::uvec2> edges, std::span<const glm::vec4> positions,
              std::span<const gpu::ObjectRecord> objects, std::span<uint32_t> owners, const HiddenLines& hidden) {
    const auto surfaceAt = [&](int x, int y) {
        if (x < 0 || x >= push.width || y < push.surfaceRow || y >= push.surfaceRow + push.surfaceRows) return glm::uvec2(0, gpu::kNoFace);
        return hidden.surfaces[size_t(y - push.surfaceRow) * size_t(push.width) + size_t(x)];
    };
    const gpu::ObjectRecord& o = objects[push.object];
    const gpu::Viewport& v = push.viewport;
    const float limitX = v.guardX + v.centreX, limitY = v.guardY + v.centreY;
    for (uint32_t edge = push.firstEdge; edge < push.firstEdge + push.edgeCount; ++edge) {
        const glm::vec3 p0(positions[edges[edge].x]), p1(positions[edges[edge].y]);
        gpu::LineEnds e{gpu::rowTimesPoint(o.rowX, p0), gpu::rowTimesPoint(o.rowY, p0), gpu::rowTimesPoint(o.rowW, p0),
                        gpu::rowTimesPoint(o.rowX, p1), gpu::rowTimesPoint(o.rowY, p1), gpu::rowTimesPoint(o.rowW, p1)};
        bool left = true;
        for (int plane = 0; left && plane < gpu::kClipPlanes; ++plane) left = gpu::cutLine(plane, e, v);
        if (!left) continue;
        const glm::ivec2 a(gpu::snapToSubpixel(gpu::exactDivide(e.x0, e.w0) + v.centreX, limitX),
                           gpu::snapToSubpixel(gpu::exactDivide(e.y0, e.w0) + v.centreY, limitY));
        const glm::ivec2 b(gpu::snapToSubpixel(gpu::exactDivide(e.x1, e.w1) + v.centreX, limitX),
                           gpu::snapToSubpixel(gpu::exactDivide(e.y1, e.w1) + v.centreY, limitY));
        const gpu::LineWalk w = gpu::walkLine(a, b);
        const gpu::LineDepth depth = gpu::lineDepth(gpu::exactDivide(v.near, e.w0), gpu::exactDivide(v.near, e.w1), w);
        for (int k = 0; k < w.count; ++k) {
            const int64_t numerator = (int64_t(w.offset) + int64_t(gpu::kSubpixels) * k) * w.rise;
            const int64_t along = numerator / w.run - (numerator % w.run < 0 ? 1 : 0);
            const int major = w.first + k, minor = int((w.start + along) >> gpu::kSubpixelBits);
            const int x = w.steep ? minor : major, y = (w.steep ? major : minor) - push.firstRow;
            if (x < 0 || x >= push.width || y < 0 || y >= push.rows) continue;
            const int dx = w.steep ? 1 : 0, dy = 1 - dx, row = y + push.firstRow;
            if (!hidden.surfaces.empty() && !gpu::lineShows(gpu::lineDepthAt(depth, w, k), hidden.edgeFaces[edge], surfaceAt(x, row),
                                                            surfaceAt(x - dx, row - dy), surfaceAt(x + dx, row + dy)))
                continue;
            uint32_t& owner = owners[size_t(y) * push.rowPixels + size_t(x)];
            owner = std::min(owner, push.edgeNumber + (edge - push.firstEdge));
        }
    }
}

}  // namespace plumb
