// SPDX-License-Identifier: MIT
// Contract of hits: where a ray meets a sphere or a plane, and which colour of a board it finds there.
// Self-hits are excluded by object ID, not by an epsilon. A ray leaving a plane cannot hit that plane. A ray leaving a sphere outward
// cannot hit that sphere; a ray entering a sphere hits it only at the far side. Origins are moved off the surface besides (ray.h).
#ifndef PLUMB_HIT_H
#define PLUMB_HIT_H
#include "ray.h"
SHARED_BEGIN

SHARED_CONST uint kNoObject = 0xffffffffu;

// Position of a ray's start with respect to the object that is tested.
SHARED_CONST uint kStartElsewhere = 0u;
SHARED_CONST uint kStartOutside = 1u;  // on it, leaving on the side of its normal
SHARED_CONST uint kStartInside = 2u;

SHARED_FN uint startOn(uint object, uint from, bool inside) {
    return pick(object == from, pick(inside, kStartInside, kStartOutside), kStartElsewhere);
}

// True when a hit replaces the best so far: the nearest wins, at equal distance the object with the smaller index. So the result does not
// depend on the order of visits.
SHARED_FN bool isNearer(float t, uint object, float bestT, uint best) { return t > 0.0f && (t < bestT || (t == bestT && object < best)); }

// Value of o - c + k d, rounded about once: difference and product are taken with their errors (Knuth, Dekker). Products below 2^-60 count
// as exact, so that no error term is subnormal.
SHARED_FN float upperHalf(float x) {
    float scaled = x * 4097.0f;
    return scaled - (scaled - x);
}
SHARED_FN float productError(float a, float b, float product) {
    float ah = upperHalf(a);
    float al = a - ah;
    float bh = upperHalf(b);
    float bl = b - bh;
    float error = al * bl - (((product - ah * bh) - al * bh) - ah * bl);
    return pick(abs(product) > 8.6736173798840355e-19f, error, 0.0f);
}
SHARED_FN float pointOnLine(float o, float c, float k, float d) {
    float high = o - c;
    float back = high - o;
    float low = (o - (high - back)) - (c + back);
    float product = k * d;
    float sum = high + product;
    float part = sum - high;
    float lost = (high - (sum - part)) + (product - part);
    return sum + ((lost + productError(k, d, product)) + low);
}

struct SphereHit {
    float t;      // distance; 0: none
    vec3 offset;  // vector from the centre to the hit
};

// Power of p with respect to a sphere, |p - c|^2 - r^2, from the power of the eye (the origin), which the host computes without
// cancellation. The result is within 5 u sum |p_i| |p_i - 2 c_i| of the power for centre c and radius sqrt(|c|^2 - power): the nearer p is
// to the eye, the better.
SHARED_FN float powerAt(vec3 p, vec3 c, float power) { return power + dot3(p, p - (c + c)); }

// True when powerAt() serves a ray from o: the eye and o lie within two radii of the centre. Farther away, f.f - r^2 is as good.
SHARED_FN bool startsClose(vec3 o, vec3 c, float r) {
    vec3 f = o - c;
    float reach = 4.0f * (r * r);
    return dot3(c, c) < reach && dot3(f, f) < reach;
}

// Hit of a sphere with centre c and radius r in [2^-30, 2^60]. k: distance along the ray to the point nearest to the centre. l: vector from
// the centre to that point. h: half the chord.
// From outside t = (f.f - r^2) / (k + h), without the cancellation of k - h. From inside h^2 = k^2 + (r^2 - f.f), both summands positive.
// `far` (a sphere farther than 256 radii): l is computed to about one rounding instead of u |f| (docs/accuracy.md, Rays).
// `close` (the eye within 1/16 radius of some surface): r^2 - l.l and f.f - r^2 would keep an error of u r^2 in a gap that may be 2^-30 r.
// There f.f - r^2 comes from `power`, that of the eye, and h^2 = k^2 - (f.f - r^2) outside too.
SHARED_FN SphereHit hitSphere(vec3 o, vec3 d, vec3 c, float r, float power, uint start, bool far, bool close) {
    vec3 f = o - c;
    float k = -dot3(f, d);
    vec3 l = f + d * k;
    if (far) {
        l = vec3(pointOnLine(o.x, c.x, k, d.x), pointOnLine(o.y, c.y, k, d.y), pointOnLine(o.z, c.z, k, d.z));
        float again = -dot3(l, d);
        l = l + d * again;
        k = k + again;
    }
    float outside = dot3(f, f) - r * r;
    float square = r * r - dot3(l, l);
    bool gap = false;
    if (close) {
        gap = startsClose(o, c, r);
        outside = pick(gap, powerAt(o, c, power), outside);
    }
    bool within = outside <= 0.0f;
    bool ahead = k > 0.0f;
    square = pick(within || gap, k * k - outside, square);
    bool meets = square >= 0.0f;
    // no plant: the root of a negative number is not used
    float h = exactRoot(pick(meets, square, 0.0f));
    float sum = abs(k) + h;
    // no plant: 0 / 0 is not used
    float quotient = exactDivide(abs(outside), pick(sum > 0.0f, sum, 1.0f));
    float leaving = pick(ahead, sum, quotient);
    float entering = pick(ahead && meets, quotient, 0.0f);
    SphereHit hit;
    hit.t = pick(within, leaving, entering);
    // A ray that starts on the sphere has f.f = r^2. From inside the far side is 2 k away; from outside there is no hit. The origin has
    // been moved in by some 30 u r, which `power` can tell: then the distance is k + h.
    bool own = start != kStartElsewhere;
    float half_ = pick(gap && h > k, h, k);
    float across = pick(start == kStartInside && ahead, k + half_, 0.0f);
    hit.t = pick(own, across, hit.t);
    hit.t = pick(hit.t <= kFarthestHit, hit.t, 0.0f);
    float side = pick(within, h, -h);
    side = pick(own, half_, side);
    hit.offset = l + d * side;
    return hit;
}

// Point where a ray meets a surface. It lies within sum |n_i| error_i of the surface.
struct SurfacePoint {
    vec3 point, normal, error;
};

// Point on a sphere. |normal| = 1 within 9 u, so c + r n is within 9 u r + 2 u |p_i| + u r of the sphere (one product, one sum a
// coordinate).
SHARED_FN SurfacePoint pointOnSphere(vec3 c, float r, vec3 offset) {
    SurfacePoint s;
    s.normal = unitLength(offset);
    s.point = c + s.normal * r;
    s.error = (magnitudes(s.point) * 4.0f + vec3(12.0f * r)) * 5.9604644775390625e-8f;
    return s;
}

// Point on a sphere that is close to the eye. There c + r n would keep an error of u r in a position that may be 2^-30 r away. The point is
// instead the position along the ray (c + r n for a ray from afar), stepped back by its height h above the surface, (|p - c|^2 - r^2) / 2r.
// The power of p is within 5 u sum |p_i| |p_i - 2 c_i|, so h is within 2.5 u of that sum over r. The step leaves h^2 / 2r and 9 u h (n is
// not quite unit); |h| < 2^-17 r, so both are below |h| 2^-17.
SHARED_FN SurfacePoint pointOnCloseSphere(vec3 o, vec3 d, float t, vec3 c, float r, float power, vec3 offset) {
    SurfacePoint s = pointOnSphere(c, r, offset);
    vec3 p = chosen(startsClose(o, c, r), o + d * t, s.point);
    float height = exactDivide(snapTiny(powerAt(p, c, power)), r + r);
    s.point = p - s.normal * height;
    float lost = exactDivide(snapTiny(dot3(magnitudes(p), magnitudes(p - (c + c)))), r) * (3.0f * 5.9604644775390625e-8f);
    s.error = magnitudes(s.point) * (4.0f * 5.9604644775390625e-8f) + vec3(lost + abs(height) * 7.62939453125e-6f);
    return s;
}

// Plane n.x = distance. (u, v) = (U.x + u0, V.x + v0) are the board's coordinates, in the scene's lengths times the passes' unit.
struct PlaneRecord {
    vec3 normal;
    float distance;
    vec3 u;
    float u0;
    vec3 v;
    float v0;
    float uMin, uMax, vMin, vMax;  // bounds, inclusive
    float square;                  // side of a board's squares; 0: no board
    float mirrored;                // 1: the board is mirrored at v = 0, as the notes' is; 0: squares alternate across it
    float twoSided;                // 0: rays that run with the normal pass
    float other;                   // material of the board's other squares
};
SHARED_CONST int kPlaneTexels = 5;

struct PlaneHit {
    float t;  // distance; 0: none
    vec3 point;
    float u, v;
    uint undecided;  // 1: the ray is parallel to the plane within rounding; counted, not hit
};

SHARED_FN PlaneHit hitPlane(vec3 o, vec3 d, vec4 plane, vec4 u, vec4 v, vec4 bounds, bool twoSided, uint start) {
    vec3 n = vec3(plane.x, plane.y, plane.z);
    float slope = dot3(n, d);
    // Error of n.d: 3 u sum |n_i d_i| (docs/accuracy.md, Rays). 2^-40: the direction itself is not known better.
    float reach = dot3(magnitudes(n), magnitudes(d));
    bool decided = abs(slope) > 2.384185791015625e-7f * reach + 9.094947017729282e-13f;
    // no plant: the quotient of an undecided slope is not used
    float t = exactDivide(snapTiny(plane.w - dot3(n, o)), pick(decided, slope, 1.0f));
    bool faces = twoSided || slope < 0.0f;
    bool elsewhere = start == kStartElsewhere;
    bool reached = t > 0.0f && t <= kFarthestHit;
    PlaneHit hit;
    hit.undecided = pick(decided || !elsewhere, 0u, 1u);
    t = pick(decided && faces && elsewhere && reached, t, 0.0f);
    vec3 p = o + d * t;
    p = p + n * (plane.w - dot3(n, p));
    hit.point = p;
    hit.u = dot3(vec3(u.x, u.y, u.z), p) + u.w;
    hit.v = dot3(vec3(v.x, v.y, v.z), p) + v.w;
    bool bounded = hit.u >= bounds.x && hit.u <= bounds.y && hit.v >= bounds.z && hit.v <= bounds.w;
    hit.t = pick(bounded, t, 0.0f);
    return hit;
}

// Error along the normal after projecting the hit back to the plane: at most 7 u sum |n_i p_i| (dot product 4, distance 2, addition 1). 12
// u |p_i| a coordinate covers it.
SHARED_FN SurfacePoint pointOnPlane(vec3 normal, vec3 point) {
    SurfacePoint s;
    s.normal = normal;
    s.point = point;
    s.error = magnitudes(point) * (12.0f * 5.9604644775390625e-8f);
    return s;
}

// True when |x| lies in an odd square, counted from 0: the notes' |x| mod 2 s > s. The end of an even square belongs to it, that of an odd
// square does not.
SHARED_FN bool oddSquare(float x, float square) {
    float m = exactDivide(abs(x), square);
    float pairs = floorReal(m * 0.5f);
    return m - (pairs + pairs) > 1.0f;
}

// True when (u, v) has the board's second material. The square at the origin with u, v >= 0 has the first; neighbours alternate.
// `mirrored`: the pattern is mirrored at v = 0.
SHARED_FN bool otherSquare(float u, float v, float square, float mirrored) {
    bool other = u < 0.0f;
    other = other != oddSquare(u, square);
    other = other != oddSquare(v, square);
    return other != (v < 0.0f && mirrored == 0.0f);
}

SHARED_END
#endif
