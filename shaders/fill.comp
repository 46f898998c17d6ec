// SPDX-License-Identifier: MIT
// Fill, shade and encode in one kernel. Eight invocations a tile of 16 x 8 pixels, one invocation 4 x 4 pixels: z and triangle of
// each pixel stay in registers while the tile's list is walked, then each pixel is shaded once and written once.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#ifdef PLUMB_SHUFFLE
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#endif
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/fill.h"
#include "shared/shade.h"
#include "shared/encode.h"
#ifdef PLUMB_VECTORS
#include "shared/vectors.h"
#endif
#include "edges.glsl"

layout(constant_id = 2) const uint kShading = 3u;  // kShadingUnlit ... kShadingPhong
layout(constant_id = 3) const bool kDiffuse = true;
layout(constant_id = 4) const bool kSpecular = true;
layout(constant_id = 5) const bool kPointLights = true;
layout(constant_id = 6) const bool kOneMaterial = false;
layout(constant_id = 7) const uint kLightCount = 0u;  // 1 to kUnrolledLights: known, and unrolled; 0: as push.lightCount says
layout(constant_id = 8) const uint kEncoding = 0u;
layout(constant_id = 9) const uint kPlanes = 0u;     // kFillPlane bits that the plane buffer holds
layout(constant_id = 10) const bool kPrior = false;  // planes hold what earlier chunks and slices drew
layout(constant_id = 11) const bool kWide = false;   // some triangle of the chunk needs the 64-bit set-up
layout(constant_id = 12) const bool kColour = true;  // write the encoded pixel
layout(constant_id = 13) const uint kWrite = 0u;     // of kPlanes: to write
#ifdef PLUMB_SHUFFLE
layout(constant_id = 14) const uint kSubgroupSize = 8u;  // 8, 16, 32 or 64: clusters of 8 share a tile
#endif

layout(constant_id = 15) const uint kPower = 0u;       // kPowerExact or kPowerSchlick
layout(constant_id = 16) const bool kAffine = false;   // attributes without perspective
layout(constant_id = 17) const uint kDepthBits = 32u;  // 32: float; 33: float of 1 - n/w; else fixed point
layout(constant_id = 18) const bool kDistantViewer = false;
layout(constant_id = 20) const bool kUnitNormals = true;  // false: as interpolated
layout(constant_id = 21) const bool kCoarse = false;      // one shaded pixel in 2 x 2
layout(constant_id = 25) const bool kOne = false;         // every list of the dispatch has one entry: no loops
layout(constant_id = 24) const uint kLightKinds = 0u;     // with kLightCount: as lightKinds() of fill.h

layout(push_constant, scalar) uniform Push { FillPush push; };
layout(binding = 1) uniform usamplerBuffer draws;
layout(binding = 2) uniform usamplerBuffer screen;
layout(binding = 3) uniform samplerBuffer carried;       // normals, or colours of vertices or faces
layout(binding = 4) uniform usamplerBuffer tileRecords;  // tile x | y << 16, first entry, entries
layout(binding = 5) uniform usamplerBuffer entries;
layout(binding = 6) uniform usamplerBuffer triangleMaterials;  // per triangle of the chunk: material, or face when flat
layout(binding = 7) uniform samplerBuffer materials;
layout(binding = 8) uniform samplerBuffer lights;
layout(binding = 9) uniform usamplerBuffer encodeTable;
layout(binding = 10, scalar) buffer Colours { uvec4 colours[]; };
layout(binding = 11, scalar) buffer Planes { uvec4 planes[]; };

#ifdef PLUMB_VECTORS                                // directions of faces or vertices; by choice only
layout(constant_id = 30) const uint kVectors = 1u;  // kVectorsFace or kVectorsVertex
layout(binding = 12) uniform samplerBuffer places;  // of each triangle of the chunk: its face's centre, relative to the eye
Toward towardEye[4];                                // of each row of pixels
Toward towardLamp[kUnrolledLights * 4u];            // 4 light + row

// Those of one triangle, corners in components 0 to 2 or all alike, to the pixels that show it.
void carryVector(inout Toward to, Toward from, Shares s, bvec4 here) {
    if (kVectors == kVectorsVertex) {
        from = Toward(shared3(s, from.x.x, from.x.y, from.x.z), shared3(s, from.y.x, from.y.y, from.y.z),
                      shared3(s, from.z.x, from.z.y, from.z.z), shared3(s, from.fade.x, from.fade.y, from.fade.z));
    }
    to = Toward(mix(to.x, from.x, here), mix(to.y, from.y, here), mix(to.z, from.z, here), mix(to.fade, from.fade, here));
}
#endif

const uint kSlotTriangle = (kPlanes & kFillPlaneZ) != 0u ? 1u : 0u;
const uint kSlotLinear = kSlotTriangle + ((kPlanes & kFillPlaneTriangle) != 0u ? 1u : 0u);
const uint kSlotNormal = kSlotLinear + ((kPlanes & kFillPlaneLinear) != 0u ? 3u : 0u);
const uint kSlotSum = kSlotNormal + ((kPlanes & kFillPlaneNormal) != 0u ? 3u : 0u);

void edgesAt(ivec2 centre, ivec2 p0, ivec2 p1, ivec2 p2, out Edges e) {
    if (kWide)
        wideEdges(p0 - centre, p1 - centre, p2 - centre, e);
    else
        narrowEdges(p0 - centre, p1 - centre, p2 - centre, e);
}

// e rounded once, at 4 pixels (x .. x + 3, y) from the block's corner.
vec4 edgeReal(int hi, int lo, int a, int b, int y) {
    ivec4 low = ivec4(lo + b * y) + ivec4(0, a, 2 * a, 3 * a);
    vec4 real = vec4(low);
    if (kWide) {
        ivec4 high = ivec4(hi) + (low >> 16);
        real = vec4(high) * 65536.0 + vec4(low & 0xffff);
    }
    return real;
}

#include "encode.glsl"

#ifdef PLUMB_SHUFFLE
uint clusterMax(uint v) {  // over the subgroup, so that loops over it are uniform
    v = max(v, subgroupShuffleXor(v, 1u));
    v = max(v, subgroupShuffleXor(v, 2u));
    v = max(v, subgroupShuffleXor(v, 4u));
    if (kSubgroupSize > 8u) v = max(v, subgroupShuffleXor(v, 8u));
    if (kSubgroupSize > 16u) v = max(v, subgroupShuffleXor(v, 16u));
    if (kSubgroupSize > 32u) v = max(v, subgroupShuffleXor(v, 32u));
    return v;
}
int tileMax(int v) {  // over the eight invocations of a tile
    v = max(v, subgroupShuffleXor(v, 1u));
    v = max(v, subgroupShuffleXor(v, 2u));
    return max(v, subgroupShuffleXor(v, 4u));
}
// Number of the lowest set bit of a mask of 8, by its float exponent (findLSB is slow here).
uint lowestBit(uint mask) { return uint((floatBitsToInt(float(int(mask & (0u - mask)))) >> 23) - 127); }
#endif

// The block of this invocation: its first pixel, where its first row lies in a plane, and whether its tile is one.
ivec2 pixel;
uint at;
bool mine;

// Of its pixels, by row; the fifth is the copy that a loop over rows works on.
ivec4 z[5];
ivec4 id[5];
ivec4 source[5], material[4];
vec4 carriedX[5], carriedY[5], carriedZ[5], weight[5];

#include "fill_shade.glsl"

// Alone in its tile, with nothing drawn before, a triangle wins wherever it covers: z > 0 is asked for only where a plane or a light's place needs it.
const bool kAsksDepth = !kOne || kPrior || kPointLights || kPlanes != 0u;

// One triangle at the 16 pixels of this invocation: q, a, b of its edges at the block's first pixel.
void cover(ivec3 q, ivec3 a, ivec3 b, ivec3 hi, ivec3 lo, DepthPlane depth, int name) {
    const ivec4 along = ivec4(0, 1, 2, 3);
    ivec4 f0 = along * a.x + q.x;
    ivec4 f1 = along * a.y + q.y;
    ivec4 f2 = along * a.z + q.z;
    [[unroll]] for (int r = 0; r < 4; ++r) {
        if (kAsksDepth) {
            vec4 e2 = kWide ? edgeReal(hi.z, lo.z, a.z, b.z, r) : vec4(f2);
            vec4 e0 = kWide ? edgeReal(hi.x, lo.x, a.x, b.x, r) : vec4(f0);
            ivec4 here = depthBits(e2, e0, depth.k1, depth.k2, depth.zc, depth.low, depth.high);
            if (kDepthBits < 32u) here = coarseDepth(here, kDepthBits);
            if (kDepthBits == kDepthStandard) here = standardDepth(here);
            // wins(): here > z, or equal and the lower triangle; both operands are bits of floats in [0, 1].
            ivec4 key = here + ivec4(lessThan(ivec4(name), id[r]));
            bvec4 win = lessThan((z[r] - key) & ~(f0 | f1 | f2), ivec4(0));
            z[r] = mix(z[r], here, win);
            id[r] = mix(id[r], ivec4(name), win);
        } else {
            id[r] = mix(ivec4(name), ivec4(0), lessThan(f0 | f1 | f2, ivec4(0)));
        }
        f0 += b.x;
        f1 += b.y;
        f2 += b.z;
    }
}

DepthPlane depthOf(uvec4 v0, uvec4 v1, uvec4 v2, Edges e) {
    return depthPlane(uintBitsToFloat(v0.z), uintBitsToFloat(v1.z), uintBitsToFloat(v2.z), e.sumE, float(e.rho.x) * 0.00390625,
                      float(e.rho.y) * 0.00390625, float(e.rho.z) * 0.00390625);
}

// One triangle set up by every invocation for its own pixels.
void drawAlone(int draw, ivec2 centre) {
    uvec4 d = texelFetch(draws, draw);
    uvec4 v0 = texelFetch(screen, int(d.x));
    uvec4 v1 = texelFetch(screen, int(d.y));
    uvec4 v2 = texelFetch(screen, int(d.z));
    Edges e;
    edgesAt(centre, ivec2(v0.xy), ivec2(v1.xy), ivec2(v2.xy), e);
    cover(e.q, e.a, e.b, e.hi, e.lo, depthOf(v0, v1, v2, e), draw + 1);
}

void main() {
    uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    // lavapipe gives each thread a contiguous half of the workgroups: interleave them so that both halves weigh the same.
    uint halfGroups = groups >> 1u;
    group = group < halfGroups ? group * 2u : group < halfGroups * 2u ? (group - halfGroups) * 2u + 1u : group;
    uint fault = 0u;
#ifdef PLUMB_SHUFFLE
    int lane = int(gl_SubgroupInvocationID & 7u);
    uint base = gl_SubgroupInvocationID & ~7u;
    uint item = group * 8u + gl_SubgroupID * (kSubgroupSize >> 3u) + (gl_SubgroupInvocationID >> 3u);
    fault |= gl_SubgroupSize != kSubgroupSize ? kFaultRange : 0u;
#else
    int lane = int(gl_LocalInvocationIndex & 7u);
    uint item = group * 8u + (gl_LocalInvocationIndex >> 3u);
#endif
    mine = item < push.tileCount;
    uvec4 tile = texelFetch(tileRecords, int(min(item, push.tileCount - 1u)));
    ivec2 corner = ivec2(tile.x & 0xffffu, tile.x >> 16u) * ivec2(kTileWidth, kTileHeight);
    ivec2 inTile = ivec2((lane & 3) * 4, (lane >> 2) * 4);
    ivec2 block = corner + inTile;
    pixel = block + ivec2(0, push.firstRow);
    ivec2 centre = pixel * kSubpixels + kHalfPixel;
    at = uint(block.y) * push.rowQuads + uint(block.x >> 2);

    [[unroll]] for (int r = 0; r < 4; ++r) {
        z[r] = kPrior ? ivec4(planes[at + uint(r) * push.rowQuads]) : ivec4(0);
        id[r] = ivec4(0);
    }

    int first = int(tile.y);
    int count = int(tile.z);
    int alone = int(texelFetch(entries, first).x);
    if (kOne) {
        drawAlone(alone, centre);
    } else {
#ifdef PLUMB_SHUFFLE
        // Eight triangles at a time, set up one a lane; each lane then walks those that touch its own 4 x 4 pixels. A lane that has
        // none left repeats one: harmless, because a triangle drawn twice changes nothing.
        ivec2 tileCentre = (corner + ivec2(0, push.firstRow)) * kSubpixels + kHalfPixel;
        uint longest = clusterMax(uint(count));
        int hiddenBelow = 0;
        uint k = 0u;
        do {
            // A triangle that covers the whole tile is nowhere further than its own lowest z, and none is nearer than its own highest:
            // both are bounds of the depth itself, so what lies behind is left out without changing a bit. Eight that are all left out, in all
            // tiles of the subgroup, cost no pixels.
            int draw;
            uvec4 v0, v1, v2;
            Edges e;
            bool seen;
            bool anySeen;
            do {
                draw = int(texelFetch(entries, first + min(int(k) + lane, count - 1)).x);
                uvec4 d = texelFetch(draws, draw);
                v0 = texelFetch(screen, int(d.x));
                v1 = texelFetch(screen, int(d.y));
                v2 = texelFetch(screen, int(d.z));
                edgesAt(tileCentre, ivec2(v0.xy), ivec2(v1.xy), ivec2(v2.xy), e);
                ivec3 least = e.q + min(e.a, 0) * (kTileWidth - 1) + min(e.b, 0) * (kTileHeight - 1);
                hiddenBelow = max(hiddenBelow, tileMax((least.x | least.y | least.z) >= 0 ? min(min(int(v0.z), int(v1.z)), int(v2.z)) : 0));
                // Not with a coarser depth, in which what lies behind may tie and be the lower triangle.
                seen = int(k) + lane < count && (kDepthBits != 32u || max(max(int(v0.z), int(v1.z)), int(v2.z)) >= hiddenBelow);
                anySeen = clusterMax(seen ? 1u : 0u) != 0u;
                k += 8u;
            } while (!anySeen && k < longest);
            DepthPlane depth = depthOf(v0, v1, v2, e);
            ivec3 most = e.q + max(e.a, 0) * 3 + max(e.b, 0) * 3;
            uint blocks = 0u;
            [[unroll]] for (int i = 0; i < 8; ++i) {
                ivec3 there = most + e.a * ((i & 3) * 4) + e.b * ((i >> 2) * 4);
                blocks |= (there.x | there.y | there.z) >= 0 ? 1u << i : 0u;
            }
            if (!seen) blocks = 0u;
            uint todo = 0u;
            [[unroll]] for (uint i = 0u; i < 8u; ++i) todo |= ((subgroupShuffle(blocks, base | i) >> lane) & 1u) << i;
            uint steps = clusterMax(uint(bitCount(todo)));
            uint step = 0u;
            do {
                uint from = base | (lowestBit(todo | 128u) & 7u);
                todo &= todo - 1u;
                ivec3 a, b, q;
                a.x = subgroupShuffle(e.a.x, from);
                a.y = subgroupShuffle(e.a.y, from);
                a.z = -a.x - a.y;
                b.x = subgroupShuffle(e.b.x, from);
                b.y = subgroupShuffle(e.b.y, from);
                b.z = -b.x - b.y;
                q.x = subgroupShuffle(e.q.x, from);
                q.y = subgroupShuffle(e.q.y, from);
                q.z = subgroupShuffle(e.q.z, from);
                DepthPlane p;
                p.k1 = subgroupShuffle(depth.k1, from);
                p.k2 = subgroupShuffle(depth.k2, from);
                p.zc = subgroupShuffle(depth.zc, from);
                p.low = subgroupShuffle(depth.low, from);
                p.high = subgroupShuffle(depth.high, from);
                cover(q + a * inTile.x + b * inTile.y, a, b, ivec3(0), ivec3(0), p, subgroupShuffle(draw, from) + 1);
                step++;
            } while (step < steps);
        } while (k < longest);
        fault |= k < longest ? kFaultLoop : 0u;
#else
        int k = 0;
        do {
            drawAlone(int(texelFetch(entries, first + min(k, count - 1)).x), centre);
            k++;
        } while (k < count);
        fault |= k < count ? kFaultLoop : 0u;
#endif
    }

    // What the visible triangles carry to the 16 pixels: one round for each distinct triangle, from the highest down.
    [[unroll]] for (int r = 0; r < 4; ++r) {
        carriedX[r] = carriedY[r] = carriedZ[r] = vec4(0.0);
        weight[r] = vec4(1.0);
        source[r] = ivec4(0);
        material[r] = ivec4(-1);
    }
#ifdef PLUMB_VECTORS
    readLamps();
    [[unroll]] for (uint i = 0u; i < kUnrolledLights; ++i) {
        [[unroll]] for (uint r = 0u; r < 4u; ++r) {
            towardEye[r] = Toward(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
            towardLamp[4u * i + r] = towardEye[r];
        }
    }
#endif
    ivec4 highestId = max(max(id[0], id[1]), max(id[2], id[3]));
    int current = kOne ? alone + 1 : max(max(highestId.x, highestId.y), max(highestId.z, highestId.w));
    int rounds = 0;
    do {
        uvec4 d = texelFetch(draws, max(current - 1, 0));
        int owner = kOneMaterial && kShading != kShadingFlat ? 0 : int(texelFetch(triangleMaterials, int(d.w)).x);
        Edges e;
        vec3 rho = vec3(0.0);
        vec3 a0 = vec3(0.0), a1 = vec3(0.0), a2 = vec3(0.0);
        vec3 w = vec3(0.0);
        vec3 flatColour = vec3(0.0);
        if (kShading == kShadingFlat) flatColour = texelFetch(carried, int(push.flatColours) + owner).xyz;
        if (kShading >= kShadingGouraud) {
            uvec4 v0 = texelFetch(screen, int(d.x));
            uvec4 v1 = texelFetch(screen, int(d.y));
            uvec4 v2 = texelFetch(screen, int(d.z));
            edgesAt(centre, ivec2(v0.xy), ivec2(v1.xy), ivec2(v2.xy), e);
            rho = vec3(e.rho) * 0.00390625;
            w = vec3(uintBitsToFloat(v0.z), uintBitsToFloat(v1.z), uintBitsToFloat(v2.z)) *
                weightScale(max(max(int(v0.z), int(v1.z)), int(v2.z)));
            if (kAffine) w = vec3(1.0);
            a0 = texelFetch(carried, int(d.x)).xyz * w.x;
            a1 = texelFetch(carried, int(d.y)).xyz * w.y;
            a2 = texelFetch(carried, int(d.z)).xyz * w.z;
        }
#ifdef PLUMB_VECTORS
        vec4 face = texelFetch(places, int(d.w));
        Place place = Place(vec4(face.x), vec4(face.y), vec4(face.z));
        if (kVectors == kVectorsVertex) {
            uvec4 c0 = texelFetch(screen, int(d.x));
            uvec4 c1 = texelFetch(screen, int(d.y));
            uvec4 c2 = texelFetch(screen, int(d.z));
            place = placeOfCorner(ivec4(c0.x, c1.x, c2.x, c2.x), ivec4(c0.y, c1.y, c2.y, c2.y),
                                  uintBitsToFloat(uvec4(c0.z, c1.z, c2.z, c2.z)), push.near, push.rayOrigin, push.rayX, push.rayY);
        }
        Toward eyeHere = eyeFrom(place);
        Toward lampsHere[kUnrolledLights];
        [[unroll]] for (uint i = 0u; i < kUnrolledLights; ++i) if (i < kLightCount) lampsHere[i] =
            lampFrom(lampPlaces[i], lampIntensities[i].w, place);
#endif
        ivec4 below = ivec4(0);
        [[unroll]] for (int r = 0; r < 4; ++r) {
            bvec4 here = kOne ? bvec4(true) : equal(id[r], ivec4(current));  // alone: what it carries beside its own pixels is not drawn
            if (kShading == kShadingFlat) {
                carriedX[r] = mix(carriedX[r], vec4(flatColour.x), here);
                carriedY[r] = mix(carriedY[r], vec4(flatColour.y), here);
                carriedZ[r] = mix(carriedZ[r], vec4(flatColour.z), here);
            }
            if (kShading >= kShadingGouraud) {
                vec4 g0 = edgeReal(e.hi.x, e.lo.x, e.a.x, e.b.x, r) + rho.x;
                vec4 g1 = edgeReal(e.hi.y, e.lo.y, e.a.y, e.b.y, r) + rho.y;
                vec4 g2 = edgeReal(e.hi.z, e.lo.z, e.a.z, e.b.z, r) + rho.z;
                carriedX[r] = mix(carriedX[r], weigh(a0.x, a1.x, a2.x, g0, g1, g2), here);
                carriedY[r] = mix(carriedY[r], weigh(a0.y, a1.y, a2.y, g0, g1, g2), here);
                carriedZ[r] = mix(carriedZ[r], weigh(a0.z, a1.z, a2.z, g0, g1, g2), here);
                if (kShading == kShadingGouraud || !kUnitNormals) weight[r] = mix(weight[r], weigh(w.x, w.y, w.z, g0, g1, g2), here);
            }
#ifdef PLUMB_VECTORS
            Shares shares = sharesOf(w.x, w.y, w.z, edgeReal(e.hi.x, e.lo.x, e.a.x, e.b.x, r) + rho.x,
                                     edgeReal(e.hi.y, e.lo.y, e.a.y, e.b.y, r) + rho.y, edgeReal(e.hi.z, e.lo.z, e.a.z, e.b.z, r) + rho.z);
            if (kSpecular) carryVector(towardEye[r], eyeHere, shares, here);
            [[unroll]] for (uint i = 0u; i < kUnrolledLights; ++i) if (i < kLightCount && lampPlaces[i].w != 0.0)
                carryVector(towardLamp[4u * i + uint(r)], lampsHere[i], shares, here);
#endif
            source[r] = mix(source[r], ivec4(d.w), here);
            material[r] = mix(material[r], ivec4(owner), here);
            below = max(below, mix(ivec4(0), id[r], lessThan(id[r], ivec4(current))));
        }
        current = max(max(below.x, below.y), max(below.z, below.w));
        rounds++;
    } while (!kOne && current != 0 && rounds < 17);

    // What the materials are made of: one round for each distinct material, and most blocks have one.
    [[unroll]] for (int r = 0; r < 4; ++r) {
        unlit[r] = Colour(vec4(0.0), vec4(0.0), vec4(0.0));
        reflects[r] = Reflectance(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    }
    if (kShading == kShadingPhong || kShading == kShadingUnlit) {
        ivec4 highest = max(max(material[0], material[1]), max(material[2], material[3]));
        current = kOneMaterial ? 0 : max(max(highest.x, highest.y), max(highest.z, highest.w));
        rounds = 0;
        do {
            int m = max(current, 0) * kMaterialTexels;
            vec4 a = texelFetch(materials, m);
            vec4 d = texelFetch(materials, m + 1);
            vec4 s = texelFetch(materials, m + 2);
            ivec4 below = ivec4(-1);
            [[unroll]] for (int r = 0; r < 4; ++r) {
                bvec4 here = kOneMaterial ? bvec4(true) : equal(material[r], ivec4(current));
                unlit[r] = Colour(mix(unlit[r].r, vec4(a.x), here), mix(unlit[r].g, vec4(a.y), here), mix(unlit[r].b, vec4(a.z), here));
                Reflectance k = reflects[r];
                reflects[r] = Reflectance(mix(k.dr, vec4(d.x), here), mix(k.dg, vec4(d.y), here), mix(k.db, vec4(d.z), here),
                                          mix(k.sr, vec4(s.x), here), mix(k.sg, vec4(s.y), here), mix(k.sb, vec4(s.z), here),
                                          mix(k.n, vec4(a.w), here), mix(k.zeroPower, vec4(d.w), here));
                below = max(below, mix(ivec4(-1), material[r], lessThan(material[r], ivec4(current))));
            }
            current = max(max(below.x, below.y), max(below.z, below.w));
            rounds++;
        } while (!kOneMaterial && !kOne && current >= 0 && rounds < 17);
    }

    fault |= shadeAndWrite();
    finish(push.statusSlot, fault);
}
