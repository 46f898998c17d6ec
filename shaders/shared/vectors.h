// SPDX-License-Identifier: MIT
// Contract of --trade light-vector=face and light-vector=vertex: the directions to the eye and to each point light are made once a face or
// vertex instead of once a pixel. face: at the centre of the face. vertex: at the corners of what is drawn (clipped ones too, all as they
// were snapped), and interpolated with the pixel's perspective shares.
// Interpolated directions are not normalised again. Between corners they are shorter; the highlight's 1 - R.V is |R - V|^2 / 2 of the
// vectors as they are. Attenuation is interpolated with its direction. A distant light has its one direction everywhere, a distant viewer
// too.
#ifndef PLUMB_VECTORS_H
#define PLUMB_VECTORS_H
#include "fill.h"
#include "shade.h"
SHARED_BEGIN

SHARED_CONST uint kVectorsPixel = 0u;
SHARED_CONST uint kVectorsFace = 1u;
SHARED_CONST uint kVectorsVertex = 2u;

struct Position {
    Real x, y, z;  // position relative to the eye, world axes
};

// Position of a corner of a drawn triangle: sub-pixels, n/w; rays as in FillPush.
SHARED_FN Position positionOfCorner(Int x, Int y, Real z, float near, vec3 rayOrigin, vec3 rayX, vec3 rayY) {
    Real px = toReal(x) * 0.00390625f;
    Real py = toReal(y) * 0.00390625f;
    Real w = reciprocal(z) * near;
    Position p;
    p.x = rayAtEach(rayOrigin.x, rayX.x, rayY.x, px, py) * w;
    p.y = rayAtEach(rayOrigin.y, rayX.y, rayY.y, px, py) * w;
    p.z = rayAtEach(rayOrigin.z, rayX.z, rayY.z, px, py) * w;
    return p;
}

SHARED_FN Toward eyeFrom(Position p) {
    Toward t;
    t.x = -p.x;
    t.y = -p.y;
    t.z = -p.z;
    t.fade = real(1.0f);
    unitVector(t.x, t.y, t.z);
    return t;
}

// Direction to a point light. Nearer than 2^-50 or, with 1 / d, 2^-100 the direction is undefined: such a light does not shine, and
// interpolated values stay finite.
SHARED_FN Toward lampFrom(vec4 lamp, float attenuation, Position p) {
    Toward t = towardLight(lamp, attenuation, true, p.x, p.y, p.z);
    t.fade = pick(gt(real(1.2676506e30f), t.fade), t.fade, real(0.0f));
    return t;
}

// Shares of the corners in a pixel, sum 1: edge values and weights of the corners as in weigh().
struct Shares {
    Real s0, s1, s2;
};
SHARED_FN Shares sharesOf(float w0, float w1, float w2, Real g0, Real g1, Real g2) {
    Real inverse = reciprocal(weigh(w0, w1, w2, g0, g1, g2));
    Shares s;
    s.s0 = (g1 * w0) * inverse;
    s.s1 = (g2 * w1) * inverse;
    s.s2 = (g0 * w2) * inverse;
    return s;
}
SHARED_FN Real shared3(Shares s, float a0, float a1, float a2) { return (s.s0 * a0 + s.s1 * a1) + s.s2 * a2; }

SHARED_END
#endif
