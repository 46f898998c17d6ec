// SPDX-License-Identifier: MIT
// Contract of rays: origin and direction, the origin of a ray that leaves a surface, its mirrored and its refracted direction.
// Lengths are in the passes' unit, positions relative to the eye, axes the world's. u = 2^-24.
#ifndef PLUMB_RAY_H
#define PLUMB_RAY_H
#include "exact.h"
#include "shade.h"
SHARED_BEGIN

SHARED_CONST float kFarthestHit = 1.152921504606846976e18f;  // 2^60: its square stays finite; farther hits do not count

SHARED_FN float dot3(vec3 a, vec3 b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
SHARED_FN vec3 chosen(bool c, vec3 yes, vec3 no) { return vec3(pick(c, yes.x, no.x), pick(c, yes.y, no.y), pick(c, yes.z, no.z)); }
SHARED_FN vec3 magnitudes(vec3 a) { return vec3(abs(a.x), abs(a.y), abs(a.z)); }

// Unit vector along v, |v| in [2^-60, 2^60]. Its length is 1 within 9 u (root 4 u, sum of squares halved 2 u, product 1 u, second order).
SHARED_FN vec3 unitLength(vec3 v) {
    float inverse = reciprocalRoot(real(dot3(v, v)));
    return v * inverse;
}

// Origin of a ray that leaves a surface at p, on the side of n. p lies within sum |n_i| error_i of the surface, measured along n. The shift
// is twice that sum. It also covers its own roundings (5 u of the sum) and those of p + shift, at most u (|p_i| + shift) a coordinate.
// error_i is at least 4 u |p_i| for every kind of surface.
SHARED_FN vec3 leaveSurface(vec3 p, vec3 n, vec3 error) {
    float shift = 2.0f * dot3(magnitudes(n), error);
    return p + n * shift;
}

// Mirror direction about n, which faces the ray (cosine = -d.n >= 0). The notes' N + T / (2 N.(-T)), scaled: no division.
SHARED_FN vec3 mirrored(vec3 d, vec3 n, float cosine) { return unitLength(d + n * (2.0f * cosine)); }

// Squared cosine of the refracted angle, 1 - sin^2; ratio = index on the ray's side / index beyond. Total reflection when it is not above
// 0. (1 - c)(1 + c) stands for 1 - c^2: no cancellation near normal incidence.
SHARED_FN float refractedSquare(float cosine, float ratio) { return 1.0f - (ratio * ratio) * ((1.0f - cosine) * (1.0f + cosine)); }
SHARED_FN vec3 refracted(vec3 d, vec3 n, float cosine, float ratio, float square) {
    return unitLength(d * ratio + n * (ratio * cosine - exactRoot(square)));
}

SHARED_END
#endif
