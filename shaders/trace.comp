// SPDX-License-Identifier: MIT
// One invocation one sample. A path that has one child at most loops in registers; where a hit has two, the refracted one waits in the
// sample's own list (kList), which also lets a long tree go on in the next dispatch.
// Loops that end at a different place in each invocation are `while`: a divergent do..while inside another loop goes wrong on lavapipe. The outer
// loop is do..while, and so is what runs equally often in all invocations: a `while` of lavapipe runs its body once more than it has to.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef PLUMB_BALLOT
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_vote : require
#endif
#define PLUMB_ONE_PIXEL
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/trace.h"
#include "shared/encode.h"

layout(constant_id = 2) const uint kEncoding = 0u;
layout(constant_id = 3) const uint kPlanes = 0u;          // kTracePlane bits that the plane buffer holds
layout(constant_id = 4) const bool kColour = true;        // write the encoded sample
layout(constant_id = 5) const bool kList = false;         // some material has two children, or samples take several dispatches
layout(constant_id = 6) const bool kFar = false;          // some sphere is far for its radius
layout(constant_id = 7) const bool kCount = true;
layout(constant_id = 8) const bool kSpecular = true;
layout(constant_id = 9) const bool kPointLights = true;
layout(constant_id = 10) const bool kShadows = true;
layout(constant_id = 12) const bool kMeshes = false;
layout(constant_id = 13) const uint kSampling = kSampleGrid;
layout(constant_id = 14) const uint kSide = 1u;           // samples a pixel along an axis
layout(constant_id = 15) const bool kListed = false;      // samples of the pixels in `pixels`, kSide rows of them
layout(constant_id = 16) const bool kCutLevels = false;   // colours in whole levels
layout(constant_id = 17) const uint kJitterMirror = 0u;   // bits of the amounts of noise; 0: none
layout(constant_id = 18) const uint kJitterPass = 0u;
layout(constant_id = 19) const uint kJitterFeeler = 0u;
layout(constant_id = 11) const int kSpheres = -1;         // number of spheres where it is small, so that their loops unroll; -1: pushed
layout(constant_id = 20) const int kBoards = -1;          // the same of planes
layout(constant_id = 21) const bool kHeld = false;        // kSpheres and kBoards are so few that their records stay in registers
layout(constant_id = 22) const uint kFeelerBits = 32u;    // of the number of lights

layout(push_constant, scalar) uniform Push { TracePush push; };
layout(binding = 1) uniform samplerBuffer spheres;        // centre, radius
layout(binding = 2) uniform samplerBuffer boards;         // kPlaneTexels each
layout(binding = 3) uniform usamplerBuffer surfaces;      // material of each object: spheres, then planes
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
layout(binding = 15) uniform usamplerBuffer pixels;       // x | y << 16, kListed

const bool kKeys = kSampling == kSampleRandom || (kJitterMirror | kJitterPass | kJitterFeeler) != 0u;
const uint kLevels = kCutLevels ? kRayDepthLimit : 1u;

const uint kSlotObject = (kPlanes & kTracePlaneDistance) != 0u ? 1u : 0u;
const uint kSlotLinear = kSlotObject + ((kPlanes & kTracePlaneObject) != 0u ? 1u : 0u);
const uint kSlotNormal = kSlotLinear + ((kPlanes & kTracePlaneLinear) != 0u ? 3u : 0u);

uint fault = 0u;

int sphereCount() { return kSpheres >= 0 ? kSpheres : int(push.sphereCount); }
int boardCount() { return kBoards >= 0 ? kBoards : int(push.planeCount); }

// Records that stay in registers: indexed by constants alone, once loops are unrolled.
vec4 heldSpheres[kHeld && kSpheres > 0 ? kSpheres : 1];
vec4 heldBoards[kHeld && kBoards > 0 ? kBoards * kPlaneTexels : 1];

void hold() {
    if (!kHeld) return;
    for (int i = 0; i < kSpheres; ++i) heldSpheres[i] = texelFetch(spheres, i);
    for (int i = 0; i < kBoards * kPlaneTexels; ++i) heldBoards[i] = texelFetch(boards, i);
}

SphereHit sphereOf(vec4 sphere, int i, vec3 o, vec3 d, uint from, bool inside) {
    return hitSphere(o, d, sphere.xyz, sphere.w, startOn(uint(i), from, inside), kFar);
}
// In a loop over all spheres.
SphereHit sphereAt(int i, vec3 o, vec3 d, uint from, bool inside) {
    vec4 sphere;
    if (kHeld) sphere = heldSpheres[i];
    else sphere = texelFetch(spheres, i);
    return sphereOf(sphere, i, o, d, from, inside);
}

PlaneHit boardOf(int i, vec3 o, vec3 d, uint from, bool inside) {
    int at = i * kPlaneTexels;
    return hitPlane(o, d, texelFetch(boards, at), texelFetch(boards, at + 1), texelFetch(boards, at + 2), texelFetch(boards, at + 3),
                    texelFetch(boards, at + 4).z != 0.0, startOn(push.sphereCount + uint(i), from, inside));
}
// In a loop over all planes.
PlaneHit boardAt(int i, vec3 o, vec3 d, uint from, bool inside) {
    if (!kHeld) return boardOf(i, o, d, from, inside);
    int at = i * kPlaneTexels;
    return hitPlane(o, d, heldBoards[at], heldBoards[at + 1], heldBoards[at + 2], heldBoards[at + 3], heldBoards[at + 4].z != 0.0,
                    startOn(push.sphereCount + uint(i), from, inside));
}

uint materialOfBoard(int i, PlaneHit hit) {
    vec4 pattern = texelFetch(boards, i * kPlaneTexels + 4);
    uint first = texelFetch(surfaces, int(push.sphereCount) + i).x;
    bool other = pattern.x > 0.0 && otherSquare(hit.u, hit.v, pattern.x > 0.0 ? pattern.x : 1.0, pattern.y);
    return other ? uint(pattern.w) : first;
}

// The triangle's corners, by the words of its first texel.
TriangleHit triangleAt(uvec4 words, RayFrame f, bool own) {
    return hitTriangle(f, texelFetch(corners, int(words.x) * 2).xyz, texelFetch(corners, int(words.y) * 2).xyz,
                       texelFetch(corners, int(words.z) * 2).xyz, own);
}

#ifdef PLUMB_BALLOT
// Eye rays of neighbouring pixels, all invocations together: they follow one node, which opens when it opens for one of them. A leaf counts
// for those for which its own box opens, and so do all boxes around it. Every trip is the same for all, so the loops are do..while.
void nearestOfEyeRays(vec3 o, vec3 d, int nodeCount, inout float t, inout uint best) {
    RayFrame frame = frameOfRay(o, d, push.reach);
    int node = 0;
    do {
        uint leaf = kInnerNode;
        bool open = false;
        do {
            uvec4 low = texelFetch(nodes, node * 2);
            uvec4 high = texelFetch(nodes, node * 2 + 1);
            open = node < nodeCount && opens(entryOfBox(frame, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)),
                                             exitOfBox(frame, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)), t);
            bool any = subgroupAny(open);
            leaf = any ? high.w : kInnerNode;
            node = any ? node + 1 : int(low.w);
        } while (node < nodeCount && leaf == kInnerNode);
        uint triangle = leaf != kInnerNode ? leaf : 0u;
        TriangleHit hit = triangleAt(texelFetch(triangles, int(triangle) * 2), frame, false);
        bool nearer = open && leaf != kInnerNode && isNearer(hit.t, triangle, t, best);
        t = nearer ? hit.t : t;
        best = nearer ? triangle : best;
    } while (node < nodeCount);
    fault |= node < nodeCount ? kFaultLoop : 0u;
}
#endif

float shareThatPasses(uint material) { return texelFetch(materials, int(material) * kTraceMaterialTexels + 3).y; }

#ifdef PLUMB_BALLOT
// Sum over the invocations that run along, of values below 2^bits.
uint sumOf(uint value, uint bits) {
    uint sum = 0u;
    for (uint b = 0u; b < bits; ++b) sum += subgroupBallotBitCount(subgroupBallot((value >> b & 1u) != 0u)) << b;
    return sum;
}
#endif
// Without a list all invocations that still run are at the same depth.
void countRay(uint depth, uint kind, uint feelers, uint undecided) {
    uint first = (depth - 1u) * kCountKinds;
#ifdef PLUMB_BALLOT
    if (!kList) {
        uvec4 running = subgroupBallot(true);
        uint rays = subgroupBallotBitCount(running);
        uint refracted = subgroupBallotBitCount(subgroupBallot(kind == kCountRefracted));
        uint sent = sumOf(feelers, kFeelerBits);
        uint lost = kBoards == 0 ? 0u : subgroupBallotBitCount(subgroupBallot(undecided != 0u));
        bool several = kBoards != 0 && kBoards != 1;
        if (gl_SubgroupInvocationID == subgroupBallotFindLSB(running)) {
            atomicAdd(counters[first + (depth == 1u ? kCountPrimary : kCountReflected)], rays - refracted);
            if (refracted > 0u) atomicAdd(counters[first + kCountRefracted], refracted);
            if (sent > 0u) atomicAdd(counters[first + kCountFeelers], sent);
            if (lost > 0u && !several) atomicAdd(counters[kCountUndecided], lost);
        }
        if (several && undecided > 0u) atomicAdd(counters[kCountUndecided], undecided);
        return;
    }
#endif
    atomicAdd(counters[first + kind], 1u);
    if (feelers > 0u) atomicAdd(counters[first + kCountFeelers], feelers);
    if (undecided > 0u) atomicAdd(counters[kCountUndecided], undecided);
}

uint encode(float x) {
    if (kEncoding == kEncodeLinear) return uint(encodeLinear(x));
    float clamped = clampUnit(x);
    return uint(encodeInBucket(clamped, int(texelFetch(encodeTable, encodeBucket(clamped)).x)));
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
    uint place = push.firstItem + item;
    uint row = place / push.width;
    uint column = place - row * push.width;
    uint word = (row - push.firstRow) * push.rowWords + column;
    int lightCount = int(push.lightCount);

    vec3 o = vec3(0.0);
    if (kListed) {
        uint pixel = texelFetch(pixels, int(column / kSide)).x;
        column = (pixel & 0xffffu) * kSide + column % kSide;
        row = (pixel >> 16) * kSide + row;
    }
    uint key = kKeys ? keyOfSample(column, row, push.seed) : 0u;
    vec3 d = primaryDirection(push.rayOrigin, push.rayX, push.rayY, columnOf(kSampling, column, kSide, key), rowOf(kSampling, row, kSide, key));
    vec4 levels[kLevels];                       // of each ray: its own part of the colour, the share of what it is followed by
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
    bool take = kList && push.first == 0u;      // the next ray comes from the list
    uint rays = 0u;
#ifdef PLUMB_BALLOT
    float eyeT = kFarthestHit;
    uint eyeTriangle = kNoObject;
    if (kMeshes) nearestOfEyeRays(o, d, push.first != 0u ? int(push.nodeCount) : 0, eyeT, eyeTriangle);
#endif
    do {
      if (alive) {
        rays++;
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
        uint undecided = 0u;
        int i = 0;
        for (i = 0; i < sphereCount(); ++i) {
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
        int nodeCount = int(push.nodeCount);
        if (kMeshes) {
            frame = frameOfRay(o, d, push.reach);
            int node = 0;
#ifdef PLUMB_BALLOT
            if (rays == 1u && push.first != 0u) {
                bool nearer = eyeTriangle != kNoObject && isNearer(eyeT, firstTriangle + eyeTriangle, t, best);
                t = nearer ? eyeT : t;
                best = nearer ? firstTriangle + eyeTriangle : best;
                node = nodeCount;
            }
#endif
            while (node < nodeCount) {
                uint leaf = kInnerNode;
                while (node < nodeCount && leaf == kInnerNode) {
                    uvec4 low = texelFetch(nodes, node * 2);
                    uvec4 high = texelFetch(nodes, node * 2 + 1);
                    bool open = opens(entryOfBox(frame, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)),
                                      exitOfBox(frame, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)), t);
                    leaf = open ? high.w : kInnerNode;
                    node = open ? node + 1 : int(low.w);
                }
                uint triangle = leaf != kInnerNode ? leaf : 0u;
                TriangleHit hit = triangleAt(texelFetch(triangles, int(triangle) * 2), frame, firstTriangle + triangle == from);
                bool nearer = leaf != kInnerNode && isNearer(hit.t, firstTriangle + triangle, t, best);
                t = nearer ? hit.t : t;
                best = nearer ? firstTriangle + triangle : best;
            }
            fault |= node < nodeCount ? kFaultLoop : 0u;
        }
        bool hits = best != kNoObject;
        bool ball = best < push.sphereCount;
        bool mesh = kMeshes && hits && best >= firstTriangle;
        int sphere = ball ? int(best) : 0;
        int board = hits && !ball && !mesh ? int(best - push.sphereCount) : 0;

        SurfacePoint s;
        vec4 sphereRecord = texelFetch(spheres, sphere);
        SurfacePoint onSphere = pointOnSphere(sphereRecord.xyz, sphereRecord.w, sphereOf(sphereRecord, sphere, o, d, from, inside).offset);
        PlaneHit onBoard = boardOf(board, o, d, from, inside);
        SurfacePoint onPlane = pointOnPlane(texelFetch(boards, board * kPlaneTexels).xyz, onBoard.point);
        s.point = ball ? onSphere.point : onPlane.point;
        s.normal = ball ? onSphere.normal : onPlane.normal;
        s.error = ball ? onSphere.error : onPlane.error;
        uint material = ball ? texelFetch(surfaces, sphere).x : materialOfBoard(board, onBoard);
        vec3 smoothNormal = s.normal;
        if (kMeshes) {
            int triangle = mesh ? int(best - firstTriangle) : 0;
            uvec4 words = texelFetch(triangles, triangle * 2);
            TriangleHit hit = triangleAt(words, frame, false);
            vec3 geometric = uintBitsToFloat(texelFetch(triangles, triangle * 2 + 1).xyz);
            SurfacePoint onMesh = pointOnTriangle(texelFetch(corners, int(words.x) * 2).xyz, texelFetch(corners, int(words.y) * 2).xyz,
                                                  texelFetch(corners, int(words.z) * 2).xyz, geometric, hit);
            vec3 interpolated = unitLength((texelFetch(corners, int(words.x) * 2 + 1).xyz * hit.w0 + texelFetch(corners, int(words.y) * 2 + 1).xyz * hit.w1) +
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
        if (kMeshes) seen = mesh ? normalForLight(d, n, within ? -smoothNormal : smoothNormal) : n;

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
        uint feelers = 0u;
        int light = 0;
        do {
          if (local && light < lightCount) {
            vec4 lightPlace = texelFetch(lights, light * kLightTexels);
            vec4 intensity = texelFetch(lights, light * kLightTexels + 1);
            Feeler feeler = feelerTo(lightPlace, q);
            bool above = dot3(seen, feeler.direction) > 0.0 && dot3(n, feeler.direction) > 0.0;
            feelers += above ? 1u : 0u;
            if (kJitterFeeler != 0u) feeler.direction = jittered(feeler.direction, n, uintBitsToFloat(kJitterFeeler), keyOfChild(key, kFirstFeelerKey + uint(light)));
            float passed = 1.0;
            if (kShadows) {
                for (i = 0; i < sphereCount(); ++i) {
                    SphereHit hit = sphereAt(i, q, feeler.direction, best, within);
                    passed *= blocks(hit.t, feeler.reach) ? shareThatPasses(texelFetch(surfaces, i).x) : 1.0;
                }
                fault |= i < sphereCount() ? kFaultLoop : 0u;
                for (i = 0; i < boardCount(); ++i) {
                    PlaneHit hit = boardAt(i, q, feeler.direction, best, within);
                    passed *= blocks(hit.t, feeler.reach) ? shareThatPasses(materialOfBoard(i, hit)) : 1.0;
                }
                fault |= i < boardCount() ? kFaultLoop : 0u;
                if (kMeshes) {
                    RayFrame along = frameOfRay(q, feeler.direction, push.reach);
                    int node = 0;
                    while (above && passed > 0.0 && node < nodeCount) {
                        uint leaf = kInnerNode;
                        while (node < nodeCount && leaf == kInnerNode) {
                            uvec4 low = texelFetch(nodes, node * 2);
                            uvec4 high = texelFetch(nodes, node * 2 + 1);
                            bool open = opens(entryOfBox(along, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)),
                                              exitOfBox(along, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)), feeler.reach);
                            leaf = open ? high.w : kInnerNode;
                            node = open ? node + 1 : int(low.w);
                        }
                        uint triangle = leaf != kInnerNode ? leaf : 0u;
                        uvec4 words = texelFetch(triangles, int(triangle) * 2);
                        TriangleHit hit = triangleAt(words, along, firstTriangle + triangle == best);
                        float slope = dot3(feeler.direction, uintBitsToFloat(texelFetch(triangles, int(triangle) * 2 + 1).xyz));
                        bool met = leaf != kInnerNode && blocks(hit.t, feeler.reach);
                        passed *= met ? passesTriangle(shareThatPasses(words.w), slope) : 1.0;
                    }
                    fault |= above && passed > 0.0 && node < nodeCount ? kFaultLoop : 0u;
                }
            }
            passed = above ? passed : 0.0;
            addLight(lightPlace, vec4(intensity.xyz * passed, intensity.w), surface, k, parts, c);
          }
          light++;
        } while (light < lightCount);
        fault |= local && light < lightCount ? kFaultLoop : 0u;
        float share = weight * specular.w;
        vec3 added = vec3(c.r, c.g, c.b) * share;
        added = hits ? (local ? added : vec3(0.0)) : push.sky * weight;
        colour = colour + added;
        if (kCutLevels) {
            vec3 own = hits ? wholeLevels(vec3(c.r, c.g, c.b)) * specular.w : wholeLevels(push.sky);
            levels[depth - 1u] = vec4(local || !hits ? own : vec3(0.0), hits ? shares.x : 0.0);
        }

        if (kCount) countRay(depth, kind, feelers, undecided);
        if (rays == 1u && push.first != 0u) {
            primaryBits = hits ? 1u : 0u;
            if ((kPlanes & kTracePlaneDistance) != 0u) planes[word] = hits ? floatBitsToUint(t) : 0u;
            if ((kPlanes & kTracePlaneObject) != 0u) planes[word + kSlotObject * push.planeWords] = best;
            if ((kPlanes & kTracePlaneNormal) != 0u) {
                planes[word + kSlotNormal * push.planeWords] = hits ? floatBitsToUint(seen.x) : 0u;
                planes[word + (kSlotNormal + 1u) * push.planeWords] = hits ? floatBitsToUint(seen.y) : 0u;
                planes[word + (kSlotNormal + 2u) * push.planeWords] = hits ? floatBitsToUint(seen.z) : 0u;
            }
        }

        Children next = childrenOf(d, seen, within, shares.x, shares.y, shares.z, shares.w, weight, depth, push.maxDepth, push.minWeight);
        bool mirror = hits && next.mirror;
        bool pass = hits && next.pass;
        if (!kList) fault |= mirror && pass ? kFaultRange : 0u;
        if (kJitterMirror != 0u) next.mirrorDirection = jittered(next.mirrorDirection, n, uintBitsToFloat(kJitterMirror), keyOfChild(key, kCountReflected));
        if (kJitterPass != 0u) next.passDirection = jittered(next.passDirection, n, uintBitsToFloat(kJitterPass), keyOfChild(key, kCountRefracted));
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
            waiting[slot + 9u] = kKeys ? keyOfChild(key, kCountRefracted) : 0u;
            waits++;
        }
        bool onward = mirror || (!kList && pass);
        o = mirror ? q : behind;
        d = mirror ? next.mirrorDirection : next.passDirection;
        weight = mirror ? next.mirrorWeight : next.passWeight;
        kind = mirror ? kCountReflected : kCountRefracted;
        if (kKeys) key = keyOfChild(key, kind);
        from = best;
        inside = mirror ? within : !within;
        take = !onward;
        alive = onward || (kList && waits > 0u);
      }
    } while (alive && rays < push.rayLimit);
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
    finish(push.statusSlot, fault);
}
