// SPDX-License-Identifier: MIT
// One invocation one edge. Pixels are claimed with atomicMin on the edge's number, so the result does not depend on the order.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/lines.h"

layout(constant_id = 2) const bool kHidden = false;  // hidden lines are removed

layout(push_constant, scalar) uniform Push { LinesPush push; };
layout(binding = 1) uniform usamplerBuffer edges;  // two vertices
layout(binding = 2) uniform samplerBuffer positions;
layout(binding = 3, scalar) readonly buffer Objects { ObjectRecord objects[]; };
layout(binding = 4, scalar) buffer Owners { uint owners[]; };
layout(binding = 5) uniform usamplerBuffer edgeFaces;  // the polygon of each edge (kHidden)
layout(binding = 6) uniform usamplerBuffer surfaces;   // z bits and face of each pixel of the surface rows (kHidden)

int floorDivide(int a, int b, out int rest) {  // b > 0
    uint magnitude = uint(abs(a));
    uint q = magnitude / uint(b);
    uint r = magnitude - q * uint(b);
    bool down = a < 0 && r != 0u;
    rest = a < 0 ? (down ? b - int(r) : 0) : int(r);
    return a < 0 ? -int(q) - (down ? 1 : 0) : int(q);
}

uvec2 surfaceAt(int x, int y) {  // z bits and face of a pixel of the frame; outside it nothing
    bool inside = x >= 0 && x < push.width && y >= push.surfaceRow && y < push.surfaceRow + push.surfaceRows;
    uvec2 s = texelFetch(surfaces, inside ? (y - push.surfaceRow) * push.width + x : 0).xy;
    return inside ? s : uvec2(0u, kNoFace);
}

void main() {
    uint item = itemIndex();
    bool mine = item < push.edgeCount;
    uint number = min(item, push.edgeCount - 1u);
    uvec2 ends = texelFetch(edges, int(push.firstEdge + number)).xy;
    vec3 p0 = texelFetch(positions, int(ends.x)).xyz;
    vec3 p1 = texelFetch(positions, int(ends.y)).xyz;
    ObjectRecord o = objects[push.object];
    LineEnds e = LineEnds(rowTimesPoint(o.rowX, p0), rowTimesPoint(o.rowY, p0), rowTimesPoint(o.rowW, p0), rowTimesPoint(o.rowX, p1),
                          rowTimesPoint(o.rowY, p1), rowTimesPoint(o.rowW, p1));
    for (int plane = 0; plane < kClipPlanes; ++plane) mine = mine && cutLine(plane, e, push.viewport);
    e.w0 = mine ? e.w0 : push.viewport.near;
    e.w1 = mine ? e.w1 : push.viewport.near;
    float limitX = push.viewport.guardX + push.viewport.centreX;
    float limitY = push.viewport.guardY + push.viewport.centreY;
    ivec2 a = ivec2(snapToSubpixel(exactDivide(e.x0, e.w0) + push.viewport.centreX, limitX),
                    snapToSubpixel(exactDivide(e.y0, e.w0) + push.viewport.centreY, limitY));
    ivec2 b = ivec2(snapToSubpixel(exactDivide(e.x1, e.w1) + push.viewport.centreX, limitX),
                    snapToSubpixel(exactDivide(e.y1, e.w1) + push.viewport.centreY, limitY));
    LineWalk w = walkLine(a, b);
    LineDepth depth = LineDepth(0.0, 0.0);
    uint face = 0u;
    if (kHidden) {
        depth = lineDepth(exactDivide(push.viewport.near, e.w0), exactDivide(push.viewport.near, e.w1), w);
        face = texelFetch(edgeFaces, int(push.firstEdge + number)).x;
    }
    int rest, stepRest;
    int along = floorDivide(w.offset * w.rise, w.run, rest);
    int perPixel = floorDivide(256 * w.rise, w.run, stepRest);
    int count = mine ? w.count : 0;
    int k = 0;
    do {
        int major = w.first + k;
        int minor = (w.start + along) >> kSubpixelBits;
        int x = w.steep != 0 ? minor : major;
        int y = (w.steep != 0 ? major : minor) - push.firstRow;
        bool shows = k < count && x >= 0 && x < push.width && y >= 0 && y < push.rows;
        if (kHidden && shows) {
            ivec2 across = w.steep != 0 ? ivec2(1, 0) : ivec2(0, 1);
            ivec2 at = ivec2(x, y + push.firstRow);
            shows = lineShows(lineDepthAt(depth, w, k), face, surfaceAt(at.x, at.y), surfaceAt(at.x - across.x, at.y - across.y),
                              surfaceAt(at.x + across.x, at.y + across.y));
        }
        if (shows) atomicMin(owners[uint(y) * push.rowPixels + uint(x)], push.edgeNumber + number);
        along += perPixel;
        rest += stepRest;
        bool carry = rest >= w.run;
        along += carry ? 1 : 0;
        rest -= carry ? w.run : 0;
        k++;
    } while (k < count);
    finish(push.statusSlot, k < count ? kFaultLoop : 0u);
}
