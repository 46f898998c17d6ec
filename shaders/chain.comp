// SPDX-License-Identifier: MIT
// One invocation multiplies perLane consecutive matrices from the left to the right and leaves one. Dispatched again on what it left,
// that is a tree whose order of factors is the chain's.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "shared/status.h"
#include "shared/product.h"

layout(push_constant, scalar) uniform Push { ChainPush push; };
layout(binding = 1) uniform samplerBuffer factors;                        // four texels a matrix
layout(binding = 2, scalar) writeonly buffer Products { Rows products[]; };

Rows factor(uint i) {
    int at = int(i) * 4;
    return Rows(texelFetch(factors, at), texelFetch(factors, at + 1), texelFetch(factors, at + 2), texelFetch(factors, at + 3));
}

void main() {
    uint item = itemIndex();
    uint first = min(item, push.laneCount - 1u) * push.perLane;
    uint last = min(first + push.perLane, push.matrixCount) - 1u;
    Rows product = factor(first);
    uint at = first;
    uint steps = 1u;
    do {
        Rows next = timesMatrix(product, factor(min(at + 1u, last)));
        bool more = at < last;
        product.r0 = more ? next.r0 : product.r0;
        product.r1 = more ? next.r1 : product.r1;
        product.r2 = more ? next.r2 : product.r2;
        product.r3 = more ? next.r3 : product.r3;
        at = more ? at + 1u : at;
        steps++;
    } while (steps < push.perLane);
    if (item < push.laneCount) products[item] = product;
    finish(push.statusSlot, at < last ? kFaultLoop : 0u);
}
