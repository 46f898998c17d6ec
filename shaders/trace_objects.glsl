// SPDX-License-Identifier: MIT
// Spheres, planes and triangles of the trace kernel: their records, from texels or registers, and what a ray meets of each (trace.comp).

// Records that stay in registers: indexed by constants alone, once loops are unrolled.
vec4 heldSpheres[kHeldSpheres == kHeldByAll && kSpheres > 0    ? kSpheres
                 : kHeldSpheres == kHeldByLanes&& kSpheres > 0 ? (kSpheres + 7) / 8
                                                               : 1];
uint heldSurfaces[kHeldSpheres == kHeldByAll && kSpheres > 0    ? kSpheres
                  : kHeldSpheres == kHeldByLanes&& kSpheres > 0 ? (kSpheres + 7) / 8
                                                                : 1];
vec4 heldBoard[kPlaneTexels];
uint heldBoardSurface;
vec4 heldLight[kLightTexels];

void hold() {
    if (kHeldSpheres == kHeldByAll)
        for (int i = 0; i < kSpheres; ++i) {
            heldSpheres[i] = texelFetch(spheres, i);
            heldSurfaces[i] = texelFetch(surfaces, i).x;
        }
#ifdef PLUMB_BALLOT
    if (kHeldSpheres == kHeldByLanes)
        for (int i = 0; i < (kSpheres + 7) / 8; ++i) {
            int mine = min(i * 8 + int(gl_SubgroupInvocationID & 7u), kSpheres - 1);
            heldSpheres[i] = texelFetch(spheres, mine);
            heldSurfaces[i] = texelFetch(surfaces, mine).x;
        }
#endif
    if (kOneBoard) {
        for (int i = 0; i < kPlaneTexels; ++i) heldBoard[i] = texelFetch(boards, i);
        heldBoardSurface = texelFetch(surfaces, int(push.sphereCount)).x;
    }
    if (kOneLight)
        for (int i = 0; i < kLightTexels; ++i) heldLight[i] = texelFetch(lights, i);
}

float powerOf(int i) { return kClose ? texelFetch(powers, i).x : 0.0; }
SphereHit sphereOf(vec4 sphere, int i, vec3 o, vec3 d, uint from, bool inside) {
    return hitSphere(o, d, sphere.xyz, sphere.w, powerOf(i), startOn(uint(i), from, inside), kFar, kClose);
}
// In a loop over all spheres.
SphereHit sphereAt(int i, vec3 o, vec3 d, uint from, bool inside) {
    vec4 sphere;
    if (kHeldSpheres == kHeldByAll) sphere = heldSpheres[i];
#ifdef PLUMB_BALLOT
    else if (kHeldSpheres == kHeldByLanes)
        sphere = subgroupShuffle(heldSpheres[i >> 3], uint(i & 7));
#endif
    else
        sphere = texelFetch(spheres, i);
    return sphereOf(sphere, i, o, d, from, inside);
}
// Any sphere, and its material.
vec4 sphereRecordOf(int i, out uint material) {
    vec4 record = vec4(0.0);
    if (kHeldSpheres == kHeldByAll) {
        for (int k = 0; k < kSpheres; ++k) {
            record = k == i ? heldSpheres[k] : record;
            material = k == i ? heldSurfaces[k] : material;
        }
#ifdef PLUMB_BALLOT
    } else if (kHeldSpheres == kHeldByLanes) {
        for (int k = 0; k < (kSpheres + 7) / 8; ++k) {
            vec4 other = subgroupShuffle(heldSpheres[k], uint(i & 7));
            uint otherMaterial = subgroupShuffle(heldSurfaces[k], uint(i & 7));
            record = k == i >> 3 ? other : record;
            material = k == i >> 3 ? otherMaterial : material;
        }
#endif
    } else {
        record = texelFetch(spheres, i);
        material = texelFetch(surfaces, i).x;
    }
    return record;
}

vec4 boardTexel(int i, int k) {
    vec4 texel;
    if (kOneBoard)
        texel = heldBoard[k];
    else
        texel = texelFetch(boards, i * kPlaneTexels + k);
    return texel;
}
PlaneHit boardAt(int i, vec3 o, vec3 d, uint from, bool inside) {
    return hitPlane(o, d, boardTexel(i, 0), boardTexel(i, 1), boardTexel(i, 2), boardTexel(i, 3), boardTexel(i, 4).z != 0.0,
                    startOn(push.sphereCount + uint(kOneBoard ? 0 : i), from, inside));
}

uint materialOfBoard(int i, PlaneHit hit) {
    vec4 pattern = boardTexel(i, 4);
    uint first = kOneBoard ? heldBoardSurface : texelFetch(surfaces, int(push.sphereCount) + i).x;
    bool other = pattern.x > 0.0 && otherSquare(hit.u, hit.v, pattern.x > 0.0 ? pattern.x : 1.0, pattern.y);
    return other ? uint(pattern.w) : first;
}

// The triangle's corners, by the words of its first texel.
TriangleHit triangleAt(uvec4 words, RayFrame f, bool own) {
    return hitTriangle(f, texelFetch(corners, int(words.x) * 2).xyz, texelFetch(corners, int(words.y) * 2).xyz,
                       texelFetch(corners, int(words.z) * 2).xyz, own);
}

// What an eye ray meets of the meshes.
struct EyeHit {
    float t;
    uint triangle;
};

// A box as texels of the tree have it.
bool opensFor(RayFrame frame, uvec4 low, uvec4 high, float longest) {
    return opens(entryOfBox(frame, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)),
                 exitOfBox(frame, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)), longest);
}
TriangleHit leafAt(uint leaf, RayFrame f, uint own, out uint triangle) {
    uvec4 a = texelFetch(leaves, int(leaf) * 3);
    triangle = a.w;
    return hitTriangle(f, uintBitsToFloat(a.xyz), uintBitsToFloat(texelFetch(leaves, int(leaf) * 3 + 1).xyz),
                       uintBitsToFloat(texelFetch(leaves, int(leaf) * 3 + 2).xyz), triangle == own);
}
