// SPDX-License-Identifier: MIT
// Contract of the products that `plumb bench matrix` measures: matrix times vector, matrix times matrix, float32, in a stated order.
// No picture uses this file: the passes use one composite that the host makes (transform.h).
#ifndef PLUMB_PRODUCT_H
#define PLUMB_PRODUCT_H
#include "bridge.h"
SHARED_BEGIN

SHARED_CONST uint kMostMatrices = 7u;  // matrices applied one after another

struct Rows {
    vec4 r0, r1, r2, r3;  // rows of a 4 x 4 matrix, for column vectors
};

struct VertexPair {
    vec4 first, second;  // neighbours; results are stored in pairs
};
SHARED_CONST uint kPairsPerLane = 8u;  // pairs an invocation

struct VerticesPush {
    uint statusSlot;
    uint vertexCount;
};

struct ChainPush {
    uint statusSlot;
    uint matrixCount;
    uint perLane;  // consecutive matrices that an invocation multiplies, 2 to kMostPerLane
    uint laneCount;
};
SHARED_CONST uint kFactorsPerStep = 4u;    // factors a step of an invocation's loop
SHARED_CONST uint kMostPerLane = 240000u;  // 60,000 steps: lavapipe ends a loop after 65,535

SHARED_FN float rowTimes(vec4 row, vec4 p) { return ((row.x * p.x + row.y * p.y) + row.z * p.z) + row.w * p.w; }
SHARED_FN vec4 timesVector(Rows m, vec4 p) { return vec4(rowTimes(m.r0, p), rowTimes(m.r1, p), rowTimes(m.r2, p), rowTimes(m.r3, p)); }
// Value stored for vertex i where only storing is measured: i times the first row.
SHARED_FN vec4 markOf(Rows m, uint vertex) { return m.r0 * float(vertex); }
SHARED_FN vec4 timesRows(vec4 row, Rows b) { return ((b.r0 * row.x + b.r1 * row.y) + b.r2 * row.z) + b.r3 * row.w; }
SHARED_FN Rows timesMatrix(Rows a, Rows b) {
    Rows m;
    m.r0 = timesRows(a.r0, b);
    m.r1 = timesRows(a.r1, b);
    m.r2 = timesRows(a.r2, b);
    m.r3 = timesRows(a.r3, b);
    return m;
}
// Sum in place of the product, where only loading is measured.
SHARED_FN Rows sumOfRows(Rows a, Rows b) {
    Rows m;
    m.r0 = a.r0 + b.r0;
    m.r1 = a.r1 + b.r1;
    m.r2 = a.r2 + b.r2;
    m.r3 = a.r3 + b.r3;
    return m;
}

SHARED_END
#endif
