// SPDX-License-Identifier: MIT
// One invocation one vertex. A dispatch an object, so that its record is a uniform load.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 256) in;
#include "shared/status.h"
#include "shared/shade.h"
#include "shared/transform.h"
#ifdef PLUMB_LONG
#include "shared/long_transform.h"
#endif

layout(constant_id = 2) const bool kWriteNormals = true;  // Phong, or planes that ask for them

layout(constant_id = 3) const bool kUnitNormals = false;  // normals are normalised here, for pixels that take them as interpolated

layout(push_constant, scalar) uniform Push { TransformPush push; };
layout(binding = 1) uniform samplerBuffer positions;  // xyz, object space
layout(binding = 2) uniform samplerBuffer normals;    // xyz, object space
layout(binding = 3, scalar) readonly buffer Objects { ObjectRecord objects[]; };
layout(binding = 4, scalar) writeonly buffer Screen { uvec4 screen[]; };
layout(binding = 5, scalar) writeonly buffer Attributes { vec4 attributes[]; };
#ifdef PLUMB_LONG
layout(binding = 6, scalar) readonly buffer Longs { LongRecord longs[]; };  // one an object
layout(binding = 7, scalar) writeonly buffer Clip { vec4 clipSpace[]; };    // x, y, w, 1; clipping continues from there
#endif

void main() {
    uint item = itemIndex();
    bool mine = item < push.vertexCount;
    uint at = push.firstVertex + min(item, push.vertexCount - 1u);
    ObjectRecord o = objects[push.object];
    vec3 p = texelFetch(positions, int(at)).xyz;
#ifdef PLUMB_LONG
#ifdef PLUMB_DOUBLE
    vec3 clip = doubleClip(longs[push.object], p);
#else
    vec3 clip = blockClip(longs[push.object], p);
#endif
    if (mine) clipSpace[at] = vec4(clip, 1.0);
    ScreenVertex s = project(clip.x, clip.y, clip.z, push.viewport);
#else
    float w = rowTimesPoint(o.rowW, p);
    ScreenVertex s = project(rowTimesPoint(o.rowX, p), rowTimesPoint(o.rowY, p), w, push.viewport);
#endif
    if (mine) screen[at] = uvec4(uint(s.x), uint(s.y), floatBitsToUint(s.z), s.outcode);
    if (kWriteNormals) {
        vec3 n = texelFetch(normals, int(at)).xyz;
        vec4 world = vec4(rowTimesVector(o.normal0, n), rowTimesVector(o.normal1, n), rowTimesVector(o.normal2, n), 0.0);
        if (kUnitNormals) {
            Real x = real(world.x), y = real(world.y), z = real(world.z);
            unitVector(x, y, z);
            world = vec4(x.x, y.x, z.x, 0.0);
        }
        if (mine) attributes[at] = world;
    }
    finish(push.statusSlot, 0u);
}
