// SPDX-License-Identifier: MIT
// One invocation transforms kPairsPerLane pairs of neighbouring vertices by kMatrices matrices, one after another; a pair is stored at
// once. Straight-line code: a loop over the matrices costs five times as much. lavapipe makes a call for each subgroup, so few vertices an
// invocation are dear.
// PLUMB_LONG: the transform is one composite more accurate than float32 (long_transform.h), in binary64 with PLUMB_DOUBLE, else in
// block-scaled integers.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef PLUMB_INT64
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/product.h"
#ifdef PLUMB_LONG
#include "shared/long_transform.h"
#endif

layout(constant_id = 2) const uint kMatrices = 1u;  // 0: vertices are copied, to measure loading and storing
layout(constant_id = 3) const bool kLoads = true;   // false: markOf() is stored, to measure storing

layout(push_constant, scalar) uniform Push { VerticesPush push; };
layout(binding = 1) uniform samplerBuffer vertices;
#ifdef PLUMB_LONG
layout(binding = 2, scalar) readonly buffer Longs { LongRecord longs[]; };  // one record
#else
layout(binding = 2, scalar) readonly buffer Matrices { Rows matrices[]; };  // in the order in which they are applied
#endif
// Results as the kernel stores them. lavapipe stores one lane after another, component by component; words of 64 bits are half as many.
#ifdef PLUMB_INT64
layout(binding = 3, scalar) writeonly buffer Results { u64vec4 results[]; };
u64vec4 stored(vec4 first, vec4 second) {
    uvec4 a = floatBitsToUint(first), b = floatBitsToUint(second);
    return u64vec4(packUint2x32(a.xy), packUint2x32(a.zw), packUint2x32(b.xy), packUint2x32(b.zw));
}
#else
layout(binding = 3, scalar) writeonly buffer Results { VertexPair results[]; };
VertexPair stored(vec4 first, vec4 second) { return VertexPair(first, second); }
#endif

// Matrices of the dispatch. They are read before the first store, because the driver would repeat a load that a store might have changed.
#ifdef PLUMB_LONG
LongRecord composite;
void readMatrices() { composite = longs[0]; }
vec4 transformed(vec4 p) {
#ifdef PLUMB_DOUBLE
    return vec4(doubleClip(composite, p.xyz), 1.0);
#else
    return vec4(blockClip(composite, p.xyz), 1.0);
#endif
}
vec4 mark(uint vertex) { return vec4(0.0); }
#else
Rows m0, m1, m2, m3, m4, m5, m6;
void readMatrices() {
    m0 = matrices[0];
    if (kMatrices > 1u) m1 = matrices[1];
    if (kMatrices > 2u) m2 = matrices[2];
    if (kMatrices > 3u) m3 = matrices[3];
    if (kMatrices > 4u) m4 = matrices[4];
    if (kMatrices > 5u) m5 = matrices[5];
    if (kMatrices > 6u) m6 = matrices[6];
}
vec4 transformed(vec4 p) {
    if (kMatrices > 0u) p = timesVector(m0, p);
    if (kMatrices > 1u) p = timesVector(m1, p);
    if (kMatrices > 2u) p = timesVector(m2, p);
    if (kMatrices > 3u) p = timesVector(m3, p);
    if (kMatrices > 4u) p = timesVector(m4, p);
    if (kMatrices > 5u) p = timesVector(m5, p);
    if (kMatrices > 6u) p = timesVector(m6, p);
    return p;
}
vec4 mark(uint vertex) { return markOf(m0, vertex); }
#endif

vec4 resultOf(uint vertex) {
    vec4 result;
    if (kLoads)
        result = transformed(texelFetch(vertices, int(min(vertex, push.vertexCount - 1u))));
    else
        result = mark(vertex);
    return result;
}
void storePair(uint pair) {
    vec4 first = resultOf(2u * pair), second = resultOf(2u * pair + 1u);
    if (2u * pair < push.vertexCount) results[pair] = stored(first, second);
}

void main() {
    readMatrices();
    // Groups of eight invocations take neighbouring pairs.
    uint item = itemIndex();
    uint first = (item & ~7u) * kPairsPerLane + (item & 7u);
    storePair(first);
    storePair(first + 8u);
    storePair(first + 16u);
    storePair(first + 24u);
    storePair(first + 32u);
    storePair(first + 40u);
    storePair(first + 48u);
    storePair(first + 56u);
    finish(push.statusSlot, 0u);
}
