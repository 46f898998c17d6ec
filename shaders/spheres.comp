// SPDX-License-Identifier: MIT
// One invocation one pixel: the nearest of the spheres that meet its row, then the illumination of that one.
#version 460
#extension GL_GOOGLE_include_directive : require
#define PLUMB_ONE_PIXEL
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/spheres.h"

layout(constant_id = 2) const bool kDiffuse = true;
layout(constant_id = 3) const bool kSpecular = true;
layout(constant_id = 4) const bool kPointLights = true;
layout(constant_id = 5) const uint kPower = 0u;

layout(push_constant, scalar) uniform Push { SpheresPush push; };
layout(binding = 1, scalar) readonly buffer Discs { SphereDisc discs[]; };
layout(binding = 2, scalar) readonly buffer RowFirst { uint rowFirst[]; };  // index of a row's first sphere in rowDiscs; rows + 1 words
layout(binding = 3, scalar) readonly buffer RowDiscs { uint rowDiscs[]; };  // spheres of the rows, in their order
layout(binding = 4) uniform samplerBuffer materials;
layout(binding = 5) uniform samplerBuffer lights;
layout(binding = 6, scalar) writeonly buffer Depths { float depths[]; };
layout(binding = 7, scalar) writeonly buffer Owners { uint owners[]; };
layout(binding = 8, scalar) writeonly buffer Colours { vec4 colours[]; };

void main() {
    uint item = itemIndex();
    bool mine = item < push.width * push.rowCount;
    uint row = push.firstRow + (mine ? item / push.width : 0u);
    uint column = mine ? item % push.width : 0u;
    uint first = rowFirst[row];
    uint count = mine ? rowFirst[row + 1u] - first : 0u;
    float nearest = kSphereFarthest;
    float nearestHeight = 0.0;
    uint owner = kNoSphere;
    for (uint i = 0u; i < min(count, uint(kSpheresOfRow)); ++i) {
        uint at = rowDiscs[first + i];
        SphereDisc s = discs[at];
        int x = int(column) - s.column;
        int y = s.row - int(row);
        if (sphereCovers(s, x, y)) {
            float height = sphereHeight(s, x, y, push.wholeHeights);
            float depth = sphereDepth(s, height, push.unit);
            if (sphereNearer(depth, nearest)) {
                nearest = depth;
                nearestHeight = height;
                owner = at;
            }
        }
    }
    Colour c = Colour(0.0, 0.0, 0.0);
    uint lightCount = owner != kNoSphere ? push.lightCount : 0u;
    if (owner != kNoSphere) {
        SphereDisc s = discs[owner];
        int m = int(s.material) * kMaterialTexels;
        vec4 base = texelFetch(materials, m);
        vec4 diffuse = texelFetch(materials, m + 1);
        vec4 specular = texelFetch(materials, m + 2);
        Surface surface = sphereSurface(s, int(column) - s.column, s.row - int(row), nearestHeight, push.unit);
        Reflectance k = Reflectance(diffuse.x, diffuse.y, diffuse.z, specular.x, specular.y, specular.z, base.w, diffuse.w);
        c = Colour(base.x, base.y, base.z);
        for (int light = 0; light < min(int(lightCount), kSphereLights); ++light)
            addLight(texelFetch(lights, light * kLightTexels), texelFetch(lights, light * kLightTexels + 1), surface, k,
                     ShadeParts(kDiffuse, kSpecular, kPointLights, kPower), c);
    }
    if (mine) {
        uint pixel = row * push.width + column;
        depths[pixel] = nearest;
        owners[pixel] = owner;
        colours[pixel] = vec4(c.r, c.g, c.b, 0.0);
    }
    finish(push.statusSlot, count > uint(kSpheresOfRow) || lightCount > uint(kSphereLights) ? kFaultLoop : 0u);
}
