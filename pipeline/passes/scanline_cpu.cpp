// SPDX-License-Identifier: MIT
#include "pipeline/passes/scanline.h"

#include "host/error.h"

#include <algorithm>
#include <cstdlib>

namespace plumb {

namespace {

// Row of a polygon's fill table: corners, smaller y first.
struct TableRow {
    uint32_t top, bottom;
};

int64_t floorOfQuotient(int64_t a, int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }  // b > 0

// Edge with X on `line` and dX, as whole columns and rests.
gpu::ScanEdge edgeFrom(const std::vector<gpu::ScanCorner>& corners, TableRow row, int line) {
    const gpu::ScanCorner &top = corners[row.top], &bottom = corners[row.bottom];
    const int64_t height = bottom.y - top.y, across = bottom.x - top.x, moved = across * (line - top.y);
    const int64_t columns = floorOfQuotient(moved, height), columnStep = floorOfQuotient(across, height);
    return {row.top,
            row.bottom,
            int(top.x + columns),
            uint32_t(moved - columns * height),
            int(columnStep),
            uint32_t(across - columnStep * height),
            uint32_t(height)};
}

}  // namespace

bool ScanList::add(std::span<const gpu::ScanCorner> polygon) {
    std::vector<TableRow> table;
    const uint32_t firstCorner = uint32_t(corners.size());
    int top = 0, bottom = 0, left = 0, right = 0;
    for (uint32_t i = 0; i < polygon.size(); ++i) {
        const gpu::ScanCorner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        PLUMB_ASSERT(std::abs(a.x) <= gpu::kScanFarthestPixel && std::abs(a.y) <= gpu::kScanFarthestPixel);
        top = i ? std::min(top, a.y) : a.y;
        bottom = i ? std::max(bottom, a.y) : a.y;
        left = i ? std::min(left, a.x) : a.x;
        right = i ? std::max(right, a.x) : a.x;
        const uint32_t from = firstCorner + i, to = firstCorner + uint32_t((i + 1) % polygon.size());
        if (a.y < b.y) table.push_back({from, to});
        if (a.y > b.y) table.push_back({to, from});
    }
    if (table.size() < 2) return false;
    if (bottom < 0 || top >= height || right < 0 || left >= width) return false;
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    std::stable_sort(table.begin(), table.end(), [&](const TableRow& a, const TableRow& b) { return corners[a.top].y < corners[b.top].y; });
    const int endLine = std::min(height, bottom + 1), endColumn = std::min(width, right + 1);
    for (int line = std::max(0, top); line < endLine; line += gpu::kScanBlock) {
        // Edges that end above the block are replaced, as on the way down to it.
        size_t active[2] = {0, 1}, next = 2;
        const auto bottomOf = [&](size_t n) { return corners[table[active[n]].bottom].y; };
        while (next < table.size() && std::min(bottomOf(0), bottomOf(1)) < line) active[bottomOf(0) <= bottomOf(1) ? 0 : 1] = next++;
        const uint32_t firstEdge = uint32_t(edges.size());
        // Line on which an edge is first used: the first two start at their corner, each later one a line below it.
        const auto firstUse = [&](size_t n) { return std::max(line, corners[table[n].top].y + (n < 2 ? 0 : 1)); };
        for (size_t n : active) edges.push_back(edgeFrom(corners, table[n], firstUse(n)));
        for (size_t n = next; n < table.size(); ++n) edges.push_back(edgeFrom(corners, table[n], firstUse(n)));
        for (int column = std::max(0, left); column < endColumn; column += gpu::kScanBlock) {
            gpu::ScanPolygon p{};
            p.firstEdge = firstEdge;
            p.edgeCount = uint32_t(edges.size()) - firstEdge;
            p.firstLine = line;
            p.lineCount = std::min(gpu::kScanBlock, endLine - line);
            p.lastLine = bottom;
            p.firstColumn = column;
            p.columnCount = std::min(gpu::kScanBlock, endColumn - column);
            p.firstSpan = uint32_t(spans);
            spans += uint64_t(p.lineCount);
            if (spans > 0x7fffffffu) throw inputError(location, "with it, --fill notes has more than 2^31 lines of polygons");
            polygons.push_back(p);
        }
    }
    return true;
}

namespace {

// Calls body(y, span) for each line of a polygon.
template <class Body>
void walkLines(const ScanList& list, const gpu::ScanPolygon& p, const Body& body) {
    const std::span<const gpu::ScanEdge> table(list.edges.data() + p.firstEdge, p.edgeCount);
    struct Active {
        const gpu::ScanEdge* edge;
        gpu::ScanSlope slope;
        gpu::ScanWalk at;
    };
    const auto activate = [&](size_t n) {
        const gpu::ScanEdge* edge = &table[std::min(n, table.size() - 1)];
        return Active{edge, gpu::scanSlope(list.corners[edge->top], list.corners[edge->bottom]), gpu::scanStart(*edge)};
    };
    Active active[2] = {activate(0), activate(1)};
    size_t next = 2;
    for (int y = p.firstLine; y < p.firstLine + p.lineCount; ++y) {
        const Active &i = active[0], &j = active[1];
        body(y, gpu::scanSpan(i.at, i.edge->height, gpu::scanOnLine(i.slope, y), j.at, j.edge->height, gpu::scanOnLine(j.slope, y)));
        for (Active& a : active) {
            a.at = gpu::scanNext(a.at, *a.edge);
            if (gpu::scanEdgeEnds(y, p.lastLine, list.corners[a.edge->bottom].y)) a = activate(next++);
        }
    }
}

}  // namespace

std::vector<gpu::ScanSpan> scanSpansCpu(const ScanList& list) {
    std::vector<gpu::ScanSpan> spans;
    for (const gpu::ScanPolygon& p : list.polygons) walkLines(list, p, [&](int, const gpu::ScanSpan& s) { spans.push_back(s); });
    return spans;
}

ScanCanvas scanlineCpu(const ScanList& list) {
    ScanCanvas canvas;
    const size_t pixels = size_t(list.width) * size_t(list.height);
    canvas.z.assign(pixels, gpu::kScanFarthest);
    canvas.owner.assign(pixels, gpu::kNoPolygon);
    canvas.attributes.assign(pixels, glm::vec3(0));
    for (uint32_t number = 0; number < list.polygons.size(); ++number) {
        const gpu::ScanPolygon& p = list.polygons[number];
        walkLines(list, p, [&](int y, const gpu::ScanSpan& s) {
            const gpu::ScanAcross across = gpu::scanAcross(s);
            const int last = gpu::scanLastStep(s, p);
            for (int steps = gpu::scanFirstStep(s, p); steps <= last; ++steps) {
                const gpu::ScanValues v = gpu::scanPixel(across, steps);
                const size_t pixel = size_t(y) * size_t(list.width) + size_t(gpu::scanColumn(s, steps));
                if (!gpu::scanTakes(v.z, canvas.z[pixel], list.zBuffer)) continue;
                canvas.z[pixel] = v.z;
                canvas.owner[pixel] = number;
                canvas.attributes[pixel] = v.attributes;
            }
        });
    }
    return canvas;
}

uint32_t scanSliceEnd(const ScanList& list, uint32_t first) {
    // Budget of a row: one round a polygon and one a column of its block.
    int budget = gpu::kScanLimit - 1;
    uint32_t end = first;
    for (; end < list.polygons.size(); ++end) {
        budget -= list.polygons[end].columnCount + 2;
        if (budget < 0 && end > first) break;
    }
    return end;
}

}  // namespace plumb
