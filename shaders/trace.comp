// SPDX-License-Identifier: MIT
// One invocation one sample. A path that has one child at most loops in registers; where a hit has two, the refracted one waits in the
// sample's own list (kList), which also lets a long tree go on in the next dispatch.
// Loops that end at a different place in each invocation are `while`: a divergent do..while inside another loop goes wrong on lavapipe.
#version 460
#extension GL_GOOGLE_include_directive : require
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
layout(constant_id = 11) const int kSpheres = -1;         // number of spheres where it is small, so that their loops unroll; -1: pushed

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

const uint kSlotObject = (kPlanes & kTracePlaneDistance) != 0u ? 1u : 0u;
const uint kSlotLinear = kSlotObject + ((kPlanes & kTracePlaneObject) != 0u ? 1u : 0u);
const uint kSlotNormal = kSlotLinear + ((kPlanes & kTracePlaneLinear) != 0u ? 3u : 0u);

uint fault = 0u;

int sphereCount() { return kSpheres >= 0 ? kSpheres : int(push.sphereCount); }

SphereHit sphereAt(int i, vec3 o, vec3 d, uint from, bool inside) {
    vec4 sphere = texelFetch(spheres, i);
    return hitSphere(o, d, sphere.xyz, sphere.w, startOn(uint(i), from, inside), kFar);
}

PlaneHit boardAt(int i, vec3 o, vec3 d, uint from, bool inside) {
    int at = i * kPlaneTexels;
    return hitPlane(o, d, texelFetch(boards, at), texelFetch(boards, at + 1), texelFetch(boards, at + 2), texelFetch(boards, at + 3),
                    texelFetch(boards, at + 4).z != 0.0, startOn(push.sphereCount + uint(i), from, inside));
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

float shareThatPasses(uint material) { return texelFetch(materials, int(material) * kTraceMaterialTexels + 3).y; }

uint encode(float x) {
    if (kEncoding == kEncodeLinear) return uint(encodeLinear(x));
    float clamped = clampUnit(x);
    return uint(encodeInBucket(clamped, int(texelFetch(encodeTable, encodeBucket(clamped)).x)));
}

void main() {
    uint item = itemIndex();
    bool mine = item < push.itemCount;
    item = min(item, push.itemCount - 1u);
    uint place = push.firstItem + item;
    uint row = place / push.width;
    uint column = place - row * push.width;
    uint word = (row - push.firstRow) * push.rowWords + column;
    int boardCount = int(push.planeCount);
    int lightCount = int(push.lightCount);

    vec3 o = vec3(0.0);
    vec3 d = primaryDirection(push.rayOrigin, push.rayX, push.rayY, float(column) + 0.5, float(row) + 0.5);
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
    while (alive && rays < push.rayLimit) {
        rays++;
        if (kList && take) {
            waits--;
            uint at = (waits * push.itemCount + item) * kWaitingWords;
            o = vec3(uintBitsToFloat(waiting[at]), uintBitsToFloat(waiting[at + 1u]), uintBitsToFloat(waiting[at + 2u]));
            d = vec3(uintBitsToFloat(waiting[at + 3u]), uintBitsToFloat(waiting[at + 4u]), uintBitsToFloat(waiting[at + 5u]));
            weight = uintBitsToFloat(waiting[at + 6u]);
            from = waiting[at + 7u];
            uint packed = waiting[at + 8u];
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
        for (i = 0; i < boardCount; ++i) {
            PlaneHit hit = boardAt(i, o, d, from, inside);
            bool nearer = isNearer(hit.t, push.sphereCount + uint(i), t, best);
            t = nearer ? hit.t : t;
            best = nearer ? push.sphereCount + uint(i) : best;
            undecided += hit.undecided;
        }
        fault |= i < boardCount ? kFaultLoop : 0u;
        uint firstTriangle = push.sphereCount + push.planeCount;
        RayFrame frame;
        int nodeCount = int(push.nodeCount);
        if (kMeshes) {
            frame = frameOfRay(o, d, push.reach);
            int node = 0;
            while (node < nodeCount) {
                uvec4 low = texelFetch(nodes, node * 2);
                uvec4 high = texelFetch(nodes, node * 2 + 1);
                bool open = opens(entryOfBox(frame, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)),
                                  exitOfBox(frame, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)), t);
                bool leaf = high.w != kInnerNode;
                uint triangle = leaf ? high.w : 0u;
                TriangleHit hit = triangleAt(texelFetch(triangles, int(triangle) * 2), frame, firstTriangle + triangle == from);
                bool nearer = open && leaf && isNearer(hit.t, firstTriangle + triangle, t, best);
                t = nearer ? hit.t : t;
                best = nearer ? firstTriangle + triangle : best;
                node = open ? node + 1 : int(low.w);
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
        SurfacePoint onSphere = pointOnSphere(sphereRecord.xyz, sphereRecord.w, sphereAt(sphere, o, d, from, inside).offset);
        PlaneHit onBoard = boardAt(board, o, d, from, inside);
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
        while (local && light < lightCount) {
            vec4 lightPlace = texelFetch(lights, light * kLightTexels);
            vec4 intensity = texelFetch(lights, light * kLightTexels + 1);
            Feeler feeler = feelerTo(lightPlace, q);
            bool above = dot3(seen, feeler.direction) > 0.0 && dot3(n, feeler.direction) > 0.0;
            feelers += above ? 1u : 0u;
            float passed = 1.0;
            if (kShadows) {
                for (i = 0; i < sphereCount(); ++i) {
                    SphereHit hit = sphereAt(i, q, feeler.direction, best, within);
                    passed *= blocks(hit.t, feeler.reach) ? shareThatPasses(texelFetch(surfaces, i).x) : 1.0;
                }
                fault |= i < sphereCount() ? kFaultLoop : 0u;
                for (i = 0; i < boardCount; ++i) {
                    PlaneHit hit = boardAt(i, q, feeler.direction, best, within);
                    passed *= blocks(hit.t, feeler.reach) ? shareThatPasses(materialOfBoard(i, hit)) : 1.0;
                }
                fault |= i < boardCount ? kFaultLoop : 0u;
                if (kMeshes) {
                    RayFrame along = frameOfRay(q, feeler.direction, push.reach);
                    int node = 0;
                    while (above && passed > 0.0 && node < nodeCount) {
                        uvec4 low = texelFetch(nodes, node * 2);
                        uvec4 high = texelFetch(nodes, node * 2 + 1);
                        bool open = opens(entryOfBox(along, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)),
                                          exitOfBox(along, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)), feeler.reach);
                        bool leaf = high.w != kInnerNode;
                        uint triangle = leaf ? high.w : 0u;
                        uvec4 words = texelFetch(triangles, int(triangle) * 2);
                        TriangleHit hit = triangleAt(words, along, firstTriangle + triangle == best);
                        float slope = dot3(feeler.direction, uintBitsToFloat(texelFetch(triangles, int(triangle) * 2 + 1).xyz));
                        bool met = open && leaf && blocks(hit.t, feeler.reach);
                        passed *= met ? passesTriangle(shareThatPasses(words.w), slope) : 1.0;
                        node = open ? node + 1 : int(low.w);
                    }
                    fault |= above && passed > 0.0 && node < nodeCount ? kFaultLoop : 0u;
                }
            }
            passed = above ? passed : 0.0;
            addLight(lightPlace, vec4(intensity.xyz * passed, intensity.w), surface, k, parts, c);
            light++;
        }
        fault |= local && light < lightCount ? kFaultLoop : 0u;
        float share = weight * specular.w;
        vec3 added = vec3(c.r, c.g, c.b) * share;
        added = hits ? (local ? added : vec3(0.0)) : push.sky * weight;
        colour = colour + added;

        if (kCount) {
            atomicAdd(counters[(depth - 1u) * kCountKinds + kind], 1u);
            if (feelers > 0u) atomicAdd(counters[(depth - 1u) * kCountKinds + kCountFeelers], feelers);
            if (undecided > 0u) atomicAdd(counters[kCountUndecided], undecided);
        }
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
            waits++;
        }
        bool onward = mirror || (!kList && pass);
        o = mirror ? q : behind;
        d = mirror ? next.mirrorDirection : next.passDirection;
        weight = mirror ? next.mirrorWeight : next.passWeight;
        kind = mirror ? kCountReflected : kCountRefracted;
        from = best;
        inside = mirror ? within : !within;
        take = !onward;
        alive = onward || (kList && waits > 0u);
    }
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
            waits++;
        }
        atomicAdd(counters[kCountUnfinished], 1u);
    }
    if (!kList) fault |= alive ? kFaultLoop : 0u;
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
