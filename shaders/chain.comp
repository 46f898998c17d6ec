// SPDX-License-Identifier: MIT
// One invocation multiplies perLane consecutive matrices from left to right and leaves one. Repeated dispatches on the results form a tree
// whose order of factors is the chain's.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x_id = 3) in;  // few invocations are spread over the device's processors in small workgroups
#include "shared/status.h"
#include "shared/product.h"

layout(constant_id = 2) const bool kMultiplies = true;  // false: sums instead of products, to measure loading by itself
layout(constant_id = 4) const uint kPerLane =
    5u;  // perLane, or 5 where it is more: a pairwise tree has one product an invocation and no loop

layout(push_constant, scalar) uniform Push { ChainPush push; };
layout(binding = 1) uniform samplerBuffer factors;  // four texels a matrix
layout(binding = 2, scalar) writeonly buffer Products { Rows products[]; };

Rows times(Rows product, uint i) {
    int at = int(i) * 4;
    Rows factor = Rows(texelFetch(factors, at), texelFetch(factors, at + 1), texelFetch(factors, at + 2), texelFetch(factors, at + 3));
    return kMultiplies ? timesMatrix(product, factor) : sumOfRows(product, factor);
}
Rows timesIf(bool more, Rows product, uint i) {
    Rows next = times(product, i);
    return Rows(more ? next.r0 : product.r0, more ? next.r1 : product.r1, more ? next.r2 : product.r2, more ? next.r3 : product.r3);
}

void main() {
    uint item = itemIndex();
    uint first = min(item, push.laneCount - 1u) * push.perLane;
    uint last = min(first + push.perLane, push.matrixCount) - 1u;
    int at = int(first) * 4;
    Rows product = Rows(texelFetch(factors, at), texelFetch(factors, at + 1), texelFetch(factors, at + 2), texelFetch(factors, at + 3));
    // Factors that fill no whole step of the loop, at most three, come first. The loop then needs no test for a missing factor.
    uint few = (last - first) % kFactorsPerStep;
    product = timesIf(few > 0u, product, min(first + 1u, last));
    if (kPerLane > 2u) product = timesIf(few > 1u, product, min(first + 2u, last));
    if (kPerLane > 3u) product = timesIf(few > 2u, product, min(first + 3u, last));
    uint done = first + few;
    if (kPerLane > 4u && done < last) {
        do {
            product = times(times(times(times(product, done + 1u), done + 2u), done + 3u), done + 4u);
            done += kFactorsPerStep;
        } while (done < last);
    }
    if (item < push.laneCount) products[item] = product;
    finish(push.statusSlot, done < last ? kFaultLoop : 0u);
}
