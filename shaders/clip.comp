// SPDX-License-Identifier: MIT
// One invocation one triangle that crosses a plane: Sutherland-Hodgman against five planes in clip space, then a fan from the
// first corner. Rare; loops have constant bounds.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/setup.h"

layout(push_constant, scalar) uniform Push { ClipPush push; };
layout(binding = 1) uniform usamplerBuffer triangles;
layout(binding = 2) uniform samplerBuffer positions;
layout(binding = 3, scalar) readonly buffer Objects { ObjectRecord objects[]; };
layout(binding = 4, scalar) readonly buffer Jobs { ClipJob jobs[]; };
layout(binding = 5, scalar) buffer Screen { uvec4 screen[]; };
layout(binding = 6, scalar) buffer Attributes { vec4 attributes[]; };
layout(binding = 7, scalar) writeonly buffer Draws { uvec4 draws[]; };
layout(binding = 8, scalar) writeonly buffer Kinds { uint kinds[]; };  // one word a job: bit 0 wide, number of drawn triangles << 1
#ifdef PLUMB_LONG
layout(binding = 9, scalar) readonly buffer Given { vec4 given[]; };  // clip-space x, y, w, 1 as the transform left them; zeros: float32
#endif

// The triangle as the planes so far have left it, and what the present plane keeps of it.
ClipVertex polygon[kClipCorners];
uint count;  // corners of `polygon`
ClipVertex next[kClipCorners];
uint kept;  // corners of `next`

ClipVertex cornerOf(uint vertex, uint object) {
    ClipVertex corner;
    vec3 p = texelFetch(positions, int(vertex)).xyz;
    corner.x = rowTimesPoint(objects[object].rowX, p);
    corner.y = rowTimesPoint(objects[object].rowY, p);
    corner.w = rowTimesPoint(objects[object].rowW, p);
#ifdef PLUMB_LONG
    vec4 clip = given[vertex];
    corner.x = clip.w != 0.0 ? clip.x : corner.x;
    corner.y = clip.w != 0.0 ? clip.y : corner.y;
    corner.w = clip.w != 0.0 ? clip.z : corner.w;
#endif
    corner.attributes = attributes[vertex].xyz;
    return corner;
}

void keep(ClipVertex corner) {
    next[min(kept, kClipCorners - 1u)] = corner;
    kept++;
}

// Keeps the edge from a to b as far as it lies inside the plane: its first corner, and where it leaves or enters.
void cutEdge(int plane, ClipVertex a, ClipVertex b) {
    float da = planeDistance(plane, a.x, a.y, a.w, push.viewport);
    float db = planeDistance(plane, b.x, b.y, b.w, push.viewport);
    bool inA = !(da < 0.0);
    bool inB = !(db < 0.0);
    if (inA) keep(a);
    if (inA && !inB) keep(intersect(plane, a, b, da, db, push.viewport));
    if (!inA && inB) keep(intersect(plane, b, a, db, da, push.viewport));
}

void cutPolygon(int plane) {
    kept = 0u;
    for (uint i = 0u; i < kClipCorners; ++i)
        if (i < count) cutEdge(plane, polygon[i], polygon[i + 1u < count ? i + 1u : 0u]);
    count = min(kept, kClipCorners);
    for (uint i = 0u; i < kClipCorners; ++i) polygon[i] = next[i];
}

void writeCorner(uint vertex, ClipVertex corner) {
    ScreenVertex s = projectClipped(corner, push.viewport);
    screen[vertex] = uvec4(uint(s.x), uint(s.y), floatBitsToUint(s.z), 0u);
    attributes[vertex] = vec4(corner.attributes, 0.0);
}

// Writes the fan from the first corner as draws, those that show nothing with three equal corners; returns the word of `kinds`.
uint writeFan(ClipJob job, bool mine) {
    uint drawnCount = 0u;
    uint wide = 0u;
    for (uint i = 0u; i < kClipFan; ++i) {
        uvec4 d = uvec4(job.vertex, job.vertex, job.vertex, job.triangle);
        if (mine && i + 2u < count) {
            ScreenVertex s0 = projectClipped(polygon[0], push.viewport);
            ScreenVertex s1 = projectClipped(polygon[i + 1u], push.viewport);
            ScreenVertex s2 = projectClipped(polygon[i + 2u], push.viewport);
            ivec2 p0 = ivec2(s0.x, s0.y);
            ivec2 p1 = ivec2(s1.x, s1.y);
            ivec2 p2 = ivec2(s2.x, s2.y);
            if (classify(p0, p1, p2, push.frame, push.cullBackFaces) == kDrawn) {
                DrawTriangle t = drawTriangle(job.vertex, job.vertex + i + 1u, job.vertex + i + 2u, p0, p1, p2, job.triangle);
                d = uvec4(t.vertex[0], t.vertex[1], t.vertex[2], t.source);
                ivec2 extent = highest(p0, p1, p2) - lowest(p0, p1, p2);
                wide |= isNarrow(extent.x, extent.y) ? 0u : 1u;
                drawnCount++;
            }
        }
        if (mine) draws[job.slot + i] = d;
    }
    return wide | (drawnCount << 1u);
}

void main() {
    uint item = itemIndex();
    bool mine = item < push.jobCount;
    ClipJob job = jobs[min(item, push.jobCount - 1u)];
    uvec4 corners = texelFetch(triangles, int(job.triangle));
    count = 3u;
    for (int i = 0; i < 3; ++i) polygon[i] = cornerOf(corners[i], job.object);
    for (int plane = 0; plane < kClipPlanes; ++plane) cutPolygon(plane);
    for (uint i = 0u; i < kClipCorners; ++i)
        if (mine && i < count) writeCorner(job.vertex + i, polygon[i]);
    uint kind = writeFan(job, mine);
    if (mine) kinds[item] = kind;
    finish(push.statusSlot, 0u);
}
