// SPDX-License-Identifier: MIT
// Contract of the spheres pass: the implicit sphere rendering of the lecture notes (section 16.5).
//
// No mesh and no ray: a sphere is seen in parallel projection by a viewer who looks along +Z, one unit a pixel. Let x, y be the distance
// from the pixel of its centre, x to the right and y up. The pixels with x^2 + y^2 <= r^2 are the sphere's picture. z = sqrt(r^2 - x^2 -
// y^2) toward the viewer makes (x, y, z) its normal. Each pixel is illuminated (shade.h) with the view vector (0, 0, -1).
// The notes' program rounds z to a whole number first, their text does not (erratum B23): push.wholeHeights says which. The notes leave
// open which of several spheres over a pixel is seen: here the nearer one, of equal depths the first.
#ifndef PLUMB_SPHERES_H
#define PLUMB_SPHERES_H
#include "exact.h"
#include "shade.h"
SHARED_BEGIN

SHARED_CONST int kSphereReach = 4096;    // r^2 <= 2^24 is exact as a float
SHARED_CONST int kSpheresOfRow = 50000;  // an invocation may loop 65,535 times, over spheres and lights together
SHARED_CONST int kSphereLights = 10000;
SHARED_CONST uint kNoSphere = 0xffffffffu;
SHARED_CONST float kSphereFarthest = 3.0e38f;  // beyond every depth

struct SphereDisc {
    int column, row;    // pixel of the centre, on the canvas or not
    int reach;          // whole part of r, 1 to kSphereReach
    int radiusSquared;  // whole part of r^2
    vec3 centre;        // centre relative to the eye, world axes, in the passes' lengths
    float depth;        // depth of the centre along +Z from the eye, in the same lengths
    uint material;
};

struct SpheresPush {
    uint statusSlot;
    uint width;
    uint firstRow, rowCount;  // rows of this dispatch
    uint lightCount;
    uint wholeHeights;  // 1: z is rounded to a whole number
    float unit;         // length of a pixel in the passes' lengths, a power of two
};

// True when the sphere covers the pixel at (x, y) from its centre, y up.
SHARED_FN bool sphereCovers(SphereDisc s, int x, int y) { return abs(x) <= s.reach && x * x + y * y <= s.radiusSquared; }

// Height z of a covered pixel, in pixels. The whole number nearest to sqrt(n) is k or k + 1 for k <= sqrt(n). It is never a tie, as (k +
// 1/2)^2 is no whole number, so n > k^2 + k decides. A root that was rounded up to a whole number is that number.
SHARED_FN float sphereHeight(SphereDisc s, int x, int y, uint wholeHeights) {
    int n = s.radiusSquared - (x * x + y * y);
    float root = exactRoot(toReal(n));
    int k = toInt(root);
    float whole = toReal(k + pick(n > k * k + k, 1, 0));
    return pick(wholeHeights != 0u, whole, root);
}

SHARED_FN float sphereDepth(SphereDisc s, float height, float unit) { return s.depth - height * unit; }

SHARED_FN bool sphereNearer(float depth, float stored) { return depth < stored; }

SHARED_FN Surface sphereSurface(SphereDisc s, int x, int y, float height, float unit) {
    Surface p;
    p.nx = toReal(x);
    p.ny = toReal(y);
    p.nz = -height;
    p.px = s.centre.x + p.nx * unit;
    p.py = s.centre.y + p.ny * unit;
    p.pz = s.centre.z + p.nz * unit;
    unitVector(p.nx, p.ny, p.nz);
    p.vx = 0.0f;
    p.vy = 0.0f;
    p.vz = -1.0f;
    return p;
}

SHARED_END
#endif
