// SPDX-License-Identifier: MIT
// One invocation one vertex, by kMatrices matrices one after another. Straight-line: a loop over the matrices costs five times as much.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 256) in;
#include "shared/status.h"
#include "shared/product.h"

layout(constant_id = 2) const uint kMatrices = 1u;

layout(push_constant, scalar) uniform Push { VerticesPush push; };
layout(binding = 1) uniform samplerBuffer vertices;
layout(binding = 2, scalar) readonly buffer Matrices { Rows matrices[]; };   // the one that is applied first comes first
layout(binding = 3, scalar) writeonly buffer Results { vec4 results[]; };

void main() {
    uint item = itemIndex();
    vec4 p = texelFetch(vertices, int(min(item, push.vertexCount - 1u)));
    p = timesVector(matrices[0], p);
    if (kMatrices > 1u) p = timesVector(matrices[1], p);
    if (kMatrices > 2u) p = timesVector(matrices[2], p);
    if (kMatrices > 3u) p = timesVector(matrices[3], p);
    if (kMatrices > 4u) p = timesVector(matrices[4], p);
    if (kMatrices > 5u) p = timesVector(matrices[5], p);
    if (kMatrices > 6u) p = timesVector(matrices[6], p);
    if (item < push.vertexCount) results[item] = p;
    finish(push.statusSlot, 0u);
}
