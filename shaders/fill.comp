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

// Block of this invocation.
bool mine;     // false: beyond the last tile, nothing is written
int lane;      // block of the tile, row by row
ivec2 inTile;  // its first pixel, from the tile's corner
ivec2 pixel;   // its first pixel in the frame
ivec2 centre;  // the same in subpixels, at the pixel's centre
uint at;       // index of its first row in a plane
#ifdef PLUMB_SHUFFLE
uint base;  // first invocation of the tile in the subgroup
#endif

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

// Sets up one triangle for the pixels of this invocation and draws it.
void drawAlone(int draw) {
    uvec4 d = texelFetch(draws, draw);
    uvec4 v0 = texelFetch(screen, int(d.x));
    uvec4 v1 = texelFetch(screen, int(d.y));
    uvec4 v2 = texelFetch(screen, int(d.z));
    Edges e;
    edgesAt(centre, ivec2(v0.xy), ivec2(v1.xy), ivec2(v2.xy), e);
    cover(e.q, e.a, e.b, e.hi, e.lo, depthOf(v0, v1, v2, e), draw + 1);
}

// Tile of this invocation and its list of triangles.
struct Tile {
    ivec2 corner;  // first pixel
    int first;     // first of `entries`
    int count;
};

#ifdef PLUMB_SHUFFLE
// State of the walk along a tile's list.
uint walked;      // entries of it
uint longest;     // entries of the longest list of the subgroup
int hiddenBelow;  // no pixel of the tile shows a lower z

// Triangle that this invocation has set up for all invocations of its tile.
struct Candidate {
    int draw;
    bool seen;  // false: beyond the end of the list, or hidden
    Edges e;    // at the tile's first pixel
    DepthPlane depth;
};
Candidate candidate;

// Sets up the triangles of the next eight entries, one an invocation. Goes on while they are all hidden, in all tiles of the subgroup: those
// cost no pixels.
// A triangle that covers the whole tile is nowhere further than its own lowest z, and none is nearer than its own highest: both are bounds of
// the depth itself, so what lies behind is left out without changing a bit.
void nextCandidate(Tile tile) {
    ivec2 tileCentre = (tile.corner + ivec2(0, push.firstRow)) * kSubpixels + kHalfPixel;
    uvec4 v0, v1, v2;
    bool anySeen;
    do {
        candidate.draw = int(texelFetch(entries, tile.first + min(int(walked) + lane, tile.count - 1)).x);
        uvec4 d = texelFetch(draws, candidate.draw);
        v0 = texelFetch(screen, int(d.x));
        v1 = texelFetch(screen, int(d.y));
        v2 = texelFetch(screen, int(d.z));
        edgesAt(tileCentre, ivec2(v0.xy), ivec2(v1.xy), ivec2(v2.xy), candidate.e);
        ivec3 least = candidate.e.q + min(candidate.e.a, 0) * (kTileWidth - 1) + min(candidate.e.b, 0) * (kTileHeight - 1);
        hiddenBelow = max(hiddenBelow, tileMax((least.x | least.y | least.z) >= 0 ? min(min(int(v0.z), int(v1.z)), int(v2.z)) : 0));
        // Not with a coarser depth, in which what lies behind may tie and be the lower triangle.
        candidate.seen = int(walked) + lane < tile.count && (kDepthBits != 32u || max(max(int(v0.z), int(v1.z)), int(v2.z)) >= hiddenBelow);
        anySeen = clusterMax(candidate.seen ? 1u : 0u) != 0u;
        walked += 8u;
    } while (!anySeen && walked < longest);
    candidate.depth = depthOf(v0, v1, v2, candidate.e);
}

// Returns a mask of the invocations of the tile whose candidates may touch a pixel of this invocation.
uint touching() {
    ivec3 most = candidate.e.q + max(candidate.e.a, 0) * 3 + max(candidate.e.b, 0) * 3;
    uint blocks = 0u;
    [[unroll]] for (int i = 0; i < 8; ++i) {
        ivec3 there = most + candidate.e.a * ((i & 3) * 4) + candidate.e.b * ((i >> 2) * 4);
        blocks |= (there.x | there.y | there.z) >= 0 ? 1u << i : 0u;
    }
    if (!candidate.seen) blocks = 0u;
    uint todo = 0u;
    [[unroll]] for (uint i = 0u; i < 8u; ++i) todo |= ((subgroupShuffle(blocks, base | i) >> lane) & 1u) << i;
    return todo;
}

// Draws the candidates of a mask. An invocation that has none left repeats one: harmless, because a triangle drawn twice changes nothing.
void drawCandidates(uint todo) {
    uint steps = clusterMax(uint(bitCount(todo)));
    uint step = 0u;
    do {
        uint from = base | (lowestBit(todo | 128u) & 7u);
        todo &= todo - 1u;
        ivec3 a, b, q;
        a.x = subgroupShuffle(candidate.e.a.x, from);
        a.y = subgroupShuffle(candidate.e.a.y, from);
        a.z = -a.x - a.y;
        b.x = subgroupShuffle(candidate.e.b.x, from);
        b.y = subgroupShuffle(candidate.e.b.y, from);
        b.z = -b.x - b.y;
        q.x = subgroupShuffle(candidate.e.q.x, from);
        q.y = subgroupShuffle(candidate.e.q.y, from);
        q.z = subgroupShuffle(candidate.e.q.z, from);
        DepthPlane p;
        p.k1 = subgroupShuffle(candidate.depth.k1, from);
        p.k2 = subgroupShuffle(candidate.depth.k2, from);
        p.zc = subgroupShuffle(candidate.depth.zc, from);
        p.low = subgroupShuffle(candidate.depth.low, from);
        p.high = subgroupShuffle(candidate.depth.high, from);
        cover(q + a * inTile.x + b * inTile.y, a, b, ivec3(0), ivec3(0), p, subgroupShuffle(candidate.draw, from) + 1);
        step++;
    } while (step < steps);
}

// Draws the tile's list, eight triangles at a time; returns a fault.
uint drawList(Tile tile) {
    longest = clusterMax(uint(tile.count));
    hiddenBelow = 0;
    walked = 0u;
    do {
        nextCandidate(tile);
        drawCandidates(touching());
    } while (walked < longest);
    return walked < longest ? kFaultLoop : 0u;
}
#else
// Draws the tile's list; returns a fault.
uint drawList(Tile tile) {
    int k = 0;
    do {
        drawAlone(int(texelFetch(entries, tile.first + min(k, tile.count - 1)).x));
        k++;
    } while (k < tile.count);
    return k < tile.count ? kFaultLoop : 0u;
}
#endif

// Triangle whose values are taken to the pixels that show it.
struct Carrier {
    int source;  // triangle of the chunk
    int owner;   // its material, or its face when flat
    Edges e;
    vec3 rho;         // of the edges, in pixels
    vec3 w;           // perspective weights of the corners
    vec3 a0, a1, a2;  // the corners' values times their weights
    vec3 flatColour;
};
Carrier carrier;

void readCarrier(uvec4 d) {
    carrier.source = int(d.w);
    carrier.owner = kOneMaterial && kShading != kShadingFlat ? 0 : int(texelFetch(triangleMaterials, int(d.w)).x);
    carrier.rho = vec3(0.0);
    carrier.a0 = carrier.a1 = carrier.a2 = vec3(0.0);
    carrier.w = vec3(0.0);
    carrier.flatColour = vec3(0.0);
    if (kShading == kShadingFlat) carrier.flatColour = texelFetch(carried, int(push.flatColours) + carrier.owner).xyz;
    if (kShading >= kShadingGouraud) {
        uvec4 v0 = texelFetch(screen, int(d.x));
        uvec4 v1 = texelFetch(screen, int(d.y));
        uvec4 v2 = texelFetch(screen, int(d.z));
        edgesAt(centre, ivec2(v0.xy), ivec2(v1.xy), ivec2(v2.xy), carrier.e);
        carrier.rho = vec3(carrier.e.rho) * 0.00390625;
        carrier.w = vec3(uintBitsToFloat(v0.z), uintBitsToFloat(v1.z), uintBitsToFloat(v2.z)) *
                    weightScale(max(max(int(v0.z), int(v1.z)), int(v2.z)));
        if (kAffine) carrier.w = vec3(1.0);
        carrier.a0 = texelFetch(carried, int(d.x)).xyz * carrier.w.x;
        carrier.a1 = texelFetch(carried, int(d.y)).xyz * carrier.w.y;
        carrier.a2 = texelFetch(carried, int(d.z)).xyz * carrier.w.z;
    }
}

// Values g_i = E_i / 256 of a row's pixels.
vec4 edgeOne(int r) { return edgeReal(carrier.e.hi.x, carrier.e.lo.x, carrier.e.a.x, carrier.e.b.x, r) + carrier.rho.x; }
vec4 edgeTwo(int r) { return edgeReal(carrier.e.hi.y, carrier.e.lo.y, carrier.e.a.y, carrier.e.b.y, r) + carrier.rho.y; }
vec4 edgeThree(int r) { return edgeReal(carrier.e.hi.z, carrier.e.lo.z, carrier.e.a.z, carrier.e.b.z, r) + carrier.rho.z; }

// Takes the triangle's values into those pixels of row r that show it.
void carryRow(int r, bvec4 here) {
    if (kShading == kShadingFlat) {
        carriedX[r] = mix(carriedX[r], vec4(carrier.flatColour.x), here);
        carriedY[r] = mix(carriedY[r], vec4(carrier.flatColour.y), here);
        carriedZ[r] = mix(carriedZ[r], vec4(carrier.flatColour.z), here);
    }
    if (kShading >= kShadingGouraud) {
        vec4 g0 = edgeOne(r);
        vec4 g1 = edgeTwo(r);
        vec4 g2 = edgeThree(r);
        carriedX[r] = mix(carriedX[r], weigh(carrier.a0.x, carrier.a1.x, carrier.a2.x, g0, g1, g2), here);
        carriedY[r] = mix(carriedY[r], weigh(carrier.a0.y, carrier.a1.y, carrier.a2.y, g0, g1, g2), here);
        carriedZ[r] = mix(carriedZ[r], weigh(carrier.a0.z, carrier.a1.z, carrier.a2.z, g0, g1, g2), here);
        if (kShading == kShadingGouraud || !kUnitNormals)
            weight[r] = mix(weight[r], weigh(carrier.w.x, carrier.w.y, carrier.w.z, g0, g1, g2), here);
    }
    source[r] = mix(source[r], ivec4(carrier.source), here);
    material[r] = mix(material[r], ivec4(carrier.owner), here);
}

#ifdef PLUMB_VECTORS
// Directions to the eye and to each light from a triangle: from its face's centre, or corners in components 0 to 2.
Toward eyeHere;
Toward lampsHere[kUnrolledLights];

void seeTriangle(uvec4 d) {
    vec4 face = texelFetch(places, int(d.w));
    Place place = Place(vec4(face.x), vec4(face.y), vec4(face.z));
    if (kVectors == kVectorsVertex) {
        uvec4 c0 = texelFetch(screen, int(d.x));
        uvec4 c1 = texelFetch(screen, int(d.y));
        uvec4 c2 = texelFetch(screen, int(d.z));
        place = placeOfCorner(ivec4(c0.x, c1.x, c2.x, c2.x), ivec4(c0.y, c1.y, c2.y, c2.y), uintBitsToFloat(uvec4(c0.z, c1.z, c2.z, c2.z)),
                              push.near, push.rayOrigin, push.rayX, push.rayY);
    }
    eyeHere = eyeFrom(place);
    [[unroll]] for (uint i = 0u; i < kUnrolledLights; ++i) if (i < kLightCount) lampsHere[i] =
        lampFrom(lampPlaces[i], lampIntensities[i].w, place);
}

void carryVectors(int r, bvec4 here) {
    Shares shares = sharesOf(carrier.w.x, carrier.w.y, carrier.w.z, edgeOne(r), edgeTwo(r), edgeThree(r));
    if (kSpecular) carryVector(towardEye[r], eyeHere, shares, here);
    [[unroll]] for (uint i = 0u; i < kUnrolledLights; ++i) if (i < kLightCount && lampPlaces[i].w != 0.0)
        carryVector(towardLamp[4u * i + uint(r)], lampsHere[i], shares, here);
}
#endif

void beginCarry() {
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
}

// Takes what the visible triangles carry to the 16 pixels: one round for each distinct triangle, from the highest down.
void carryVisible(int alone) {
    beginCarry();
    ivec4 highestId = max(max(id[0], id[1]), max(id[2], id[3]));
    int current = kOne ? alone + 1 : max(max(highestId.x, highestId.y), max(highestId.z, highestId.w));
    int rounds = 0;
    do {
        uvec4 d = texelFetch(draws, max(current - 1, 0));
        readCarrier(d);
#ifdef PLUMB_VECTORS
        seeTriangle(d);
#endif
        ivec4 below = ivec4(0);
        [[unroll]] for (int r = 0; r < 4; ++r) {
            bvec4 here = kOne ? bvec4(true) : equal(id[r], ivec4(current));  // alone: what it carries beside its own pixels is not drawn
            carryRow(r, here);
#ifdef PLUMB_VECTORS
            carryVectors(r, here);
#endif
            below = max(below, mix(ivec4(0), id[r], lessThan(id[r], ivec4(current))));
        }
        current = max(max(below.x, below.y), max(below.z, below.w));
        rounds++;
    } while (!kOne && current != 0 && rounds < 17);
}

// Reads what the materials are made of: one round for each distinct material, and most blocks have one.
void readMaterials() {
    ivec4 highest = max(max(material[0], material[1]), max(material[2], material[3]));
    int current = kOneMaterial ? 0 : max(max(highest.x, highest.y), max(highest.z, highest.w));
    int rounds = 0;
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

// Returns the number of this workgroup. lavapipe gives each thread a contiguous half of the workgroups, so they are interleaved: both halves
// weigh the same.
uint interleavedGroup() {
    uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint halfGroups = groups >> 1u;
    return group < halfGroups ? group * 2u : group < halfGroups * 2u ? (group - halfGroups) * 2u + 1u : group;
}

// Places this invocation's block, with what earlier dispatches left of it; returns its tile.
Tile takeBlock() {
    uint group = interleavedGroup();
#ifdef PLUMB_SHUFFLE
    lane = int(gl_SubgroupInvocationID & 7u);
    base = gl_SubgroupInvocationID & ~7u;
    uint item = group * 8u + gl_SubgroupID * (kSubgroupSize >> 3u) + (gl_SubgroupInvocationID >> 3u);
#else
    lane = int(gl_LocalInvocationIndex & 7u);
    uint item = group * 8u + (gl_LocalInvocationIndex >> 3u);
#endif
    mine = item < push.tileCount;
    uvec4 record = texelFetch(tileRecords, int(min(item, push.tileCount - 1u)));
    Tile tile = Tile(ivec2(record.x & 0xffffu, record.x >> 16u) * ivec2(kTileWidth, kTileHeight), int(record.y), int(record.z));
    inTile = ivec2((lane & 3) * 4, (lane >> 2) * 4);
    ivec2 block = tile.corner + inTile;
    pixel = block + ivec2(0, push.firstRow);
    centre = pixel * kSubpixels + kHalfPixel;
    at = uint(block.y) * push.rowQuads + uint(block.x >> 2);
    [[unroll]] for (int r = 0; r < 4; ++r) {
        z[r] = kPrior ? ivec4(planes[at + uint(r) * push.rowQuads]) : ivec4(0);
        id[r] = ivec4(0);
    }
    return tile;
}

void main() {
    uint fault = 0u;
#ifdef PLUMB_SHUFFLE
    fault |= gl_SubgroupSize != kSubgroupSize ? kFaultRange : 0u;
#endif
    Tile tile = takeBlock();
    int alone = int(texelFetch(entries, tile.first).x);
    if (kOne)
        drawAlone(alone);
    else
        fault |= drawList(tile);
    carryVisible(alone);
    [[unroll]] for (int r = 0; r < 4; ++r) {
        unlit[r] = Colour(vec4(0.0), vec4(0.0), vec4(0.0));
        reflects[r] = Reflectance(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    }
    if (kShading == kShadingPhong || kShading == kShadingUnlit) readMaterials();
    fault |= shadeAndWrite();
    finish(push.statusSlot, fault);
}
