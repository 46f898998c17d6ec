// SPDX-License-Identifier: MIT
// First kernel of the scanline pass: one invocation walks the edges of one polygon and leaves a span for each line of the canvas.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/scanline.h"

layout(push_constant, scalar) uniform Push { ScanPush push; };
layout(binding = 1, scalar) readonly buffer Polygons { ScanPolygon polygons[]; };
layout(binding = 2, scalar) readonly buffer Edges { ScanEdge edges[]; };
layout(binding = 3, scalar) readonly buffer Corners { ScanCorner corners[]; };
layout(binding = 4, scalar) writeonly buffer Spans { ScanSpan spans[]; };

void main() {
    uint item = itemIndex();
    bool mine = item < push.polygonCount;
    ScanPolygon p = polygons[push.firstPolygon + min(item, push.polygonCount - 1u)];
    uint lastEdge = p.firstEdge + p.edgeCount - 1u;
    uint next = p.firstEdge + 2u;
    ScanEdge i = edges[p.firstEdge];
    ScanEdge j = edges[p.firstEdge + 1u];
    ScanSlope slopeI = scanSlope(corners[i.top], corners[i.bottom]);
    ScanSlope slopeJ = scanSlope(corners[j.top], corners[j.bottom]);
    ScanWalk walkI = scanStart(i);
    ScanWalk walkJ = scanStart(j);
    int lines = mine ? min(p.lineCount, kScanLimit) : 0;
    for (int line = 0; line < lines; ++line) {
        int y = p.firstLine + line;
        spans[p.firstSpan + uint(line)] = scanSpan(walkI, i.height, scanOnLine(slopeI, y), walkJ, j.height, scanOnLine(slopeJ, y));
        walkI = scanNext(walkI, i);
        walkJ = scanNext(walkJ, j);
        if (scanEdgeEnds(y, p.lastLine, corners[i.bottom].y)) {
            i = edges[min(next, lastEdge)];
            next++;
            slopeI = scanSlope(corners[i.top], corners[i.bottom]);
            walkI = scanStart(i);
        }
        if (scanEdgeEnds(y, p.lastLine, corners[j.bottom].y)) {
            j = edges[min(next, lastEdge)];
            next++;
            slopeJ = scanSlope(corners[j.top], corners[j.bottom]);
            walkJ = scanStart(j);
        }
    }
    finish(push.statusSlot, mine && p.lineCount > kScanLimit ? kFaultLoop : 0u);
}
