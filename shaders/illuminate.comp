// SPDX-License-Identifier: MIT
// One invocation four points of one object.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/illuminate.h"

layout(constant_id = 2) const bool kDiffuse = true;
layout(constant_id = 3) const bool kSpecular = true;
layout(constant_id = 4) const bool kPointLights = true;

layout(constant_id = 5) const uint kPower = 0u;
layout(constant_id = 6) const bool kDistantViewer = false;

layout(push_constant, scalar) uniform Push { IlluminatePush push; };
layout(binding = 1) uniform samplerBuffer positions;
layout(binding = 2) uniform samplerBuffer normals;
layout(binding = 3) uniform usamplerBuffer pointMaterials;
layout(binding = 4, scalar) readonly buffer Objects { ObjectRecord objects[]; };
layout(binding = 5) uniform samplerBuffer materials;
layout(binding = 6) uniform samplerBuffer lights;
layout(binding = 7, scalar) buffer Colours { vec4 colours[]; };

void main() {
    uint item = itemIndex() * 4u;
    ivec4 at = ivec4(push.firstPoint + min(uvec4(item, item + 1u, item + 2u, item + 3u), uvec4(push.pointCount - 1u)));
    ObjectRecord o = objects[push.object];
    mat4 p, n, a, d, s;  // a column a point, transposed below
    for (int i = 0; i < 4; ++i) {
        p[i] = texelFetch(positions, at[i]);
        n[i] = texelFetch(normals, at[i]);
        int m = int(texelFetch(pointMaterials, at[i]).x) * kMaterialTexels;
        a[i] = texelFetch(materials, m);
        d[i] = texelFetch(materials, m + 1);
        s[i] = texelFetch(materials, m + 2);
    }
    p = transpose(p);
    n = transpose(n);
    a = transpose(a);
    d = transpose(d);
    s = transpose(s);
    Surface surface = surfaceOfPoint(o, kDistantViewer, push.toward, p[0], p[1], p[2], n[0], n[1], n[2]);
    Reflectance k = Reflectance(d[0], d[1], d[2], s[0], s[1], s[2], a[3], d[3]);
    Colour c = Colour(a[0], a[1], a[2]);
    if (push.firstLight != 0u) {
        mat4 before;
        for (int i = 0; i < 4; ++i) before[i] = colours[at[i]];
        before = transpose(before);
        c = Colour(before[0], before[1], before[2]);
    }
    int light = 0;
    int lightCount = int(push.lightCount);
    if (lightCount > 0) {
        do {
            int from = (int(push.firstLight) + light) * kLightTexels;
            addLight(texelFetch(lights, from), texelFetch(lights, from + 1), surface, k,
                     ShadeParts(kDiffuse, kSpecular, kPointLights, kPower), c);
            light++;
        } while (light < lightCount);
    }
    for (int i = 0; i < 4; ++i)
        if (item + uint(i) < push.pointCount) colours[push.firstPoint + item + uint(i)] = vec4(c.r[i], c.g[i], c.b[i], 0.0);
    finish(push.statusSlot, light < lightCount ? kFaultLoop : 0u);
}
