// SPDX-License-Identifier: MIT
// Contract of the transform pass: object space -> screen. One composite matrix an object, composed on the host in
// binary64 relative to the camera and rounded once. Projection rows are in pixels: X = x / w + width / 2.
#ifndef PLUMB_TRANSFORM_H
#define PLUMB_TRANSFORM_H
#include "exact.h"
#include "fixed_point.h"
SHARED_BEGIN

struct ObjectRecord {
    vec4 rowX, rowY, rowW;           // clip x, y (pixels times w) and w (scene units) from object space
    vec4 world0, world1, world2;     // camera-relative world position from object space
    vec4 normal0, normal1, normal2;  // world normal from object normal (inverse transpose, scaled by a power of two)
};

struct Viewport {
    float centreX, centreY;  // pixels
    float guardX, guardY;    // pixels from the centre to the guard band
    float near;              // scene units, > 0
    uint droppedBits;        // lowest sub-pixel bits that vertices are not snapped to: 0 (1/256 px) or 4 (1/16 px)
};

struct ClipVertex {
    float x, y, w;
    vec3 attributes;  // world normal (Phong) or linear colour (Gouraud)
};

struct ScreenVertex {
    int x, y;      // sub-pixels; meaningless when `outcode` is not 0
    float z;       // near / w: 1 at the near plane, larger is nearer; also the perspective weight
    uint outcode;  // bit i: outside plane i
};

struct TransformPush {
    uint statusSlot;
    uint firstVertex, vertexCount;  // vertices of this dispatch
    uint object;
    Viewport viewport;
};

// Clip planes, in the order in which they are applied.
SHARED_CONST int kPlaneNear = 0;
SHARED_CONST int kPlaneLeft = 1;
SHARED_CONST int kPlaneRight = 2;
SHARED_CONST int kPlaneTop = 3;
SHARED_CONST int kPlaneBottom = 4;
SHARED_CONST int kClipPlanes = 5;

SHARED_FN float rowTimesPoint(vec4 row, vec3 p) { return ((row.x * p.x + row.y * p.y) + row.z * p.z) + row.w; }
SHARED_FN float rowTimesVector(vec4 row, vec3 v) { return (row.x * v.x + row.y * v.y) + row.z * v.z; }

// Signed distance to a clip plane, >= 0 inside. It is linear in (x, y, w), so it holds for any vertex, also behind the eye.
SHARED_FN float planeDistance(int plane, float x, float y, float w, Viewport v) {
    float distance = v.guardY * w - y;
    if (plane == kPlaneNear) distance = w - v.near;
    if (plane == kPlaneLeft) distance = x + v.guardX * w;
    if (plane == kPlaneRight) distance = v.guardX * w - x;
    if (plane == kPlaneTop) distance = y + v.guardY * w;
    return distance;
}

SHARED_FN uint outcodeOf(float x, float y, float w, Viewport v) {
    uint code = 0u;
    code |= pick(planeDistance(kPlaneNear, x, y, w, v) < 0.0f, 1u, 0u);
    code |= pick(planeDistance(kPlaneLeft, x, y, w, v) < 0.0f, 2u, 0u);
    code |= pick(planeDistance(kPlaneRight, x, y, w, v) < 0.0f, 4u, 0u);
    code |= pick(planeDistance(kPlaneTop, x, y, w, v) < 0.0f, 8u, 0u);
    code |= pick(planeDistance(kPlaneBottom, x, y, w, v) < 0.0f, 16u, 0u);
    return code;
}

// Nearest sub-pixel, ties to even. `limitPixels` bounds the result; it also catches coordinates divided by a tiny w, which will be clipped
// anyway.
SHARED_FN int snapCoarsely(float pixels, float limitPixels, uint droppedBits) {
    float x = pick(pixels > -limitPixels, pixels, -limitPixels);  // NaN goes to the limit
    x = pick(x < limitPixels, x, limitPixels);
    float steps = realOf(int((135u - droppedBits) << 23));  // 2^(8 - droppedBits) a pixel
    return shiftLeft(toInt(roundEvenReal(x * steps)), int(droppedBits));
}
SHARED_FN int snapToSubpixel(float pixels, float limitPixels) { return snapCoarsely(pixels, limitPixels, 0u); }

SHARED_FN ScreenVertex project(float x, float y, float w, Viewport v) {
    ScreenVertex s;
    s.outcode = outcodeOf(x, y, w, v);
    float safeW = pick(s.outcode == 0u, w, v.near);
    float safeX = pick(s.outcode == 0u, x, 0.0f);
    float safeY = pick(s.outcode == 0u, y, 0.0f);
    s.x = snapCoarsely(exactDivide(safeX, safeW) + v.centreX, 131072.0f, v.droppedBits);
    s.y = snapCoarsely(exactDivide(safeY, safeW) + v.centreY, 131072.0f, v.droppedBits);
    s.z = exactDivide(v.near, safeW);
    return s;
}

SHARED_END
#endif
