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
layout(binding = 6, scalar) buffer Varying { vec4 carried[]; };
layout(binding = 7, scalar) writeonly buffer Draws { uvec4 draws[]; };
layout(binding = 8, scalar) writeonly buffer Kinds { uint kinds[]; };  // one word a job: bit 0 wide, number of drawn triangles << 1
#ifdef PLUMB_LONG
layout(binding = 9, scalar) readonly buffer Given { vec4 given[]; };  // clip-space x, y, w of vertices, as the transform left them
#endif

void main() {
    uint item = itemIndex();
    bool mine = item < push.jobCount;
    ClipJob job = jobs[min(item, push.jobCount - 1u)];
    uvec4 corners = texelFetch(triangles, int(job.triangle));
    ClipVertex polygon[kClipCorners];
    ClipVertex next[kClipCorners];
    uint count = 3u;
    for (int i = 0; i < 3; ++i) {
#ifdef PLUMB_LONG
        vec4 clip = given[corners[i]];
        polygon[i].x = clip.x;
        polygon[i].y = clip.y;
        polygon[i].w = clip.z;
#else
        vec3 p = texelFetch(positions, int(corners[i])).xyz;
        polygon[i].x = rowTimesPoint(objects[job.object].rowX, p);
        polygon[i].y = rowTimesPoint(objects[job.object].rowY, p);
        polygon[i].w = rowTimesPoint(objects[job.object].rowW, p);
#endif
        polygon[i].carried = carried[corners[i]].xyz;
    }
    for (int plane = 0; plane < kClipPlanes; ++plane) {
        uint kept = 0u;
        for (uint i = 0u; i < kClipCorners; ++i) {
            if (i < count) {
                ClipVertex a = polygon[i];
                ClipVertex b = polygon[i + 1u < count ? i + 1u : 0u];
                float da = planeDistance(plane, a.x, a.y, a.w, push.viewport);
                float db = planeDistance(plane, b.x, b.y, b.w, push.viewport);
                bool inA = !(da < 0.0);
                bool inB = !(db < 0.0);
                if (inA) {
                    next[min(kept, kClipCorners - 1u)] = a;
                    kept++;
                }
                if (inA && !inB) {
                    next[min(kept, kClipCorners - 1u)] = intersect(plane, a, b, da, db, push.viewport);
                    kept++;
                }
                if (!inA && inB) {
                    next[min(kept, kClipCorners - 1u)] = intersect(plane, b, a, db, da, push.viewport);
                    kept++;
                }
            }
        }
        count = min(kept, kClipCorners);
        for (uint i = 0u; i < kClipCorners; ++i) polygon[i] = next[i];
    }
    uint drawnCount = 0u;
    uint wide = 0u;
    for (uint i = 0u; i < kClipCorners; ++i) {
        if (mine && i < count) {
            ScreenVertex s = projectClipped(polygon[i], push.viewport);
            screen[job.vertex + i] = uvec4(uint(s.x), uint(s.y), floatBitsToUint(s.z), 0u);
            carried[job.vertex + i] = vec4(polygon[i].carried, 0.0);
        }
    }
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
        if (mine) draws[job.place + i] = d;
    }
    if (mine) kinds[item] = wide | (drawnCount << 1u);
    finish(push.statusSlot, 0u);
}
