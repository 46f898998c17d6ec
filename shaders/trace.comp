// SPDX-License-Identifier: MIT
// One invocation one sample. A path that has one child at most loops in registers; where a hit has two, the refracted one waits in the
// sample's own list (kList), which also lets a long tree go on in the next dispatch.
// Loops that end at a different place in each invocation are `while`: a divergent do..while inside another loop goes wrong on lavapipe. The outer
// loop is do..while, and so is what runs equally often in all invocations: a `while` of lavapipe runs its body once more than it has to.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#ifdef PLUMB_BALLOT
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_shuffle : require
#endif
#define PLUMB_ONE_PIXEL
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/trace.h"
#include "shared/encode.h"

layout(constant_id = 2) const uint kEncoding = 0u;
layout(constant_id = 3) const uint kPlanes = 0u;    // kTracePlane bits that the plane buffer holds
layout(constant_id = 4) const bool kColour = true;  // write the encoded sample
layout(constant_id = 5) const bool kList = false;   // some material has two children, or samples take several dispatches
layout(constant_id = 6) const bool kFar = false;    // some sphere is far for its radius
layout(constant_id = 7) const bool kCount = true;
layout(constant_id = 8) const bool kSpecular = true;
layout(constant_id = 9) const bool kPointLights = true;
layout(constant_id = 10) const bool kShadows = true;
layout(constant_id = 12) const bool kMeshes = false;
layout(constant_id = 13) const uint kSampling = kSampleGrid;
layout(constant_id = 14) const uint kSide = 1u;          // samples a pixel along an axis
layout(constant_id = 15) const bool kListed = false;     // samples of the pixels in `pixels`, kSide rows of them
layout(constant_id = 16) const bool kCutLevels = false;  // colours in whole levels
layout(constant_id = 17) const uint kJitterMirror = 0u;  // bits of the amounts of noise; 0: none
layout(constant_id = 18) const uint kJitterPass = 0u;
layout(constant_id = 19) const uint kJitterFeeler = 0u;
layout(constant_id = 11) const int kSpheres = -1;       // number of spheres where it is small, so that their loops unroll; -1: pushed
layout(constant_id = 20) const int kBoards = -1;        // the same of planes
layout(constant_id = 21) const uint kHeldSpheres = 0u;  // where the spheres' records stay: kHeldBy*
layout(constant_id = 22) const uint kFeelerBits = 32u;  // of the number of lights
layout(constant_id = 23) const uint kLanes = 8u;        // of a subgroup, kEyeTogether
layout(constant_id = 24) const bool kLights = true;
layout(constant_id = 25) const bool kChildren = true;      // some hit may send a ray on
layout(constant_id = 26) const bool kRefracts = true;      // some hit may send a refracted ray on
layout(constant_id = 27) const bool kEyeTogether = false;  // eye rays walk the tree together
layout(constant_id = 28) const bool kTiles = false;        // neighbours are tiles of 4 x 2 samples
layout(constant_id = 29) const bool kDeep = false;         // the tree is deeper than kLanes
layout(constant_id = 30) const bool kLongPaths = true;     // paths may be longer than kLanes
layout(constant_id = 31) const uint kTurns = 1u;   // samples of an invocation one after another, every other row of a tile; with kTiles
layout(constant_id = 32) const bool kDims = true;  // some material lets a feeler through
layout(constant_id = 33) const bool kOneLight = false;
layout(constant_id = 34) const bool kOneBoard = false;  // its record stays in registers
layout(constant_id = 35) const bool kClose = false;     // the surface of some sphere is close to the eye

layout(push_constant, scalar) uniform Push { TracePush push; };
layout(binding = 1) uniform samplerBuffer spheres;    // centre, radius
layout(binding = 2) uniform samplerBuffer boards;     // kPlaneTexels each
layout(binding = 3) uniform usamplerBuffer surfaces;  // material of each object: spheres, then planes
layout(binding = 4) uniform samplerBuffer materials;
layout(binding = 5) uniform samplerBuffer lights;
layout(binding = 6) uniform usamplerBuffer encodeTable;
layout(binding = 7, scalar) writeonly buffer Colours { uint colours[]; };
layout(binding = 8, scalar) writeonly buffer Planes { uint planes[]; };
layout(binding = 9, scalar) buffer Counters { uint counters[]; };
layout(binding = 10, scalar) buffer Waiting { uint waiting[]; };
layout(binding = 11, scalar) buffer States { uint states[]; };
layout(binding = 12) uniform usamplerBuffer nodes;
layout(binding = 13) uniform usamplerBuffer triangles;
layout(binding = 14) uniform samplerBuffer corners;
layout(binding = 15) uniform usamplerBuffer pixels;  // x | y << 16, kListed
layout(binding = 16) uniform usamplerBuffer leaves;
layout(binding = 17) uniform samplerBuffer powers;  // of the eye, kClose

const uint kHeldByAll = 1u;                        // by each invocation
const uint kHeldByLanes = 2u;                      // by invocation i modulo 8 of a subgroup
const float kNoInverse = 2.305843009213693952e18;  // 2^61: beyond every inverse direction
const uint kMostSteps = 30000u;                    // of a walk: half of what lavapipe's loops take
// Functions, since glslang computes such a constant in the first function that reads it, where others do not see it.
bool hasKeys() { return kSampling == kSampleRandom || (kJitterMirror | kJitterPass | kJitterFeeler) != 0u; }
const uint kLevels = kCutLevels ? kRayDepthLimit : 1u;

const uint kSlotObject = (kPlanes & kTracePlaneDistance) != 0u ? 1u : 0u;
const uint kSlotLinear = kSlotObject + ((kPlanes & kTracePlaneObject) != 0u ? 1u : 0u);
const uint kSlotNormal = kSlotLinear + ((kPlanes & kTracePlaneLinear) != 0u ? 3u : 0u);

uint fault = 0u;

int sphereCount() { return kSpheres >= 0 ? kSpheres : int(push.sphereCount); }
int boardCount() { return kBoards >= 0 ? kBoards : int(push.planeCount); }

// Whether a subgroup's invocations all follow its longest path, so that they may ask each other; those whose own has ended change nothing.
bool together() {
#ifdef PLUMB_BALLOT
    return !kList;
#else
    return false;
#endif
}

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

#ifdef PLUMB_BALLOT
// Over all invocations of a subgroup, which all run along.
float leastOf(float x) {
    x = lesser(x, subgroupShuffleXor(x, 1u));
    x = lesser(x, subgroupShuffleXor(x, 2u));
    x = lesser(x, subgroupShuffleXor(x, 4u));
    if (kLanes > 8u) x = lesser(x, subgroupShuffleXor(x, 8u));
    if (kLanes > 16u) x = lesser(x, subgroupShuffleXor(x, 16u));
    if (kLanes > 32u) x = lesser(x, subgroupShuffleXor(x, 32u));
    if (kLanes > 64u) x = lesser(x, subgroupShuffleXor(x, 64u));
    return x;
}
float mostOf(float x) { return -leastOf(-x); }
uint sumOf(uint x) {
    x += subgroupShuffleXor(x, 1u);
    x += subgroupShuffleXor(x, 2u);
    x += subgroupShuffleXor(x, 4u);
    if (kLanes > 8u) x += subgroupShuffleXor(x, 8u);
    if (kLanes > 16u) x += subgroupShuffleXor(x, 16u);
    if (kLanes > 32u) x += subgroupShuffleXor(x, 32u);
    if (kLanes > 64u) x += subgroupShuffleXor(x, 64u);
    return x;
}
uint allBitsOf(uint x) {
    x |= subgroupShuffleXor(x, 1u);
    x |= subgroupShuffleXor(x, 2u);
    x |= subgroupShuffleXor(x, 4u);
    if (kLanes > 8u) x |= subgroupShuffleXor(x, 8u);
    if (kLanes > 16u) x |= subgroupShuffleXor(x, 16u);
    if (kLanes > 32u) x |= subgroupShuffleXor(x, 32u);
    if (kLanes > 64u) x |= subgroupShuffleXor(x, 64u);
    return x;
}
// Octant that a ray points into: a bit for each component of its direction that is negative.
uint octantOf(RayFrame f) { return (f.inverse.x < 0.0 ? 1u : 0u) | (f.inverse.y < 0.0 ? 2u : 0u) | (f.inverse.z < 0.0 ? 4u : 0u); }
EyeHit nearerOf(EyeHit best, float t, uint triangle, bool met) {
    bool nearer = met && isNearer(t, triangle, best.t, best.triangle);
    best.t = nearer ? t : best.t;
    best.triangle = nearer ? triangle : best.triangle;
    return best;
}
// Eye rays of neighbouring pixels, all invocations together: each looks at one child of the same node and asks whether any of the rays may meet
// it. The way back stands in the invocations too, a level in each: node << 8 | children that still wait. Every trip is the same for all, so the
// loops are do..while.
// One walk serves the rays of one octant. The inverse directions of rays on both sides of an axis enclose 0, and a box then excludes nothing along
// that axis: a tile with rays on both sides of two axes would open the whole tree.
void nearestOfEyeRays(vec3 d, vec3 d2, bool any, out EyeHit best, out EyeHit best2) {
    best = EyeHit(kFarthestHit, kNoObject);
    best2 = best;
    vec3 o = vec3(0.0);
    RayFrame frame = frameOfRay(o, d, push.reach);
    RayFrame frame2 = frameOfRay(o, d2, push.reach);
    uint octant = octantOf(frame);
    uint octant2 = kTurns == 2u ? octantOf(frame2) : octant;
    uint octants = allBitsOf(1u << octant | 1u << octant2);  // not walked yet
    uint lane = gl_SubgroupInvocationID;
    int child = int(lane & (kNodeChildren - 1u));
    uint steps = 0u;
    do {
        uint walked = uint(findLSB(octants));
        octants &= octants - 1u;
        bool mine = octant == walked;
        bool mine2 = kTurns == 2u && octant2 == walked;
        vec3 least = mine ? frame.inverse : vec3(kNoInverse);
        vec3 most = mine ? frame.inverse : vec3(-kNoInverse);
        if (kTurns == 2u) {
            least = mine2 ? lesser3(least, frame2.inverse) : least;
            most = mine2 ? greater3(most, frame2.inverse) : most;
        }
        RayBundle bundle = RayBundle(o, vec3(leastOf(least.x), leastOf(least.y), leastOf(least.z)),
                                     vec3(mostOf(most.x), mostOf(most.y), mostOf(most.z)), frame.pad);
        float longest = kFarthestHit;
        uint node = kTopNode;
        uint asked = 0xffu;
        uint back = 0u;
        uint further = 0u;  // levels from kLanes on
        uint level = 0u;
        bool done = !any;
        do {
            uint met = 0u;
            uint link = 0u;
            do {
                int at = (int(node * kNodeChildren) + child) * 2;
                uvec4 low = texelFetch(nodes, at);
                uvec4 high = texelFetch(nodes, at + 1);
                link = low.w;
                vec3 from = uintBitsToFloat(low.xyz);
                vec3 to = uintBitsToFloat(high.xyz);
                bool open = !done && link != kNoChild && lane < kNodeChildren &&
                            opens(earliestEntry(bundle, from, to), latestExit(bundle, from, to), longest);
                uint opened = sumOf((asked >> uint(child) & (open ? 1u : 0u)) << (link >= kLeaf ? uint(child) + 16u : uint(child)));
                met = opened >> 16;
                uint inner = opened & 0xffffu;
                uint rest = inner & (inner - 1u);
                back = rest != 0u && lane == level ? node << 8 | rest : back;
                if (kDeep) further = rest != 0u && lane + kLanes == level ? node << 8 | rest : further;
                level += rest != 0u ? 1u : 0u;
                bool up = inner == 0u;
                done = done || (up && level == 0u);
                level -= up && level > 0u ? 1u : 0u;
                uint next = subgroupShuffle(back, level & (kLanes - 1u));
                if (kDeep) next = level < kLanes ? next : subgroupShuffle(further, level & (kLanes - 1u));
                uint first = subgroupShuffle(link, uint(findLSB(inner | kNodeChildren << 8)) & (kNodeChildren - 1u));
                node = up ? next >> 8 : first;
                asked = up ? next & 0xffu : 0xffu;
                steps++;
            } while (met == 0u && !done && steps < kMostSteps);
            do {
                uint leaf = subgroupShuffle(link, uint(findLSB(met | kNodeChildren << 8)) & (kNodeChildren - 1u)) & ~kLeaf;
                leaf = met != 0u ? leaf : 0u;
                uvec4 a = texelFetch(leaves, int(leaf) * 3);
                vec3 p0 = uintBitsToFloat(a.xyz);
                vec3 p1 = uintBitsToFloat(texelFetch(leaves, int(leaf) * 3 + 1).xyz);
                vec3 p2 = uintBitsToFloat(texelFetch(leaves, int(leaf) * 3 + 2).xyz);
                best = nearerOf(best, hitTriangle(frame, p0, p1, p2, false).t, a.w, met != 0u);
                if (kTurns == 2u) best2 = nearerOf(best2, hitTriangle(frame2, p0, p1, p2, false).t, a.w, met != 0u);
                met &= met - 1u;
                steps++;
            } while (met != 0u);
            float farther = mine ? best.t : 0.0;
            if (kTurns == 2u) farther = mine2 ? greater(farther, best2.t) : farther;
            longest = mostOf(farther);
        } while (!done && steps < kMostSteps);
        fault |= !done ? kFaultLoop : 0u;
    } while (octants != 0u);
}
#endif

float shareThatPasses(uint material) { return kDims ? texelFetch(materials, int(material) * kTraceMaterialTexels + 3).y : 0.0; }

void countRay(uint depth, uint kind, uint feelers, uint undecided) {
    uint first = (depth - 1u) * kCountKinds;
    atomicAdd(counters[first + kind], 1u);
    if (feelers > 0u) atomicAdd(counters[first + kCountFeelers], feelers);
    if (undecided > 0u) atomicAdd(counters[kCountUndecided], undecided);
}
#ifdef PLUMB_BALLOT
// Without a list all invocations of a subgroup are at the same depth: the counts of depth n gather in invocation n - 1.
uvec3 gathered = uvec3(0u);  // rays, refracted ones among them, feelers
uint lost = 0u;              // undecided
void addCounts(uint depth, uvec3 counted) {
    uint first = (depth - 1u) * kCountKinds;
    if (counted.x > counted.y) atomicAdd(counters[first + (depth == 1u ? kCountPrimary : kCountReflected)], counted.x - counted.y);
    if (kRefracts && counted.y > 0u) atomicAdd(counters[first + kCountRefracted], counted.y);
    if (kLights && counted.z > 0u) atomicAdd(counters[first + kCountFeelers], counted.z);
}
// All invocations of a subgroup run along, with zeros where they have no ray.
void gather(uint depth, uint rays, uint refractedRays, uint feelers, uint undecided) {
    uvec3 counted = uvec3(sumOf(rays), kRefracts ? sumOf(refractedRays) : 0u, kLights ? sumOf(feelers) : 0u);
    if (kLongPaths && depth > kLanes) {
        if (gl_SubgroupInvocationID == 0u) addCounts(depth, counted);
    } else {
        gathered += gl_SubgroupInvocationID == depth - 1u ? counted : uvec3(0u);
    }
    lost += undecided;
}
void addGathered() {
    addCounts(gl_SubgroupInvocationID + 1u, gathered);
    if (kBoards != 0) {
        uint all = sumOf(lost);
        if (gl_SubgroupInvocationID == 0u && all > 0u) atomicAdd(counters[kCountUndecided], all);
    }
}
#endif

bool goesOn(bool alive) {
    bool on = alive;
#ifdef PLUMB_BALLOT
    if (together()) on = sumOf(alive ? 1u : 0u) != 0u;
#endif
    return on;
}

uint encode(float x) {
    int code;
    if (kEncoding == kEncodeLinear) {
        code = encodeLinear(x);
    } else {
        float clamped = clampUnit(x);
        code = encodeInBucket(clamped, int(texelFetch(encodeTable, encodeBucket(clamped)).x));
    }
    return uint(code);
}

// Column and row of a sample in the frame.
uvec2 placeOf(uint column, uint row) {
    uvec2 place = uvec2(column, row);
    if (kListed) {
        uint pixel = texelFetch(pixels, int(column / kSide)).x;
        place = uvec2((pixel & 0xffffu) * kSide + column % kSide, (pixel >> 16) * kSide + row);
    }
    return place;
}
uint keyAt(uvec2 place) { return hasKeys() ? keyOfSample(place.x, place.y, push.seed) : 0u; }
vec3 eyeDirection(uvec2 place) {
    uint key = keyAt(place);
    return primaryDirection(push.rayOrigin, push.rayX, push.rayY, columnOf(kSampling, place.x, kSide, key),
                            rowOf(kSampling, place.y, kSide, key));
}

// A sample of this dispatch, from the eye to what it leaves.
void traceSample(uint item, uint column, uint row, bool mine, EyeHit eye) {
    uint word = (row - push.firstRow) * push.rowWords + column;
    int lightCount = int(push.lightCount);
    vec3 o = vec3(0.0);
    uint key = keyAt(placeOf(column, row));
    vec3 d = eyeDirection(placeOf(column, row));
    vec4 levels[kLevels];  // of each ray: its own part of the colour, the share of what it is followed by
    float weight = 1.0;
    uint from = kNoObject;
    bool inside = false;
    uint depth = 1u;
    uint kind = kCountPrimary;
    vec3 colour = vec3(0.0);
    uint waits = 0u;
    bool alive = mine;
    uint primaryBits = 0u;
    if (kList && push.first == 0u) {
        uint state = item * kStateWords;
        colour = vec3(uintBitsToFloat(states[state]), uintBitsToFloat(states[state + 1u]), uintBitsToFloat(states[state + 2u]));
        waits = states[state + 3u];
        primaryBits = waits >> 31;
        waits &= 0x7fffffffu;
        alive = mine && waits > 0u;
    }
    bool begun = alive;
    bool take = kList && push.first == 0u;  // the next ray comes from the list
    uint rays = 0u;
    uint trips = 0u;
    do {
        bool runs = alive;
        bool bent = kind == kCountRefracted;
        uint feelers = 0u;
        uint undecided = 0u;
        if (alive || together()) {
            rays += runs ? 1u : 0u;
            if (kList && take) {
                waits--;
                uint at = (waits * push.itemCount + item) * kWaitingWords;
                o = vec3(uintBitsToFloat(waiting[at]), uintBitsToFloat(waiting[at + 1u]), uintBitsToFloat(waiting[at + 2u]));
                d = vec3(uintBitsToFloat(waiting[at + 3u]), uintBitsToFloat(waiting[at + 4u]), uintBitsToFloat(waiting[at + 5u]));
                weight = uintBitsToFloat(waiting[at + 6u]);
                from = waiting[at + 7u];
                uint packed = waiting[at + 8u];
                key = waiting[at + 9u];
                inside = (packed & 1u) != 0u;
                kind = (packed >> 1) & 3u;
                depth = packed >> 3;
            }
            float t = kFarthestHit;
            uint best = kNoObject;
            int i = 0;
            [[unroll]] for (i = 0; i < sphereCount(); ++i) {
                SphereHit hit = sphereAt(i, o, d, from, inside);
                bool nearer = isNearer(hit.t, uint(i), t, best);
                t = nearer ? hit.t : t;
                best = nearer ? uint(i) : best;
            }
            fault |= i < sphereCount() ? kFaultLoop : 0u;
            for (i = 0; i < boardCount(); ++i) {
                PlaneHit hit = boardAt(i, o, d, from, inside);
                bool nearer = isNearer(hit.t, push.sphereCount + uint(i), t, best);
                t = nearer ? hit.t : t;
                best = nearer ? push.sphereCount + uint(i) : best;
                undecided += hit.undecided;
            }
            fault |= i < boardCount() ? kFaultLoop : 0u;
            uint firstTriangle = push.sphereCount + push.planeCount;
            RayFrame frame;
            int children = int(push.childCount);
            if (kMeshes) {
                frame = frameOfRay(o, d, push.reach);
                int child = runs ? 0 : children;
                if (kEyeTogether && rays == 1u && push.first != 0u) {
                    bool nearer = eye.triangle != kNoObject && isNearer(eye.t, firstTriangle + eye.triangle, t, best);
                    t = nearer ? eye.t : t;
                    best = nearer ? firstTriangle + eye.triangle : best;
                    child = children;
                }
                if (!kEyeTogether || kChildren || kList) {
                    while (child < children) {
                        uint link = 0u;
                        while (child < children && link < kLeaf) {
                            uvec4 low = texelFetch(nodes, child * 2);
                            uvec4 high = texelFetch(nodes, child * 2 + 1);
                            bool open = opensFor(frame, low, high, t);
                            link = open ? low.w : 0u;
                            child = open && link < kLeaf ? int(link * kNodeChildren) : int(high.w);
                        }
                        uint triangle;
                        TriangleHit hit = leafAt(link >= kLeaf ? link & ~kLeaf : 0u, frame, from - firstTriangle, triangle);
                        bool nearer = link >= kLeaf && isNearer(hit.t, firstTriangle + triangle, t, best);
                        t = nearer ? hit.t : t;
                        best = nearer ? firstTriangle + triangle : best;
                    }
                    fault |= child < children ? kFaultLoop : 0u;
                }
            }
            bool hits = runs && best != kNoObject;
            bool ball = best < push.sphereCount;
            bool mesh = kMeshes && hits && best >= firstTriangle;
            int sphere = ball ? int(best) : 0;
            int board = hits && !ball && !mesh ? int(best - push.sphereCount) : 0;

            SurfacePoint s = SurfacePoint(vec3(0.0), vec3(0.0), vec3(0.0));
            uint material = 0u;
            if (kBoards != 0) {
                PlaneHit onBoard = boardAt(board, o, d, from, inside);
                s = pointOnPlane(boardTexel(board, 0).xyz, onBoard.point);
                material = materialOfBoard(board, onBoard);
            }
            if (kSpheres != 0) {
                uint sphereMaterial = 0u;
                vec4 sphereRecord = sphereRecordOf(sphere, sphereMaterial);
                SphereHit again = sphereOf(sphereRecord, sphere, o, d, from, inside);
                SurfacePoint onSphere = pointOnSphere(sphereRecord.xyz, sphereRecord.w, again.offset);
                if (kClose) onSphere = pointOnCloseSphere(o, d, again.t, sphereRecord.xyz, sphereRecord.w, powerOf(sphere), again.offset);
                s.point = ball ? onSphere.point : s.point;
                s.normal = ball ? onSphere.normal : s.normal;
                s.error = ball ? onSphere.error : s.error;
                material = ball ? sphereMaterial : material;
            }
            vec3 smoothNormal = s.normal;
            if (kMeshes) {
                int triangle = mesh ? int(best - firstTriangle) : 0;
                uvec4 words = texelFetch(triangles, triangle * 2);
                TriangleHit hit = triangleAt(words, frame, false);
                vec3 geometric = uintBitsToFloat(texelFetch(triangles, triangle * 2 + 1).xyz);
                SurfacePoint onMesh = pointOnTriangle(texelFetch(corners, int(words.x) * 2).xyz, texelFetch(corners, int(words.y) * 2).xyz,
                                                      texelFetch(corners, int(words.z) * 2).xyz, geometric, hit);
                vec3 interpolated = unitLength(
                    (texelFetch(corners, int(words.x) * 2 + 1).xyz * hit.w0 + texelFetch(corners, int(words.y) * 2 + 1).xyz * hit.w1) +
                    texelFetch(corners, int(words.z) * 2 + 1).xyz * hit.w2);
                s.point = mesh ? onMesh.point : s.point;
                s.normal = mesh ? onMesh.normal : s.normal;
                s.error = mesh ? onMesh.error : s.error;
                smoothNormal = mesh ? interpolated : s.normal;
                material = mesh ? words.w : material;
            }
            bool within = dot3(d, s.normal) > 0.0;
            vec3 n = within ? -s.normal : s.normal;
            vec3 seen = n;
            vec3 bends = n;
            if (kMeshes) {
                seen = mesh ? (within ? -smoothNormal : smoothNormal) : n;
                if (kChildren) bends = mesh ? normalForRays(d, n, seen) : n;
            }

            int at = int(material) * kTraceMaterialTexels;
            vec4 base = texelFetch(materials, at);
            vec4 diffuse = texelFetch(materials, at + 1);
            vec4 specular = texelFetch(materials, at + 2);
            vec4 shares = texelFetch(materials, at + 3);

            // Local colour: Phong, each light dimmed by what its feeler meets.
            bool local = hits && specular.w > 0.0;
            Colour c = Colour(base.x, base.y, base.z);
            Surface surface = Surface(seen.x, seen.y, seen.z, -d.x, -d.y, -d.z, s.point.x, s.point.y, s.point.z);
            Reflectance k = Reflectance(diffuse.x, diffuse.y, diffuse.z, specular.x, specular.y, specular.z, base.w, diffuse.w);
            ShadeParts parts = ShadeParts(true, kSpecular, kPointLights, kPowerExact);
            vec3 q = leaveSurface(s.point, n, s.error);
            int light = 0;
            if (kLights) do {
                    bool lit = local && light < lightCount;
                    if (lit || together()) {
                        vec4 lightPlace;
                        vec4 intensity;
                        if (kOneLight) {
                            lightPlace = heldLight[0];
                            intensity = heldLight[1];
                        } else {
                            lightPlace = texelFetch(lights, light * kLightTexels);
                            intensity = texelFetch(lights, light * kLightTexels + 1);
                        }
                        Feeler feeler = feelerTo(lightPlace, q);
                        bool above = dot3(seen, feeler.direction) > 0.0 && dot3(n, feeler.direction) > 0.0;
                        feelers += lit && above ? 1u : 0u;
                        if (kJitterFeeler != 0u)
                            feeler.direction = jittered(feeler.direction, n, uintBitsToFloat(kJitterFeeler),
                                                        keyOfChild(key, kFirstFeelerKey + uint(light)));
                        float passed = 1.0;
                        if (kShadows) {
                            [[unroll]] for (i = 0; i < sphereCount(); ++i) {
                                SphereHit hit = sphereAt(i, q, feeler.direction, best, within);
                                passed *= blocks(hit.t, feeler.reach) ? (kDims ? shareThatPasses(texelFetch(surfaces, i).x) : 0.0) : 1.0;
                            }
                            fault |= i < sphereCount() ? kFaultLoop : 0u;
                            for (i = 0; i < boardCount(); ++i) {
                                PlaneHit hit = boardAt(i, q, feeler.direction, best, within);
                                passed *= blocks(hit.t, feeler.reach) ? (kDims ? shareThatPasses(materialOfBoard(i, hit)) : 0.0) : 1.0;
                            }
                            fault |= i < boardCount() ? kFaultLoop : 0u;
                            if (kMeshes) {
                                RayFrame along = frameOfRay(q, feeler.direction, push.reach);
                                int child = 0;
                                while (lit && above && passed > 0.0 && child < children) {
                                    uint link = 0u;
                                    while (child < children && link < kLeaf) {
                                        uvec4 low = texelFetch(nodes, child * 2);
                                        uvec4 high = texelFetch(nodes, child * 2 + 1);
                                        bool open = opensFor(along, low, high, feeler.reach);
                                        link = open ? low.w : 0u;
                                        child = open && link < kLeaf ? int(link * kNodeChildren) : int(high.w);
                                    }
                                    uint triangle;
                                    TriangleHit hit = leafAt(link >= kLeaf ? link & ~kLeaf : 0u, along, best - firstTriangle, triangle);
                                    uint owner = texelFetch(triangles, int(triangle) * 2).w;
                                    float slope = dot3(feeler.direction, uintBitsToFloat(texelFetch(triangles, int(triangle) * 2 + 1).xyz));
                                    bool met = link >= kLeaf && blocks(hit.t, feeler.reach);
                                    passed *= met ? passesTriangle(shareThatPasses(owner), slope) : 1.0;
                                }
                                fault |= lit && above && passed > 0.0 && child < children ? kFaultLoop : 0u;
                            }
                        }
                        passed = above ? passed : 0.0;
                        addLight(lightPlace, vec4(intensity.xyz * passed, intensity.w), surface, k, parts, c);
                    }
                    light++;
                } while (!kOneLight && light < lightCount);
            fault |= kLights && local && light < lightCount ? kFaultLoop : 0u;
            float share = weight * specular.w;
            vec3 added = vec3(c.r, c.g, c.b) * share;
            added = hits ? (local ? added : vec3(0.0)) : push.sky * weight;
            colour = runs ? colour + added : colour;
            if (kCutLevels) {
                vec3 own = hits ? wholeLevels(vec3(c.r, c.g, c.b)) * specular.w : wholeLevels(push.sky);
                levels[depth - 1u] = vec4(local || !hits ? own : vec3(0.0), hits ? shares.x : 0.0);
            }

            if (kCount && !together()) countRay(depth, kind, feelers, undecided);
            if (runs && rays == 1u && push.first != 0u) {
                primaryBits = hits ? 1u : 0u;
                if ((kPlanes & kTracePlaneDistance) != 0u) planes[word] = hits ? floatBitsToUint(t) : 0u;
                if ((kPlanes & kTracePlaneObject) != 0u) planes[word + kSlotObject * push.planeWords] = best;
                if ((kPlanes & kTracePlaneNormal) != 0u) {
                    planes[word + kSlotNormal * push.planeWords] = hits ? floatBitsToUint(seen.x) : 0u;
                    planes[word + (kSlotNormal + 1u) * push.planeWords] = hits ? floatBitsToUint(seen.y) : 0u;
                    planes[word + (kSlotNormal + 2u) * push.planeWords] = hits ? floatBitsToUint(seen.z) : 0u;
                }
            }

            Children next =
                childrenOf(d, bends, within, shares.x, shares.y, shares.z, shares.w, weight, depth, push.maxDepth, push.minWeight);
            if (kMeshes && kRefracts) next.passDirection = mesh ? onSideOf(next.passDirection, -n, leastSlope(d, n)) : next.passDirection;
            bool mirror = kChildren && hits && next.mirror;
            bool pass = kRefracts && hits && next.pass;
            if (!kList) fault |= mirror && pass ? kFaultRange : 0u;
            if (kJitterMirror != 0u)
                next.mirrorDirection = jittered(next.mirrorDirection, n, uintBitsToFloat(kJitterMirror), keyOfChild(key, kCountReflected));
            if (kJitterPass != 0u)
                next.passDirection = jittered(next.passDirection, n, uintBitsToFloat(kJitterPass), keyOfChild(key, kCountRefracted));
            depth++;
            vec3 behind = leaveSurface(s.point, -n, s.error);
            if (kList && pass) {
                uint slot = (waits * push.itemCount + item) * kWaitingWords;
                waiting[slot] = floatBitsToUint(behind.x);
                waiting[slot + 1u] = floatBitsToUint(behind.y);
                waiting[slot + 2u] = floatBitsToUint(behind.z);
                waiting[slot + 3u] = floatBitsToUint(next.passDirection.x);
                waiting[slot + 4u] = floatBitsToUint(next.passDirection.y);
                waiting[slot + 5u] = floatBitsToUint(next.passDirection.z);
                waiting[slot + 6u] = floatBitsToUint(next.passWeight);
                waiting[slot + 7u] = best;
                waiting[slot + 8u] = depth << 3 | kCountRefracted << 1 | (within ? 0u : 1u);
                waiting[slot + 9u] = hasKeys() ? keyOfChild(key, kCountRefracted) : 0u;
                waits++;
            }
            bool onward = mirror || (!kList && pass);
            bool back = !kRefracts || mirror;
            o = back ? q : behind;
            d = back ? next.mirrorDirection : next.passDirection;
            weight = back ? next.mirrorWeight : next.passWeight;
            kind = back ? kCountReflected : kCountRefracted;
            if (hasKeys()) key = keyOfChild(key, kind);
            from = best;
            inside = back ? within : !within;
            take = !onward;
            alive = runs && (onward || (kList && waits > 0u));
        }
        trips++;
#ifdef PLUMB_BALLOT
        if (kCount && together()) gather(trips, runs ? 1u : 0u, runs && bent ? 1u : 0u, feelers, runs ? undecided : 0u);
#endif
    } while ((kChildren || kList) && trips < push.rayLimit && goesOn(alive));
    if (kList && begun && alive) {
        // The limit of this dispatch: the current ray waits too, on top.
        if (!take) {
            uint slot = (waits * push.itemCount + item) * kWaitingWords;
            waiting[slot] = floatBitsToUint(o.x);
            waiting[slot + 1u] = floatBitsToUint(o.y);
            waiting[slot + 2u] = floatBitsToUint(o.z);
            waiting[slot + 3u] = floatBitsToUint(d.x);
            waiting[slot + 4u] = floatBitsToUint(d.y);
            waiting[slot + 5u] = floatBitsToUint(d.z);
            waiting[slot + 6u] = floatBitsToUint(weight);
            waiting[slot + 7u] = from;
            waiting[slot + 8u] = depth << 3 | kind << 1 | (inside ? 1u : 0u);
            waiting[slot + 9u] = key;
            waits++;
        }
        atomicAdd(counters[kCountUnfinished], 1u);
    }
    if (!kList) fault |= alive ? kFaultLoop : 0u;
    if (kCutLevels) {
        colour = vec3(0.0);
        while (rays > 0u) {
            rays--;
            colour = cutLevels(colour * levels[rays].w, levels[rays].xyz);
        }
        colour = colour * kOneLevel;
    }
    if (kList && mine) {
        uint state = item * kStateWords;
        states[state] = floatBitsToUint(colour.x);
        states[state + 1u] = floatBitsToUint(colour.y);
        states[state + 2u] = floatBitsToUint(colour.z);
        states[state + 3u] = (begun && alive ? waits : 0u) | primaryBits << 31;
    }
    if (begun && !alive) {
        if (kColour) {
            uint drawn = encode(colour.x) | (encode(colour.y) << 8) | (encode(colour.z) << 16) | 0xff000000u;
            colours[word] = primaryBits != 0u ? drawn : push.background & 0xffffffu;
        }
        if ((kPlanes & kTracePlaneLinear) != 0u) {
            planes[word + kSlotLinear * push.planeWords] = floatBitsToUint(colour.x);
            planes[word + (kSlotLinear + 1u) * push.planeWords] = floatBitsToUint(colour.y);
            planes[word + (kSlotLinear + 2u) * push.planeWords] = floatBitsToUint(colour.z);
        }
    }
}

void main() {
    // Every other workgroup: threads of lavapipe take halves of the workgroups, and a half of a picture may be sky.
    uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint half_ = (groups + 1u) >> 1u;
    group = group < half_ ? group * 2u : (group - half_) * 2u + 1u;
    uint item = group * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
    hold();
    bool mine = item < push.itemCount;
    item = min(item, push.itemCount - 1u);
    uint column = 0u;
    uint row = 0u;  // of the dispatch, kTiles, or of the frame
    uint rows = 0xffffffffu;
    uint firstRow = 0u;
    if (kTiles) {
        uint tile = item >> 3u;
        uint across = (push.width + 3u) >> 2u;
        uint down = tile / across;
        column = (tile - down * across) * 4u + (item & 3u);
        row = down * 2u * kTurns + ((item >> 2u) & 1u);
        mine = mine && column < push.width;
        column = min(column, push.width - 1u);
        firstRow = push.firstItem / push.width;
        rows = push.tileRows;
    } else {
        uint place = push.firstItem + item;
        row = place / push.width;
        column = place - row * push.width;
    }
    EyeHit eye = EyeHit(kFarthestHit, kNoObject);
    EyeHit eye2 = eye;
#ifdef PLUMB_BALLOT
    if (kEyeTogether) {
        uvec2 place = placeOf(column, firstRow + min(row, rows - 1u));
        nearestOfEyeRays(eyeDirection(place), eyeDirection(kTurns == 2u ? placeOf(column, firstRow + min(row + 2u, rows - 1u)) : place),
                         push.first != 0u, eye, eye2);
    }
#endif
    uint turn = 0u;
    do {
        uint mineRow = row + 2u * turn;
        EyeHit seen = EyeHit(turn == 1u ? eye2.t : eye.t, turn == 1u ? eye2.triangle : eye.triangle);
        traceSample(item, column, firstRow + min(mineRow, rows - 1u), mine && mineRow < rows, seen);
        turn++;
    } while (turn < kTurns);
#ifdef PLUMB_BALLOT
    if (kCount && together()) addGathered();
#endif
    finish(push.statusSlot, fault);
}
