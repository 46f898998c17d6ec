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

// The parts of a sample's path share what they know in variables of the file: a struct that goes from function to function by value is more
// words in the module.
// Ray that is followed now.
struct PathRay {
    vec3 o, d;
    float weight;  // share of its colour in the sample's
    uint from;     // object that it starts on, or kNoObject
    bool inside;   // true when it starts on the inner side of that object
    uint depth;    // 1: from the eye
    uint kind;     // kCountPrimary, kCountReflected or kCountRefracted
    uint key;      // of its noise
};
PathRay ray;
RayFrame frame;  // of `ray`, kMeshes
uint undecided;  // planes that are parallel to `ray` within rounding
uint feelers;    // shadow rays from the hit of `ray`

// Sample that the rays belong to.
vec3 colour;           // sum so far
vec4 levels[kLevels];  // of each ray: its own part of the colour, the share of what it is followed by
uint rays;             // number that this dispatch has followed
uint waits;            // number that wait in the list
uint primaryBits;      // 1: the eye ray hits something

uint firstTriangle() { return push.sphereCount + push.planeCount; }

// Nearest hit so far of `ray`.
struct Nearest {
    float t;
    uint object;  // kNoObject: none
};
Nearest nearest;
void takeHit(bool nearer, float t, uint object) {
    nearest.t = nearer ? t : nearest.t;
    nearest.object = nearer ? object : nearest.object;
}

void meetSpheres() {
    int i = 0;
    [[unroll]] for (i = 0; i < sphereCount(); ++i) {
        SphereHit met = sphereAt(i, ray.o, ray.d, ray.from, ray.inside);
        takeHit(isNearer(met.t, uint(i), nearest.t, nearest.object), met.t, uint(i));
    }
    fault |= i < sphereCount() ? kFaultLoop : 0u;
}

void meetBoards() {
    int i = 0;
    for (i = 0; i < boardCount(); ++i) {
        PlaneHit met = boardAt(i, ray.o, ray.d, ray.from, ray.inside);
        takeHit(isNearer(met.t, push.sphereCount + uint(i), nearest.t, nearest.object), met.t, push.sphereCount + uint(i));
        undecided += met.undecided;
    }
    fault |= i < boardCount() ? kFaultLoop : 0u;
}

// Returns the next leaf whose box a ray may meet nearer than `longest`, as a link; below kLeaf when the walk is over. `child` is where it goes
// on.
uint nextLeaf(RayFrame along, float longest, inout int child) {
    int children = int(push.childCount);
    uint link = 0u;
    while (child < children && link < kLeaf) {
        uvec4 low = texelFetch(nodes, child * 2);
        uvec4 high = texelFetch(nodes, child * 2 + 1);
        bool open = opensFor(along, low, high, longest);
        link = open ? low.w : 0u;
        child = open && link < kLeaf ? int(link * kNodeChildren) : int(high.w);
    }
    return link;
}

// `eye`: what the eye ray meets, when eye rays have walked the tree together.
void meetMeshes(bool runs, EyeHit eye) {
    int children = int(push.childCount);
    int child = runs ? 0 : children;
    if (kEyeTogether && rays == 1u && push.first != 0u) {
        takeHit(eye.triangle != kNoObject && isNearer(eye.t, firstTriangle() + eye.triangle, nearest.t, nearest.object), eye.t,
                firstTriangle() + eye.triangle);
        child = children;
    }
    if (!kEyeTogether || kChildren || kList) {
        while (child < children) {
            uint link = nextLeaf(frame, nearest.t, child);
            uint triangle;
            TriangleHit met = leafAt(link >= kLeaf ? link & ~kLeaf : 0u, frame, ray.from - firstTriangle(), triangle);
            takeHit(link >= kLeaf && isNearer(met.t, firstTriangle() + triangle, nearest.t, nearest.object), met.t,
                    firstTriangle() + triangle);
        }
        fault |= child < children ? kFaultLoop : 0u;
    }
}

void nearestHit(bool runs, EyeHit eye) {
    nearest = Nearest(kFarthestHit, kNoObject);
    meetSpheres();
    meetBoards();
    if (kMeshes) {
        frame = frameOfRay(ray.o, ray.d, push.reach);
        meetMeshes(runs, eye);
    }
}

// Surface where `ray` hits it.
struct Hit {
    bool any;   // true when the ray hits something
    bool mesh;  // true when that is a triangle of a mesh
    SurfacePoint s;
    uint material;
    bool within;  // true when the ray meets the inner side
    vec3 n;       // normal that faces the ray
    vec3 seen;    // the same for shading: interpolated on a mesh
    vec3 bends;   // the same for mirrored and refracted rays
    vec3 before;  // origin of rays that leave on the ray's side
};
Hit hit;

SurfacePoint pointOfSphere(int sphere, out uint owner) {
    vec4 record = sphereRecordOf(sphere, owner);
    SphereHit again = sphereOf(record, sphere, ray.o, ray.d, ray.from, ray.inside);
    SurfacePoint s = pointOnSphere(record.xyz, record.w, again.offset);
    if (kClose) s = pointOnCloseSphere(ray.o, ray.d, again.t, record.xyz, record.w, powerOf(sphere), again.offset);
    return s;
}

SurfacePoint pointOfMesh(int triangle, out uint owner, out vec3 interpolated) {
    uvec4 words = texelFetch(triangles, triangle * 2);
    TriangleHit again = triangleAt(words, frame, false);
    vec3 geometric = uintBitsToFloat(texelFetch(triangles, triangle * 2 + 1).xyz);
    interpolated =
        unitLength((texelFetch(corners, int(words.x) * 2 + 1).xyz * again.w0 + texelFetch(corners, int(words.y) * 2 + 1).xyz * again.w1) +
                   texelFetch(corners, int(words.z) * 2 + 1).xyz * again.w2);
    owner = words.w;
    return pointOnTriangle(texelFetch(corners, int(words.x) * 2).xyz, texelFetch(corners, int(words.y) * 2).xyz,
                           texelFetch(corners, int(words.z) * 2).xyz, geometric, again);
}

void takeSurface(bool own, SurfacePoint s, uint owner) {
    hit.s.point = own ? s.point : hit.s.point;
    hit.s.normal = own ? s.normal : hit.s.normal;
    hit.s.error = own ? s.error : hit.s.error;
    hit.material = own ? owner : hit.material;
}

// Fills `hit` from the nearest object.
void surfaceOf(bool runs) {
    hit.any = runs && nearest.object != kNoObject;
    hit.mesh = kMeshes && hit.any && nearest.object >= firstTriangle();
    bool ball = nearest.object < push.sphereCount;
    hit.s = SurfacePoint(vec3(0.0), vec3(0.0), vec3(0.0));
    hit.material = 0u;
    if (kBoards != 0) {
        int board = hit.any && !ball && !hit.mesh ? int(nearest.object - push.sphereCount) : 0;
        PlaneHit onBoard = boardAt(board, ray.o, ray.d, ray.from, ray.inside);
        hit.s = pointOnPlane(boardTexel(board, 0).xyz, onBoard.point);
        hit.material = materialOfBoard(board, onBoard);
    }
    uint owner = 0u;
    if (kSpheres != 0) {
        SurfacePoint onSphere = pointOfSphere(ball ? int(nearest.object) : 0, owner);
        takeSurface(ball, onSphere, owner);
    }
    vec3 smoothNormal = hit.s.normal;
    if (kMeshes) {
        vec3 interpolated;
        SurfacePoint onMesh = pointOfMesh(hit.mesh ? int(nearest.object - firstTriangle()) : 0, owner, interpolated);
        takeSurface(hit.mesh, onMesh, owner);
        smoothNormal = hit.mesh ? interpolated : hit.s.normal;
    }
    hit.within = dot3(ray.d, hit.s.normal) > 0.0;
    hit.n = hit.within ? -hit.s.normal : hit.s.normal;
    hit.seen = hit.n;
    hit.bends = hit.n;
    if (kMeshes) {
        hit.seen = hit.mesh ? (hit.within ? -smoothNormal : smoothNormal) : hit.n;
        if (kChildren) hit.bends = hit.mesh ? normalForRays(ray.d, hit.n, hit.seen) : hit.n;
    }
    hit.before = leaveSurface(hit.s.point, hit.n, hit.s.error);
}

// Material of `hit`.
TraceMaterial material;
void readMaterial() {
    int first = int(hit.material) * kTraceMaterialTexels;
    vec4 base = texelFetch(materials, first);
    vec4 diffuse = texelFetch(materials, first + 1);
    vec4 specular = texelFetch(materials, first + 2);
    vec4 shares = texelFetch(materials, first + 3);
    material = TraceMaterial(base.xyz, base.w, diffuse.xyz, diffuse.w, specular.xyz, specular.w, shares.x, shares.y, shares.z, shares.w);
}

// Dims `passed`, the light that a shadow ray keeps, by what stands between `hit` and the light.
void dimBySpheres(Feeler feeler, inout float passed) {
    int i = 0;
    [[unroll]] for (i = 0; i < sphereCount(); ++i) {
        SphereHit met = sphereAt(i, hit.before, feeler.direction, nearest.object, hit.within);
        passed *= blocks(met.t, feeler.reach) ? (kDims ? shareThatPasses(texelFetch(surfaces, i).x) : 0.0) : 1.0;
    }
    fault |= i < sphereCount() ? kFaultLoop : 0u;
}
void dimByBoards(Feeler feeler, inout float passed) {
    int i = 0;
    for (i = 0; i < boardCount(); ++i) {
        PlaneHit met = boardAt(i, hit.before, feeler.direction, nearest.object, hit.within);
        passed *= blocks(met.t, feeler.reach) ? (kDims ? shareThatPasses(materialOfBoard(i, met)) : 0.0) : 1.0;
    }
    fault |= i < boardCount() ? kFaultLoop : 0u;
}
void dimByMeshes(Feeler feeler, bool sent, inout float passed) {
    RayFrame along = frameOfRay(hit.before, feeler.direction, push.reach);
    int children = int(push.childCount);
    int child = 0;
    while (sent && passed > 0.0 && child < children) {
        uint link = nextLeaf(along, feeler.reach, child);
        uint triangle;
        TriangleHit at = leafAt(link >= kLeaf ? link & ~kLeaf : 0u, along, nearest.object - firstTriangle(), triangle);
        uint owner = texelFetch(triangles, int(triangle) * 2).w;
        float slope = dot3(feeler.direction, uintBitsToFloat(texelFetch(triangles, int(triangle) * 2 + 1).xyz));
        bool met = link >= kLeaf && blocks(at.t, feeler.reach);
        passed *= met ? passesTriangle(shareThatPasses(owner), slope) : 1.0;
    }
    fault |= sent && passed > 0.0 && child < children ? kFaultLoop : 0u;
}

// Returns the share of a light that reaches `hit`. `lit`: true when the hit asks for this light.
float shareOfLight(int light, vec4 place, bool lit) {
    Feeler feeler = feelerTo(place, hit.before);
    bool above = dot3(hit.seen, feeler.direction) > 0.0 && dot3(hit.n, feeler.direction) > 0.0;
    feelers += lit && above ? 1u : 0u;
    if (kJitterFeeler != 0u)
        feeler.direction =
            jittered(feeler.direction, hit.n, uintBitsToFloat(kJitterFeeler), keyOfChild(ray.key, kFirstFeelerKey + uint(light)));
    float passed = 1.0;
    if (kShadows) {
        dimBySpheres(feeler, passed);
        dimByBoards(feeler, passed);
        if (kMeshes) dimByMeshes(feeler, lit && above, passed);
    }
    return above ? passed : 0.0;
}

vec4 lightTexel(int light, int k) {
    vec4 texel;
    if (kOneLight)
        texel = heldLight[k];
    else
        texel = texelFetch(lights, light * kLightTexels + k);
    return texel;
}

// Returns the Phong colour of `hit`, each light dimmed by what its shadow ray meets. `local`: true when the hit shows it.
Colour localColour(bool local) {
    Colour c = Colour(material.base.x, material.base.y, material.base.z);
    Surface surface =
        Surface(hit.seen.x, hit.seen.y, hit.seen.z, -ray.d.x, -ray.d.y, -ray.d.z, hit.s.point.x, hit.s.point.y, hit.s.point.z);
    Reflectance k = Reflectance(material.diffuse.x, material.diffuse.y, material.diffuse.z, material.specular.x, material.specular.y,
                                material.specular.z, material.shininess, material.zeroPower);
    ShadeParts parts = ShadeParts(true, kSpecular, kPointLights, kPowerExact);
    int lightCount = int(push.lightCount);
    int light = 0;
    if (kLights) do {
            bool lit = local && light < lightCount;
            if (lit || together()) {
                vec4 place = lightTexel(light, 0);
                vec4 intensity = lightTexel(light, 1);
                float passed = shareOfLight(light, place, lit);
                addLight(place, vec4(intensity.xyz * passed, intensity.w), surface, k, parts, c);
            }
            light++;
        } while (!kOneLight && light < lightCount);
    fault |= kLights && local && light < lightCount ? kFaultLoop : 0u;
    return c;
}

// Adds what `ray` itself sees to the sample.
void addColour(bool runs) {
    bool local = hit.any && material.local > 0.0;
    Colour c = localColour(local);
    float share = ray.weight * material.local;
    vec3 added = vec3(c.r, c.g, c.b) * share;
    added = hit.any ? (local ? added : vec3(0.0)) : push.sky * ray.weight;
    colour = runs ? colour + added : colour;
    if (kCutLevels) {
        vec3 own = hit.any ? wholeLevels(vec3(c.r, c.g, c.b)) * material.local : wholeLevels(push.sky);
        levels[ray.depth - 1u] = vec4(local || !hit.any ? own : vec3(0.0), hit.any ? material.reflect : 0.0);
    }
}

// Writes the planes of what the eye ray hits. `word`: of the sample.
void writeFirstHit(uint word) {
    primaryBits = hit.any ? 1u : 0u;
    if ((kPlanes & kTracePlaneDistance) != 0u) planes[word] = hit.any ? floatBitsToUint(nearest.t) : 0u;
    if ((kPlanes & kTracePlaneObject) != 0u) planes[word + kSlotObject * push.planeWords] = nearest.object;
    if ((kPlanes & kTracePlaneNormal) != 0u) {
        planes[word + kSlotNormal * push.planeWords] = hit.any ? floatBitsToUint(hit.seen.x) : 0u;
        planes[word + (kSlotNormal + 1u) * push.planeWords] = hit.any ? floatBitsToUint(hit.seen.y) : 0u;
        planes[word + (kSlotNormal + 2u) * push.planeWords] = hit.any ? floatBitsToUint(hit.seen.z) : 0u;
    }
}

// Puts a ray on top of those of the sample that wait.
void putWaiting(uint item, PathRay r) {
    uint slot = (waits * push.itemCount + item) * kWaitingWords;
    waiting[slot] = floatBitsToUint(r.o.x);
    waiting[slot + 1u] = floatBitsToUint(r.o.y);
    waiting[slot + 2u] = floatBitsToUint(r.o.z);
    waiting[slot + 3u] = floatBitsToUint(r.d.x);
    waiting[slot + 4u] = floatBitsToUint(r.d.y);
    waiting[slot + 5u] = floatBitsToUint(r.d.z);
    waiting[slot + 6u] = floatBitsToUint(r.weight);
    waiting[slot + 7u] = r.from;
    waiting[slot + 8u] = r.depth << 3 | r.kind << 1 | (r.inside ? 1u : 0u);
    waiting[slot + 9u] = r.key;
    waits++;
}

// Takes the ray that waits on top as `ray`.
void takeWaiting(uint item) {
    waits--;
    uint slot = (waits * push.itemCount + item) * kWaitingWords;
    ray.o = vec3(uintBitsToFloat(waiting[slot]), uintBitsToFloat(waiting[slot + 1u]), uintBitsToFloat(waiting[slot + 2u]));
    ray.d = vec3(uintBitsToFloat(waiting[slot + 3u]), uintBitsToFloat(waiting[slot + 4u]), uintBitsToFloat(waiting[slot + 5u]));
    ray.weight = uintBitsToFloat(waiting[slot + 6u]);
    ray.from = waiting[slot + 7u];
    uint packed = waiting[slot + 8u];
    ray.key = waiting[slot + 9u];
    ray.inside = (packed & 1u) != 0u;
    ray.kind = (packed >> 1) & 3u;
    ray.depth = packed >> 3;
}

// Children of `hit`, as the contract and the noise send them.
Children childrenOfHit() {
    Children next = childrenOf(ray.d, hit.bends, hit.within, material.reflect, material.transmit, material.index, material.inverseIndex,
                               ray.weight, ray.depth, push.maxDepth, push.minWeight);
    if (kMeshes && kRefracts)
        next.passDirection = hit.mesh ? onSideOf(next.passDirection, -hit.n, leastSlope(ray.d, hit.n)) : next.passDirection;
    next.mirror = kChildren && hit.any && next.mirror;
    next.pass = kRefracts && hit.any && next.pass;
    if (kJitterMirror != 0u)
        next.mirrorDirection = jittered(next.mirrorDirection, hit.n, uintBitsToFloat(kJitterMirror), keyOfChild(ray.key, kCountReflected));
    if (kJitterPass != 0u)
        next.passDirection = jittered(next.passDirection, hit.n, uintBitsToFloat(kJitterPass), keyOfChild(ray.key, kCountRefracted));
    return next;
}

// Makes a child of `hit` the `ray`; where there are two, the refracted one waits. Returns false when no child takes its place.
bool sendOn(uint item) {
    Children next = childrenOfHit();
    if (!kList) fault |= next.mirror && next.pass ? kFaultRange : 0u;
    ray.depth++;
    vec3 behind = leaveSurface(hit.s.point, -hit.n, hit.s.error);
    if (kList && next.pass)
        putWaiting(item, PathRay(behind, next.passDirection, next.passWeight, nearest.object, !hit.within, ray.depth, kCountRefracted,
                                 hasKeys() ? keyOfChild(ray.key, kCountRefracted) : 0u));
    bool back = !kRefracts || next.mirror;
    ray.o = back ? hit.before : behind;
    ray.d = back ? next.mirrorDirection : next.passDirection;
    ray.weight = back ? next.mirrorWeight : next.passWeight;
    ray.kind = back ? kCountReflected : kCountRefracted;
    if (hasKeys()) ray.key = keyOfChild(ray.key, ray.kind);
    ray.from = nearest.object;
    ray.inside = back ? hit.within : !hit.within;
    return next.mirror || (!kList && next.pass);
}

void takeState(uint item) {
    uint state = item * kStateWords;
    colour = vec3(uintBitsToFloat(states[state]), uintBitsToFloat(states[state + 1u]), uintBitsToFloat(states[state + 2u]));
    waits = states[state + 3u];
    primaryBits = waits >> 31;
    waits &= 0x7fffffffu;
}
void leaveState(uint item, uint left) {
    uint state = item * kStateWords;
    states[state] = floatBitsToUint(colour.x);
    states[state + 1u] = floatBitsToUint(colour.y);
    states[state + 2u] = floatBitsToUint(colour.z);
    states[state + 3u] = left | primaryBits << 31;
}

// The colour in whole levels: from the path's end to the eye.
void sumLevels() {
    colour = vec3(0.0);
    while (rays > 0u) {
        rays--;
        colour = cutLevels(colour * levels[rays].w, levels[rays].xyz);
    }
    colour = colour * kOneLevel;
}

// Writes a sample that is done.
void writeSample(uint word) {
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

// Begins a sample with its ray from the eye.
void beginSample(uint item, uint column, uint row) {
    uvec2 place = placeOf(column, row);
    ray = PathRay(vec3(0.0), eyeDirection(place), 1.0, kNoObject, false, 1u, kCountPrimary, keyAt(place));
    colour = vec3(0.0);
    waits = 0u;
    rays = 0u;
    primaryBits = 0u;
}

// Follows the rays of one sample, from the eye to what it leaves.
void traceSample(uint item, uint column, uint row, bool mine, EyeHit eye) {
    uint word = (row - push.firstRow) * push.rowWords + column;
    beginSample(item, column, row);
    bool take = kList && push.first == 0u;  // the next ray comes from the list
    bool alive = mine;
    if (take) {
        takeState(item);
        alive = mine && waits > 0u;
    }
    bool begun = alive;
    uint trips = 0u;
    do {
        bool runs = alive;
        bool bent = ray.kind == kCountRefracted;
        feelers = 0u;
        undecided = 0u;
        if (alive || together()) {
            rays += runs ? 1u : 0u;
            if (kList && take) takeWaiting(item);
            nearestHit(runs, eye);
            surfaceOf(runs);
            readMaterial();
            addColour(runs);
            if (kCount && !together()) countRay(ray.depth, ray.kind, feelers, undecided);
            if (runs && rays == 1u && push.first != 0u) writeFirstHit(word);
            bool onward = sendOn(item);
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
        if (!take) putWaiting(item, ray);
        atomicAdd(counters[kCountUnfinished], 1u);
    }
    if (!kList) fault |= alive ? kFaultLoop : 0u;
    if (kCutLevels) sumLevels();
    if (kList && mine) leaveState(item, begun && alive ? waits : 0u);
    if (begun && !alive) writeSample(word);
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
