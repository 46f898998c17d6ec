// SPDX-License-Identifier: MIT
#include "pipeline/passes/scanline.h"

#include "host/error.h"

#include <fmt/core.h>
#include <algorithm>

namespace plumb {

// A row of one polygon must leave room in the loop budget for the polygon itself and for rounding.
constexpr int kWidest = gpu::kScanLimit / 2 - 3;

bool ScanList::add(std::span<const gpu::ScanCorner> polygon) {
    std::vector<gpu::ScanEdge> table;
    const uint32_t firstCorner = uint32_t(corners.size());
    float top = 0, bottom = 0, left = 0, right = 0;
    for (uint32_t i = 0; i < polygon.size(); ++i) {
        const gpu::ScanCorner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        top = i ? std::min(top, a.y) : a.y;
        bottom = i ? std::max(bottom, a.y) : a.y;
        left = i ? std::min(left, a.x) : a.x;
        right = i ? std::max(right, a.x) : a.x;
        const uint32_t from = firstCorner + i, to = firstCorner + uint32_t((i + 1) % polygon.size());
        if (a.y < b.y) table.push_back({from, to});
        if (a.y > b.y) table.push_back({to, from});
    }
    if (table.size() < 2) return false;
    if (!(bottom - top < gpu::kScanLimit - 1) || !(right - left < kWidest))
        throw inputError("--fill notes",
                         fmt::format("a polygon of {:g} x {:g} pixels; at most {} x {} are walked: move the camera or "
                                     "the near plane away from it",
                                     right - left + 1, bottom - top + 1, kWidest, gpu::kScanLimit - 1));
    if (bottom < 0 || top >= float(height) || right < 0 || left >= float(width) + 1)
        return false;  // column floor(X + 1/2): off the canvas
    std::stable_sort(table.begin(), table.end(), [&](const gpu::ScanEdge& a, const gpu::ScanEdge& b) {
        return polygon[a.top - firstCorner].y < polygon[b.top - firstCorner].y;
    });
    gpu::ScanPolygon p{};
    p.firstEdge = uint32_t(edges.size());
    p.edgeCount = uint32_t(table.size());
    p.firstLine = int(top);
    p.lineCount = int(bottom - top) + 1;
    p.firstSpan = uint32_t(spans);
    p.firstStored = std::max(0, p.firstLine);
    p.storedCount = std::min(height, p.firstLine + p.lineCount) - p.firstStored;
    spans += uint64_t(p.storedCount);
    if (spans > 0x7fffffffu) throw inputError("--fill notes", "the polygons have more than 2^31 lines");
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    edges.insert(edges.end(), table.begin(), table.end());
    polygons.push_back(p);
    return true;
}

ScanCanvas scanlineCpu(const ScanList& list, std::vector<gpu::ScanSpan>* spans) {
    ScanCanvas canvas;
    const size_t pixels = size_t(list.width) * size_t(list.height);
    canvas.z.assign(pixels, gpu::kScanFarthest);
    canvas.owner.assign(pixels, gpu::kNoPolygon);
    canvas.carried.assign(pixels, glm::vec3(0));
    if (spans) spans->clear();
    for (uint32_t number = 0; number < list.polygons.size(); ++number) {
        const gpu::ScanPolygon& p = list.polygons[number];
        const std::span<const gpu::ScanEdge> table(list.edges.data() + p.firstEdge, p.edgeCount);
        const int lastLine = p.firstLine + p.lineCount - 1;
        struct Active {
            const gpu::ScanEdge* edge;
            gpu::ScanWalk at, step;
        };
        const auto activate = [&](size_t n) {
            const gpu::ScanEdge* edge = &table[std::min(n, table.size() - 1)];
            return Active{edge, gpu::scanStart(list.corners[edge->top]),
                          gpu::scanStep(list.corners[edge->top], list.corners[edge->bottom])};
        };
        Active active[2] = {activate(0), activate(1)};
        size_t next = 2;
        for (int y = p.firstLine; y <= lastLine; ++y) {
            if (y >= 0 && y < list.height) {
                const gpu::ScanSpan s = gpu::scanSpan(active[0].at, active[1].at);
                if (spans) spans->push_back(s);
                const gpu::ScanWalk across = gpu::scanAcross(s);
                for (gpu::ScanWalk w = gpu::scanLeft(s); gpu::scanWithin(w.x, s.rightX); w = gpu::scanNext(w, across)) {
                    const int column = gpu::scanColumn(w.x);
                    if (!gpu::scanOnCanvas(column, list.width)) continue;
                    const size_t pixel = size_t(y) * size_t(list.width) + size_t(column);
                    if (!gpu::scanTakes(w.z, canvas.z[pixel], list.zBuffer)) continue;
                    canvas.z[pixel] = w.z;
                    canvas.owner[pixel] = number;
                    canvas.carried[pixel] = w.carried;
                }
            }
            for (Active& a : active) {
                a.at = gpu::scanNext(a.at, a.step);
                if (!gpu::scanEdgeEnds(y, lastLine, list.corners[a.edge->bottom].y)) continue;
                a = activate(next++);
                a.at = gpu::scanNext(a.at, a.step);
            }
        }
    }
    return canvas;
}

uint32_t scanSliceEnd(const ScanList& list, uint32_t first) {
    // A row costs one round a polygon and one a column of its widest line; rounding adds at most two.
    int budget = gpu::kScanLimit - 1;
    uint32_t end = first;
    for (; end < list.polygons.size(); ++end) {
        const gpu::ScanPolygon& p = list.polygons[end];
        float left = gpu::kScanFarthest, right = -gpu::kScanFarthest;
        for (uint32_t e = p.firstEdge; e < p.firstEdge + p.edgeCount; ++e)
            for (uint32_t corner : {list.edges[e].top, list.edges[e].bottom}) {
                left = std::min(left, list.corners[corner].x);
                right = std::max(right, list.corners[corner].x);
            }
        budget -= int(right - left) + 4;
        if (budget < 0 && end > first) break;
    }
    return end;
}

}  // namespace plumb
