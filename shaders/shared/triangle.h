// SPDX-License-Identifier: MIT
// Contract of rays and triangles: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection" (2013), without a fused operation, and boxes.
// In the sheared space of a ray a corner has the same coordinates in every triangle, and the sign of an edge value is exact. Rounding is
// monotone, so p - q of two rounded products has the sign of the exact difference or is 0, and then the products' errors decide. A point on
// an edge belongs to both triangles: no ray passes between them, and the triangle with the smaller index is hit.
#ifndef PLUMB_TRIANGLE_H
#define PLUMB_TRIANGLE_H
#include "hit.h"
SHARED_BEGIN

// Ray in the form that triangles and boxes read.
struct RayFrame {
    vec3 origin, direction;
    vec3 inverse;  // 1 / direction; 2^60 in magnitude where that is smaller
    uint axis;     // of the largest |direction|
    float shearX, shearY, scale;
    float pad;  // boxes are widened by the error of a sheared corner: 8 u of all lengths in it
};

SHARED_FN float safeInverse(float x) {
    float least = 8.6736173798840355e-19f;  // 2^-60
    float instead = pick(x < 0.0f, -least, least);
    return exactDivide(1.0f, pick(abs(x) > least, x, instead));
}

// Coordinates in cyclic order with the given axis last.
SHARED_FN vec3 turned(vec3 v, uint axis) {
    vec3 one = chosen(axis == 1u, vec3(v.z, v.x, v.y), v);
    return chosen(axis == 0u, vec3(v.y, v.z, v.x), one);
}

// Frame of a ray. reach: the largest |coordinate| of a corner.
SHARED_FN RayFrame frameOfRay(vec3 o, vec3 d, float reach) {
    RayFrame f;
    f.origin = o;
    f.direction = d;
    f.inverse = vec3(safeInverse(d.x), safeInverse(d.y), safeInverse(d.z));
    vec3 size = magnitudes(d);
    f.axis = pick(size.y > size.x, 1u, 0u);
    f.axis = pick(size.z > size.x && size.z > size.y, 2u, f.axis);
    vec3 along = turned(d, f.axis);
    vec3 inverse = turned(f.inverse, f.axis);
    f.shearX = along.x * inverse.z;
    f.shearY = along.y * inverse.z;
    f.scale = inverse.z;
    f.pad = (((abs(o.x) + abs(o.y)) + abs(o.z)) + reach) * 4.76837158203125e-7f;
    return f;
}

SHARED_FN float lesser(float a, float b) { return pick(a < b, a, b); }
SHARED_FN float greater(float a, float b) { return pick(a > b, a, b); }
SHARED_FN vec3 lesser3(vec3 a, vec3 b) { return vec3(lesser(a.x, b.x), lesser(a.y, b.y), lesser(a.z, b.z)); }
SHARED_FN vec3 greater3(vec3 a, vec3 b) { return vec3(greater(a.x, b.x), greater(a.y, b.y), greater(a.z, b.z)); }

// Distances at which a ray enters and leaves a box, up to rounding: entry <= leave * (1 + 8 u) when it meets the box. Both are monotone in
// the box, so a box within another is entered no earlier.
SHARED_FN float entryOfBox(RayFrame f, vec3 low, vec3 high) {
    vec3 a = ((low - f.origin) - vec3(f.pad)) * f.inverse;
    vec3 b = ((high - f.origin) + vec3(f.pad)) * f.inverse;
    vec3 nearer = lesser3(a, b);
    return greater(greater(nearer.x, nearer.y), nearer.z);
}
SHARED_FN float exitOfBox(RayFrame f, vec3 low, vec3 high) {
    vec3 a = ((low - f.origin) - vec3(f.pad)) * f.inverse;
    vec3 b = ((high - f.origin) + vec3(f.pad)) * f.inverse;
    vec3 farther = greater3(a, b);
    return lesser(lesser(farther.x, farther.y), farther.z) * 1.00000048f;
}
// True when the ray may hit something in the box: it meets the box, not behind the origin and not beyond the nearest hit.
SHARED_FN bool opens(float entry, float leave, float nearest) { return entry <= leave && leave >= 0.0f && entry <= nearest; }

// Bundle of rays from one origin: least and greatest inverse directions. A rounded product is monotone in each factor. So the products with
// both ends enclose that with every ray's inverse: no ray of the bundle enters earlier or leaves later.
struct RayBundle {
    vec3 origin, least, most;
    float pad;
};
SHARED_FN float earliestEntry(RayBundle f, vec3 low, vec3 high) {
    vec3 a = (low - f.origin) - vec3(f.pad);
    vec3 b = (high - f.origin) + vec3(f.pad);
    vec3 earliest = lesser3(lesser3(a * f.least, a * f.most), lesser3(b * f.least, b * f.most));
    return greater(greater(earliest.x, earliest.y), earliest.z);
}
SHARED_FN float latestExit(RayBundle f, vec3 low, vec3 high) {
    vec3 a = (low - f.origin) - vec3(f.pad);
    vec3 b = (high - f.origin) + vec3(f.pad);
    vec3 latest = greater3(greater3(a * f.least, a * f.most), greater3(b * f.least, b * f.most));
    return lesser(lesser(latest.x, latest.y), latest.z) * 1.00000048f;
}

// Difference a b - c d with the exact sign.
SHARED_FN float crossValue(float a, float b, float c, float d) {
    float p = a * b;
    float q = c * d;
    float value = p - q;
    return pick(value == 0.0f, productError(a, b, p) - productError(c, d, q), value);
}

struct TriangleHit {
    float t;           // distance; 0: none
    float w0, w1, w2;  // weights of the corners, sum 1 within 3 u
};

SHARED_FN vec3 sheared(RayFrame f, vec3 corner) {
    vec3 c = turned(corner - f.origin, f.axis);
    return vec3(c.x - f.shearX * c.z, c.y - f.shearY * c.z, c.z * f.scale);
}

// Hit of a triangle. It counts only when the ray also hits the triangle's own box, and its distance is not before the entry into that box.
// So a box of the BVH may be skipped when the ray misses it or has a hit nearer than its entry: no triangle in it can win, whatever the
// tree and the order. `own`: the ray starts on this triangle.
SHARED_FN TriangleHit hitTriangle(RayFrame f, vec3 p0, vec3 p1, vec3 p2, bool own) {
    vec3 a = sheared(f, p0);
    vec3 b = sheared(f, p1);
    vec3 c = sheared(f, p2);
    float u = crossValue(c.x, b.y, c.y, b.x);
    float v = crossValue(a.x, c.y, a.y, c.x);
    float w = crossValue(b.x, a.y, b.y, a.x);
    bool front = u >= 0.0f && v >= 0.0f && w >= 0.0f;
    bool back = u <= 0.0f && v <= 0.0f && w <= 0.0f;
    float sum = (u + v) + w;
    bool meets = (front || back) && abs(sum) > 1.1754943508222875e-38f && !own;
    // no plant: x / 0 is not used
    float inverse = exactDivide(1.0f, pick(meets, sum, 1.0f));
    TriangleHit hit;
    hit.w0 = u * inverse;
    hit.w1 = v * inverse;
    hit.w2 = w * inverse;
    float t = (hit.w0 * a.z + hit.w1 * b.z) + hit.w2 * c.z;
    vec3 low = lesser3(lesser3(p0, p1), p2);
    vec3 high = greater3(greater3(p0, p1), p2);
    float entry = entryOfBox(f, low, high);
    bool ahead = t > 0.0f && t <= kFarthestHit;
    hit.t = pick(meets && ahead, greater(t, entry), 0.0f);
    bool open = opens(entry, exitOfBox(f, low, high), kFarthestHit);
    // no plant: the pad of a box exceeds the error of a hit in every case that is known; the order must not hang on that
    hit.t = pick(open, hit.t, 0.0f);
    return hit;
}

// Hit point on a triangle. normal: geometric, outward. The point is a weighted mean: three products and two sums a coordinate, weights
// within 3 u: 8 u sum |w_i p_i|.
SHARED_FN SurfacePoint pointOnTriangle(vec3 p0, vec3 p1, vec3 p2, vec3 normal, TriangleHit hit) {
    SurfacePoint s;
    s.normal = normal;
    s.point = (p0 * hit.w0 + p1 * hit.w1) + p2 * hit.w2;
    s.error = ((magnitudes(p0 * hit.w0) + magnitudes(p1 * hit.w1)) + magnitudes(p2 * hit.w2)) * (10.0f * 5.9604644775390625e-8f);
    return s;
}

// Least slope against the polygon of a ray that leaves it where ray d arrived: half the slope of d, and no more than kLeastSlope.
// A ray along the polygon would tie with every coplanar neighbour. The least slope goes to 0 with that of d, so that the directions of rays
// that leave are continuous in d.
SHARED_CONST float kLeastSlope = 0.0009765625f;
SHARED_FN float leastSlope(vec3 d, vec3 n) { return lesser(abs(dot3(d, n)) * 0.5f, kLeastSlope); }

// Unit direction d, turned toward n where its part along n is less than slope. That part is then the slope, and d is normalised again. Not
// for d near -n.
SHARED_FN vec3 onSideOf(vec3 d, vec3 n, float slope) {
    float along = dot3(d, n);
    return chosen(along < slope, unitLength(d + n * (slope - along)), d);
}

// Normal that mirrors and bends rays at a mesh (light takes the interpolated one). It is the interpolated normal unless that sends the
// mirrored ray into the polygon. Then the mirrored ray leaves with the least slope, and the normal stands half-way: both rules agree where
// one ends and the other begins. A ray that an interpolated normal faces away from goes straight on. Both given normals are turned with the
// ray's side of the polygon.
// Below kLeastLean the projection onto the polygon could vanish. Below 2^-18 of a half-way vector its direction is rounding; the mirrored
// ray of the geometric normal differs by less than twice that.
SHARED_CONST float kLeastLean = 0.0625f;
SHARED_FN vec3 normalForRays(vec3 d, vec3 geometric, vec3 smooth_) {
    float cosine = -dot3(d, smooth_);
    vec3 image = d + smooth_ * (2.0f * pick(cosine > 0.0f, cosine, 0.0f));
    float slope = leastSlope(d, geometric);
    vec3 half_ = onSideOf(image, geometric, slope) - d;
    bool long_ = dot3(half_, half_) > 1.4551915228366851807e-11f;
    vec3 bent = chosen(long_, unitLength(half_), geometric);
    bent = chosen(dot3(image, geometric) < slope, bent, smooth_);
    return chosen(dot3(smooth_, geometric) > kLeastLean, bent, geometric);
}

SHARED_END
#endif
