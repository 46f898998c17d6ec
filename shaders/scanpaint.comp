// SPDX-License-Identifier: MIT
// Second kernel of the scanline pass: one invocation owns one row of the canvas and paints the spans of the dispatch's polygons
// into it, in their order. No two invocations share a pixel, so the order of polygons is the order of painting.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/scanline.h"

layout(push_constant, scalar) uniform Push { ScanPush push; };
layout(binding = 1, scalar) readonly buffer Polygons { ScanPolygon polygons[]; };
layout(binding = 2, scalar) readonly buffer Spans { ScanSpan spans[]; };
layout(binding = 3, scalar) buffer Depths { float depths[]; };
layout(binding = 4, scalar) writeonly buffer Owners { uint owners[]; };
layout(binding = 5, scalar) writeonly buffer Attributes { vec3 attributes[]; };

void main() {
    uint item = itemIndex();
    int row = int(item);
    uint count = row < push.height ? push.polygonCount : 0u;
    int budget = kScanLimit;
    for (uint n = 0u; n < count && budget > 0; ++n) {
        ScanPolygon p = polygons[push.firstPolygon + n];
        int line = row - p.firstLine;
        bool here = line >= 0 && line < p.lineCount;
        budget--;
        if (here) {
            ScanSpan s = spans[p.firstSpan + uint(line)];
            ScanAcross across = scanAcross(s);
            int last = scanLastStep(s, p);
            int steps = scanFirstStep(s, p);
            while (steps <= last && budget > 0) {
                ScanValues v = scanPixel(across, steps);
                uint pixel = uint(row) * uint(push.width) + uint(scanColumn(s, steps));
                if (scanTakes(v.z, depths[pixel], push.zBuffer)) {
                    depths[pixel] = v.z;
                    owners[pixel] = push.firstPolygon + n;
                    attributes[pixel] = v.attributes;
                }
                steps++;
                budget--;
            }
        }
    }
    finish(push.statusSlot, budget <= 0 ? kFaultLoop : 0u);
}
