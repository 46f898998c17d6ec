// SPDX-License-Identifier: MIT
// One invocation one sample. A path that has one child at most loops in registers; where a hit has two, the refracted one waits in the
// sample's own list (kList), which also lets a long tree go on in the next dispatch.
// Loops that end after a different trip in each invocation are `while`: a divergent do..while inside another loop goes wrong on lavapipe. The outer
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
layout(constant_id = 19) const uint kJitterShadow = 0u;
layout(constant_id = 11) const int kSpheres = -1;       // number of spheres where it is small, so that their loops unroll; -1: pushed
layout(constant_id = 20) const int kBoards = -1;        // the same of planes
layout(constant_id = 21) const uint kHeldSpheres = 0u;  // where the spheres' records stay: kHeldBy*
layout(constant_id = 23) const uint kLanes = 8u;        // of a subgroup, kEyeTogether
layout(constant_id = 24) const bool kLights = true;
layout(constant_id = 25) const bool kChildren = true;      // some hit may send a ray on
layout(constant_id = 26) const bool kRefracts = true;      // some hit may send a refracted ray on
layout(constant_id = 27) const bool kEyeTogether = false;  // eye rays walk the tree together
layout(constant_id = 28) const bool kTiles = false;        // neighbours are tiles of 4 x 2 samples
layout(constant_id = 29) const bool kDeep = false;         // the tree is deeper than kLanes
layout(constant_id = 30) const bool kLongPaths = true;     // paths may be longer than kLanes
layout(constant_id = 31) const uint kTurns = 1u;   // samples of an invocation one after another, every other row of a tile; with kTiles
layout(constant_id = 32) const bool kDims = true;  // some material lets a shadow ray through
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
bool hasKeys() { return kSampling == kSampleRandom || (kJitterMirror | kJitterPass | kJitterShadow) != 0u; }
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

#include "trace_objects.glsl"
#ifdef PLUMB_BALLOT
#include "trace_together.glsl"
#endif

float shareThatPasses(uint material) { return kDims ? texelFetch(materials, int(material) * kTraceMaterialTexels + 3).y : 0.0; }

void countRay(uint depth, uint kind, uint shadowRays, uint undecided) {
    uint first = (depth - 1u) * kCountKinds;
    atomicAdd(counters[first + kind], 1u);
    if (shadowRays > 0u) atomicAdd(counters[first + kCountShadowRays], shadowRays);
    if (undecided > 0u) atomicAdd(counters[kCountUndecided], undecided);
}
#ifdef PLUMB_BALLOT
// Without a list all invocations of a subgroup are at the same depth: the counts of depth n gather in invocation n - 1.
uvec3 gathered = uvec3(0u);  // rays, refracted ones among them, shadow rays
uint lost = 0u;              // undecided
void addCounts(uint depth, uvec3 counted) {
    uint first = (depth - 1u) * kCountKinds;
    if (counted.x > counted.y) atomicAdd(counters[first + (depth == 1u ? kCountPrimary : kCountReflected)], counted.x - counted.y);
    if (kRefracts && counted.y > 0u) atomicAdd(counters[first + kCountRefracted], counted.y);
    if (kLights && counted.z > 0u) atomicAdd(counters[first + kCountShadowRays], counted.z);
}
// All invocations of a subgroup run along, with zeros where they have no ray.
void gather(uint depth, uint rays, uint refractedRays, uint shadowRays, uint undecided) {
    uvec3 counted = uvec3(sumOf(rays), kRefracts ? sumOf(refractedRays) : 0u, kLights ? sumOf(shadowRays) : 0u);
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
uvec2 samplePosition(uint column, uint row) {
    uvec2 position = uvec2(column, row);
    if (kListed) {
        uint pixel = texelFetch(pixels, int(column / kSide)).x;
        position = uvec2((pixel & 0xffffu) * kSide + column % kSide, (pixel >> 16) * kSide + row);
    }
    return position;
}
uint keyAt(uvec2 position) { return hasKeys() ? keyOfSample(position.x, position.y, push.seed) : 0u; }
vec3 eyeDirection(uvec2 position) {
    uint key = keyAt(position);
    return primaryDirection(push.rayOrigin, push.rayX, push.rayY, columnOf(kSampling, position.x, kSide, key),
                            rowOf(kSampling, position.y, kSide, key));
}

#include "trace_hit.glsl"
#include "trace_light.glsl"

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
    uvec2 position = samplePosition(column, row);
    ray = PathRay(vec3(0.0), eyeDirection(position), 1.0, kNoObject, false, 1u, kCountPrimary, keyAt(position));
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
        shadowRays = 0u;
        undecided = 0u;
        if (alive || together()) {
            rays += runs ? 1u : 0u;
            if (kList && take) takeWaiting(item);
            nearestHit(runs, eye);
            surfaceOf(runs);
            readMaterial();
            addColour(runs);
            if (kCount && !together()) countRay(ray.depth, ray.kind, shadowRays, undecided);
            if (runs && rays == 1u && push.first != 0u) writeFirstHit(word);
            bool onward = sendOn(item);
            take = !onward;
            alive = runs && (onward || (kList && waits > 0u));
        }
        trips++;
#ifdef PLUMB_BALLOT
        if (kCount && together()) gather(trips, runs ? 1u : 0u, runs && bent ? 1u : 0u, shadowRays, runs ? undecided : 0u);
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
        uint number = push.firstItem + item;
        row = number / push.width;
        column = number - row * push.width;
    }
    EyeHit eye = EyeHit(kFarthestHit, kNoObject);
    EyeHit eye2 = eye;
#ifdef PLUMB_BALLOT
    if (kEyeTogether) {
        uvec2 position = samplePosition(column, firstRow + min(row, rows - 1u));
        nearestOfEyeRays(eyeDirection(position),
                         eyeDirection(kTurns == 2u ? samplePosition(column, firstRow + min(row + 2u, rows - 1u)) : position),
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
