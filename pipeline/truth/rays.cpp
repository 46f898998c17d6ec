// SPDX-License-Identifier: MIT
#include "pipeline/truth/rays.h"

#include "pipeline/truth/highlight_error.h"
#include "pipeline/truth/shading_error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <type_traits>

namespace plumb::truth {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Linear light: what a decision may move at most without being made again. A thousandth of what the steepest part of the sRGB curve makes of 2^-8 steps.
constexpr double kNothing = 0x1p-30;
// A direction that is known no better, or no better for what its ray weighs, has its tree followed again.
constexpr double kVagueDirection = 0x1p-10;
constexpr double kVagueColour = 0x1p-20;
// Error of R.V from vectors that are rounded to binary64, and from its own operations.
constexpr double kMirrorRounding = 24 * kDoubleUnit;
constexpr double kCoarserCut = 16;

enum class Kind { none, sphere, plane, facet };

double largest(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }
// No smaller than the vector's length.
template <class Real>
double sizeOf(const Vec3<Real>& v) {
    return std::abs(double(v.x)) + std::abs(double(v.y)) + std::abs(double(v.z));
}

constexpr double kSingle = 0x1p-24;          // unit round-off of float32
constexpr double kUnitLength = 9 * kSingle;  // error of the length of the passes' unit vectors (unitLength)

// Arithmetic of a tree: what it computes in, and the unit round-off in which its errors are counted.
template <class Number>
struct Computed {
    using Real = Number;
    static constexpr double kUnit = kUnitOf<Number>;
    static constexpr bool kDrawn = false;
};
// Binary64 with the errors of the passes (docs/derivations.md, A traced picture). Two float32 round-offs for each that is counted, since
// the passes' formulas are others.
struct AsDrawn {
    using Real = double;
    static constexpr double kUnit = 2 * kSingle;
    static constexpr bool kDrawn = true;
};
constexpr double kDrawnVague = 0x1p-6;     // errors above it are no longer of first order
constexpr double kDrawnNothing = 0x1p-20;  // linear light: open decisions about less are part of the bound
// Error of specularPower, and the least base of its power (shade.h).
constexpr double kPowerError = (1.7e-7 + 4.5 * kSingle) / 2.718281828 + 7.5e-8 + 3 * kSingle, kPowerFloor = 0x1p-20;

// Follows one tree of rays.
template <class Arithmetic>
class Tracer {
public:
    using Real = typename Arithmetic::Real;
    using V = Vec3<Real>;
    static constexpr double kUnit = Arithmetic::kUnit;
    static constexpr bool kDrawn = Arithmetic::kDrawn;
    static constexpr bool kLast = std::is_same_v<Real, Quad>;  // nothing more exact follows: what is open is counted

    Tracer(const RayWorld& world, const glm::dvec3& sky, const RayLimits& limits, double brightest, double farthest, double leastWeight)
        : world_(world),
          scene_(world.scene()),
          sky_(sky),
          limits_(limits),
          brightest_(brightest),
          farthest_(farthest),
          leastWeight_(leastWeight) {}

    void look(const Pinhole& p, double x, double y) {
        Ray ray;
        ray.pointing = V(p.forward) * Real(p.focal) + V(p.right) * Real(x) + V(p.down) * Real(y);
        ray.length = lengthOf(ray.pointing);
        ray.direction = ray.pointing * (1 / ray.length);
        ray.directionError = 12 * kUnit;
        if (kDrawn) {
            // Three rounded rows, two products and two sums of parts that cancel, and a product more; sqrt(3) for the vector.
            const double parts = (p.focal + p.width + p.height + std::abs(x) + std::abs(y)) / double(ray.length);
            ray.directionError = 1.7320509 * kSingle * (5 * parts + 2);
        }
        follow(ray);
    }
    bool primaryIsOpen() const { return primaryOpen_; }
    const glm::dvec3& bound() const { return bound_; }
    double distanceError() const { return distanceError_; }
    bool doubtful() const { return doubtful_; }
    bool tooMany() const { return rays_ > limits_.mostRays; }
    uint32_t rays() const { return rays_; }
    uint64_t undecided() const { return undecided_; }
    const RaySeen& seen() const { return seen_; }
    // What was seen, with the truth's own error. `boundedBy`: no ray is brighter; +infinity where nothing is known of that.
    RaySeen judged(double boundedBy) const {
        RaySeen out = seen_;
        // Rays that were not followed, and decisions that little hangs on: a way to say that either answer may be the right one.
        const double left = out.leftOut + (open_ > 0 ? open_ / brightest_ : 0);
        out.bound = bound_ + (left > 0 ? left * boundedBy : 0.0);
        // Each product and sum of weights, shares and colours once, all of them positive.
        out.bound += out.colour * (double(roundings_) * kDoubleUnit) + kUnderflow;
        out.bound *= kOwnRounding;
        out.distanceError = distanceError_;
        out.decided = !doubtful_ && !primaryOpen_;
        return out;
    }

private:
    struct Ray {
        V origin, direction;
        V pointing;  // of the ray from the eye: as the screen has it, times 1 / length its direction; planes are met without that rounding, so that
        Real length = 0;  // exact ties stay so. 0: another ray
        double originError = 0, directionError = 0;
        double weight = 1;
        uint32_t depth = 1;
        Kind kind = Kind::none;  // what it starts on, its index, and whether it goes on inside of it (a sphere)
        uint32_t index = 0;
        bool inside = false;
    };
    struct Hit {
        Kind kind = Kind::none;
        uint32_t index = 0;
        Real t = 0;
        double error = 0;     // of t
        bool counts = false;  // a hit, by the computed value
        bool sure = true;     // the error bound cannot change that
        bool leaves = false;  // the ray runs with the outward normal
        bool other = false;   // a board's other material
        Real share[3] = {};   // facet: of the corners
        double shareError = 0;
        double low() const { return double(t) - error; }
        double high() const { return double(t) + error; }
    };

    // More than `stake` of a colour hangs on what is open.
    void doubt(double stake) {
        if (kDrawn) {
            open_ += stake;
            doubtful_ = !(open_ <= kDrawnNothing);
            return;
        }
        if (!(stake > kNothing)) {
            open_ += stake;
            return;
        }
        doubtful_ = true;
        undecided_ += kLast;
    }
    bool stops() const { return (doubtful_ && !kLast) || tooMany(); }

    V centreOf(const glm::dvec3& position) const { return V(position) - V(scene_.camera->eye); }

    // Distances are compared where they count and their errors allow it; a hit with t = 0 is none.
    Hit hitSphere(uint32_t i, const Ray& r) const {
        const SphereShape& s = scene_.spheres[i];
        const V c = centreOf(s.centre), f = r.origin - c;
        const double far = sizeOf(f), u = kUnit;
        const double positionError = r.originError + u * (4 * far + 4 * sizeOf(c));
        const Real k = -along(f, r.direction);
        const double kError = positionError + far * (r.directionError + 8 * u);
        Hit h;
        h.kind = Kind::sphere;
        h.index = i;
        if (r.kind == Kind::sphere && r.index == i) {
            if (!r.inside) return h;
            h.t = k + k;
            h.error = 2 * kError;
            h.leaves = true;
            h.counts = k > 0;
            h.sure = std::abs(double(k)) > kError;
            return h;
        }
        const V l = f + r.direction * k;
        const double missError = positionError + 2 * far * (r.directionError + 4 * u) + 4 * u * s.radius, edge = s.radius + missError;
        const Real missSquared = along(l, l);
        if (double(missSquared) > edge * edge * (1 + 16 * u)) return h;  // missed, and the origin is outside
        const Real gap = lengthOf(f) - Real(s.radius), miss = rootOf(missSquared), slack = Real(s.radius) - miss;
        const bool within = gap <= 0, gapOpen = std::abs(double(gap)) <= positionError + 4 * u * s.radius;
        if (!within && !gapOpen && double(k) < -kError) return h;
        const Real square = slack * (Real(s.radius) + miss);
        const Real root = rootOf(square > 0 ? square : Real(0));
        const double most = std::sqrt(2 * (2 * s.radius + missError) * missError), halfChord = double(root);
        h.error = kError + (halfChord > most ? (2 * s.radius + missError) * missError / halfChord : most);
        h.leaves = within;
        h.t = within ? k + root : k - root;
        h.counts = within ? h.t > 0 : k > 0 && slack >= 0;
        h.sure = !gapOpen && (within ? double(h.t) > h.error : double(slack) > missError && double(k) > kError);
        if (gapOpen) h.t = 0, h.counts = within && k + root > 0;
        if (gapOpen && h.counts) h.t = k + root;
        return h;
    }

    Hit hitPlane(uint32_t i, const Ray& r) const {
        const PlaneShape& p = scene_.planes[i];
        Hit h;
        h.kind = Kind::plane;
        h.index = i;
        if (r.kind == Kind::plane && r.index == i) return h;
        const V n(p.normal), point = centreOf(p.point);
        const double u = kUnit;
        const Real slope = along(n, r.direction);
        const double slopeError = r.directionError + 8 * u;
        const Real height = along(n, point - r.origin);
        const double size = sizeOf(point) + sizeOf(r.origin), heightError = r.originError + 8 * u * (size + glm::length(p.point));
        if (std::abs(double(slope)) <= slopeError) {
            // Parallel as far as is known: not met, or no nearer than this.
            const double least = std::max(0.0, std::abs(double(height)) - heightError) / (2 * slopeError);
            h.sure = least > farthest_;
            h.t = Real(2 * least);
            h.error = least;
            return h;
        }
        h.leaves = slope > 0;
        if (!p.twoSided && h.leaves) return h;
        V way;  // to the plane
        if (r.length > 0) {
            const Real steps = height / along(n, r.pointing);
            h.t = steps * r.length;
            way = r.pointing * steps;
        } else {
            h.t = height / slope;
            way = r.direction * h.t;
        }
        h.error = (heightError + std::abs(double(h.t)) * slopeError) / std::abs(double(slope));
        if (double(h.t) < -h.error) return h;
        h.counts = h.t > 0;
        h.sure = double(h.t) > h.error;
        const V q = r.origin + way - point;
        const double qError = r.originError + std::abs(double(h.t)) * r.directionError + h.error + 8 * u * (size + std::abs(double(h.t)));
        const Real a = along(q, V(p.u)), b = along(q, V(p.v));
        const auto bounded = [&](const Real& x, double least, double most) {
            if (double(x) < least - qError || double(x) > most + qError) return false;
            h.sure = h.sure && double(x) > least + qError && double(x) < most - qError;
            h.counts = h.counts && x >= Real(least) && x <= Real(most);
            return true;
        };
        if (!bounded(a, p.uMin, p.uMax) || !bounded(b, p.vMin, p.vMax)) {
            h.counts = false;
            h.sure = true;
            return h;
        }
        if (p.square > 0) h.other = otherSquare(p, a, b, qError, h.sure);
        return h;
    }

    // True where the board has its other material. The square at the origin with u, v >= 0 has the first, and neighbours alternate. `mirrored`: the
    // pattern is mirrored at v = 0, as the notes' is.
    bool otherSquare(const PlaneShape& p, const Real& u, const Real& v, double error, bool& sure) const {
        const bool matters = p.material != p.otherMaterial;
        const auto odd = [&](const Real& x, bool mirrored) {
            const Real size = x < 0 ? -x : x, squares = size / Real(p.square), pairs = floorOf(squares / 2), rest = squares - 2 * pairs;
            const double along = double(rest), near = error / p.square + 4 * kUnit * double(squares);
            const bool atZero = along <= near && pairs == 0;
            if (matters && ((along <= near && !(atZero && mirrored)) || std::abs(along - 1) <= near || 2 - along <= near)) sure = false;
            return rest > 1;
        };
        bool other = u < 0;
        other = other != odd(u, false);
        other = other != odd(v, p.mirrored);
        return other != (v < 0 && !p.mirrored);
    }

    decltype(auto) facetOf(uint32_t i) const {
        if constexpr (std::is_same_v<Real, double>)
            return world_.facet(i);
        else
            return world_.facetIn<Real>(i);
    }
    // Inside where the ray's line has all three corners' edges on one side: volumes d . (b x (c - b)), corners from the ray's origin.
    template <class Number>
    struct Volumes {
        Vec3<Number> first;  // corner, from the origin
        Number of[3];
        double error = 0;  // of each
        double size = 0;   // no corner is farther from the origin
        double edge = 0;   // length of the longest
    };
    template <class Number>
    static Volumes<Number> volumesOf(const Facet<Number>& f, const Vec3<Number>& o, const Vec3<Number>& d, double originError,
                                     double directionError, double unit) {
        const Vec3<Number> a = f.corner[0] - o, b = f.corner[1] - o, c = f.corner[2] - o, ab = f.corner[1] - f.corner[0],
                           bc = f.corner[2] - f.corner[1], ca = f.corner[0] - f.corner[2];
        Volumes<Number> v;
        v.first = a;
        v.of[0] = along(d, across(b, bc));
        v.of[1] = along(d, across(c, ca));
        v.of[2] = along(d, across(a, ab));
        const double edge = std::max({sizeOf(ab), sizeOf(bc), sizeOf(ca)});
        v.edge = edge;
        v.size = sizeOf(a) + edge;
        // d moves b x (c - b) by no more than |b| |c - b|; an origin that moves, moves it by itself times |c - b|; a corner by its error times the distance from
        // the other to the ray's line.
        const double aside = sizeOf(across(a, d)) + edge + v.size * directionError;
        v.error = v.size * edge * (directionError + 16 * unit) + originError * edge +
                  2 * (f.cornerError + 4 * unit * (v.size + sizeOf(o))) * aside;
        return v;
    }
    template <class Number>
    static bool clearlyMissed(const Volumes<Number>& v) {
        const double of[3] = {double(v.of[0]), double(v.of[1]), double(v.of[2])};
        return std::min({of[0], of[1], of[2]}) < -v.error && std::max({of[0], of[1], of[2]}) > v.error;
    }
    Hit hitFacet(uint32_t i, const Ray& r) const {
        Hit h;
        h.kind = Kind::facet;
        h.index = i;
        if (r.kind == Kind::facet && r.index == i) return h;
        if constexpr (!std::is_same_v<Real, double>) {
            // What binary64 finds clearly missed, with the ray rounded to it, need not be made again.
            const Vec3<double> o(rounded(r.origin)), d(rounded(r.direction));
            if (clearlyMissed(volumesOf(world_.facet(i), o, d, r.originError + 0x1p-52 * sizeOf(o), r.directionError + 0x1p-51, 0x1p-53)))
                return h;
        }
        const auto& f = facetOf(i);
        const V& d = r.direction;
        const Volumes<Real> v = volumesOf(f, r.origin, d, r.originError, r.directionError, kUnit);
        if (clearlyMissed(v)) return h;
        bool front = true, back = true, open = false;
        for (const Real& volume : v.of) {
            front &= volume >= 0, back &= volume <= 0;
            open |= std::abs(double(volume)) <= v.error;
        }
        const double u = kUnit;
        const Real slope = along(f.normal, d), height = along(f.normal, v.first);
        const double slopeError = r.directionError + f.normalError + 8 * u;
        const double heightError = r.originError + f.cornerError + 4 * u * sizeOf(r.origin) + v.size * (f.normalError + 8 * u);
        if (std::abs(double(slope)) <= slopeError) {  // seen from its edge
            h.sure = false;
            h.error = kInfinity;
            return h;
        }
        h.t = height / slope;
        h.error = (heightError + std::abs(double(h.t)) * slopeError) / std::abs(double(slope));
        const Real sum = v.of[0] + v.of[1] + v.of[2];
        if (sum != 0) {
            for (int k = 0; k < 3; ++k) h.share[k] = v.of[k] / sum;
            h.shareError = 4 * v.error / std::abs(double(sum));
        }
        // The passes' distance and point are means of the corners', by the shares.
        if (kDrawn) h.error += sum != 0 ? 3 * h.shareError * v.edge + 8 * u * v.size : kInfinity;
        if (double(h.t) < -h.error) return h;
        h.leaves = slope > 0;
        h.counts = (front || back) && h.t > 0;
        h.sure = !open && double(h.t) > h.error;
        return h;
    }

    // Everything is asked; what stays open matters only when it is not clearly behind the nearest.
    Hit nearest(const Ray& r) {
        Hit best;
        best.t = Real(1e300);
        double rival = kInfinity;
        const auto offer = [&](const Hit& h) {
            if (!h.sure) rival = std::min(rival, h.low());
            if (!h.counts) return;
            if (h.t < best.t || (best.kind == Kind::none)) {
                if (best.kind != Kind::none) rival = std::min(rival, best.low());
                best = h;
            } else if (h.sure) {
                rival = std::min(rival, h.low());
            }
        };
        for (uint32_t i = 0; i < scene_.spheres.size(); ++i) offer(hitSphere(i, r));
        for (uint32_t i = 0; i < scene_.planes.size(); ++i) offer(hitPlane(i, r));
        if (world_.facets() != 0) {
            const glm::dvec3 o = rounded(r.origin), d = rounded(r.direction);
            world_.eachNear(
                o, d, padOf(r, o), [&] { return best.kind == Kind::none ? kInfinity : best.high(); },
                [&](uint32_t i) {
                    const Hit h = hitFacet(i, r);
                    // In whatever order the tree brings them, of two equal the lower.
                    if (h.counts && best.kind == Kind::facet && h.t == best.t && i < best.index) {
                        rival = std::min(rival, best.low());
                        best = h;
                    } else {
                        offer(h);
                    }
                });
        }
        if (best.kind != Kind::none && !best.sure) rival = -kInfinity;
        if (rival <= (best.kind == Kind::none ? kInfinity : best.high()) && rival < kInfinity) {
            doubt(r.weight * brightest_);
            primaryOpen_ |= r.depth == 1;
        }
        return best;
    }
    double padOf(const Ray& r, const glm::dvec3& o) const {
        return r.originError + (std::max({std::abs(o.x), std::abs(o.y), std::abs(o.z)}) + world_.reach()) *
                                   (2 * r.directionError + (kDrawn ? 16 * kUnit : 0x1p-46));
    }

    // Where, and which way the surface faces there.
    struct Surface {
        V position, geometric, normal;  // both on the ray's side
        V bends;                        // the normal of mirrored and refracted rays
        double positionError = 0, geometricError = 0, normalError = 0, bendsError = 0;
        uint32_t material = 0;
        double leavingError = 0;  // of the origin of a ray that leaves
        bool within = false;      // the ray runs with the outward normal
    };
    Surface surfaceOf(const Ray& r, const Hit& h) {
        Surface s;
        const double u = kUnit, t = double(h.t);
        s.position = r.origin + r.direction * h.t;
        s.positionError = r.originError + t * r.directionError + h.error + 4 * u * (t + sizeOf(r.origin));
        s.within = h.leaves;
        if (h.kind == Kind::sphere) {
            const SphereShape& ball = scene_.spheres[h.index];
            const V out = s.position - centreOf(ball.centre);
            s.geometric = unitOf(out);
            s.geometricError = (s.positionError + 4 * u * glm::length(ball.centre - scene_.camera->eye)) / ball.radius + 8 * u;
            s.material = ball.material;
        } else if (h.kind == Kind::plane) {
            const PlaneShape& p = scene_.planes[h.index];
            s.geometric = V(p.normal);
            s.geometricError = 0;
            s.material = h.other ? p.otherMaterial : p.material;
        } else {
            const auto& f = facetOf(h.index);
            s.geometric = f.normal;
            s.geometricError = f.normalError;
            s.material = world_.materialOfFacet(h.index);
        }
        s.leavingError = s.positionError;
        if (kDrawn) {
            s.geometricError += kUnitLength;
            s.leavingError += shiftOf(h, s);
        }
        if (s.within) s.geometric = -s.geometric;
        s.normal = s.geometric;
        s.normalError = s.geometricError;
        s.bends = s.geometric;
        s.bendsError = s.geometricError;
        if (h.kind == Kind::facet) smooth(r, h, s);
        return s;
    }
    // No less than the passes move an origin off the surface: twice its error, which is 12 u of radius and coordinates at most (leaveSurface).
    double shiftOf(const Hit& h, const Surface& s) const {
        double size = sizeOf(s.position);
        if (h.kind == Kind::sphere) size += scene_.spheres[h.index].radius;
        if (h.kind == Kind::facet)
            for (const V& corner : facetOf(h.index).corner) size = std::max(size, sizeOf(corner));
        return 4 * 12 * kSingle * size;
    }
    // The interpolated normal, and the one that bends rays (docs/illumination.md).
    void smooth(const Ray& r, const Hit& h, Surface& s) {
        const auto& f = facetOf(h.index);
        V n = f.smooth[0] * h.share[0] + f.smooth[1] * h.share[1] + f.smooth[2] * h.share[2];
        const double length = double(lengthOf(n));
        s.normal = V(glm::dvec3(0));
        if (!(length > 0)) return;
        const double spread = std::max({double(lengthOf(f.smooth[1] - f.smooth[0])), double(lengthOf(f.smooth[2] - f.smooth[0])),
                                        double(lengthOf(f.smooth[2] - f.smooth[1]))});
        n = unitOf(n);
        if (s.within) n = -n;
        const double error = 2 * h.shareError * spread / length + 16 * kUnit / length + (kDrawn ? kUnitLength : 0);
        s.normal = n;
        s.normalError = error;
        bend(r, s);
    }
    // Least slope of a ray that leaves the polygon; its error is at most half of that of d.G.
    static Real slopeOf(const Ray& r, const Surface& s) {
        constexpr double kLeastSlope = 0x1p-10;
        const Real half = along(r.direction, s.geometric) / 2, size = half < 0 ? -half : half;
        return size < Real(kLeastSlope) ? size : Real(kLeastSlope);
    }
    static double slopeErrorOf(const Ray& r, const Surface& s) { return (r.directionError + s.geometricError) / 2 + 8 * kUnit; }

    // The interpolated normal, or one between it and the geometric one that sends the mirrored ray off with the least slope.
    void bend(const Ray& r, Surface& s) {
        constexpr double kLeastLean = 1.0 / 16, kShortestHalf = 0x1p-18;
        const V &g = s.geometric, &n = s.normal, &d = r.direction;
        const RayShares shares = world_.shares(s.material);
        if (shares.reflect == 0 && shares.transmit == 0) return;
        const Real lean = along(n, g), cosine = -along(d, n);
        if (std::abs(double(lean) - kLeastLean) <= s.normalError + s.geometricError + 8 * kUnit) doubt(r.weight * brightest_);
        if (!(lean > kLeastLean)) return;
        const V image = d + n * (2 * (cosine > 0 ? cosine : Real(0)));
        const Real missing = slopeOf(r, s) - along(image, g);
        // Errors of d + 2 c N, and of what it lacks along G.
        const double imageError = 3 * r.directionError + 4 * s.normalError + 8 * kUnit,
                     missingError = imageError + s.geometricError + slopeErrorOf(r, s) + 8 * kUnit;
        if (!(missing > 0)) {
            s.bends = n;
            s.bendsError = s.normalError;
            if (double(missing) < -missingError) return;
        }
        // What lies along the polygon is at least kLeastLean long.
        const V half = missing > 0 ? unitOf(image + g * missing) - d : image - d;
        const Real size = lengthOf(half);  // not rounded to binary64: the bounds of more bits do not count that
        const double length = double(size);
        const double halfError = (imageError + missingError + s.geometricError) / kLeastLean + r.directionError + 8 * kUnit;
        if (std::abs(length - kShortestHalf) <= halfError) doubt(r.weight * brightest_);
        if (!(length > kShortestHalf)) {
            if (std::abs(double(missing)) <= missingError) doubt(r.weight * brightest_);
            return;
        }
        s.bends = half * (1 / size);
        s.bendsError = halfError / length + 8 * kUnit;
    }

    // The share of light `lamp` that reaches the surface.
    double passed(const Ray& shadowRay, double end, double endError, uint32_t lamp, double stake) {
        double share = 1;
        bool open = false;
        const auto meet = [&](const Hit& h, double factor) {
            if (factor == 1 || h.low() > end + endError) return;
            const bool before = double(h.t) < end;
            if (!h.sure || (h.counts && std::abs(double(h.t) - end) <= h.error + endError)) {
                open = true;
                if (!kLast) return;
            }
            if (h.counts && before) share *= factor, ++roundings_;
        };
        for (uint32_t i = 0; i < scene_.spheres.size() && share > 0; ++i) {
            const double factor = double(world_.shares(scene_.spheres[i].material).transmit);
            meet(hitSphere(i, shadowRay), factor);
        }
        for (uint32_t i = 0; i < scene_.planes.size() && share > 0; ++i) {
            if (world_.lightIsAlong(lamp, i)) continue;
            const Hit h = hitPlane(i, shadowRay);
            const PlaneShape& p = scene_.planes[i];
            const double own = double(world_.shares(p.material).transmit),
                         other = p.square > 0 ? double(world_.shares(p.otherMaterial).transmit) : own;
            Hit plain = h;
            if (own == other && p.square > 0 && !h.sure && h.counts) plain = withoutBoard(i, shadowRay);
            meet(plain, plain.other ? other : own);
        }
        if (share > 0 && world_.facets() != 0) {
            const glm::dvec3 o = rounded(shadowRay.origin), d = rounded(shadowRay.direction);
            world_.eachNear(
                o, d, padOf(shadowRay, o), [&] { return share > 0 ? end + endError : -1.0; },
                [&](uint32_t i) {
                    if (share == 0 || world_.lightLiesOn(lamp, i)) return;
                    const double transmit = double(world_.shares(world_.materialOfFacet(i)).transmit);
                    const Hit h = hitFacet(i, shadowRay);
                    if (h.counts || !h.sure) meet(h, transmit == 0 || h.leaves ? transmit : 1);
                });
        }
        if (open && share > 0) doubt(stake);
        return share;
    }
    // Whether a plane is met, where its squares do not matter.
    Hit withoutBoard(uint32_t i, const Ray& r) const {
        Hit h = hitPlane(i, r);
        const PlaneShape& p = scene_.planes[i];
        const V q = r.origin + r.direction * h.t - centreOf(p.point);
        const double error = r.originError + std::abs(double(h.t)) * r.directionError + h.error + 0x1p-40 * (1 + double(lengthOf(q))) +
                             (kDrawn ? 8 * kUnit * (sizeOf(centreOf(p.point)) + sizeOf(r.origin) + std::abs(double(h.t))) : 0);
        const double a = double(along(q, V(p.u))), b = double(along(q, V(p.v)));
        h.sure = double(h.t) > h.error && a > p.uMin + error && a < p.uMax - error && b > p.vMin + error && b < p.vMax - error;
        return h;
    }

    glm::dvec3 localOf(const Ray& r, const Hit& h, const Surface& s, double weight) {
        const Material& m = world_.material(s.material);
        glm::dvec3 colour = glm::dvec3(m.ambient) * glm::dvec3(scene_.ambient) + glm::dvec3(m.emission);
        glm::dvec3 most = colour;  // without shadows
        const glm::dvec3 n = rounded(s.normal), v = -rounded(r.direction);
        for (uint32_t i = 0; i < scene_.lights.size() && !stops(); ++i) {
            const Light& light = scene_.lights[i];
            V l;
            double distance = kInfinity, error = 4 * kUnit, fade = 1;
            if (!light.directional) {
                l = centreOf(light.position) - s.position;
                const Real length = lengthOf(l);
                distance = double(length);
                if (!(distance > 0)) continue;
                l = l * (1 / length);
                error = 2 * (s.positionError + 8 * kUnit * (distance + glm::length(light.position))) / distance + 8 * kUnit;
                if (light.attenuation == Attenuation::inverse) fade = 1 / distance;
                if (light.attenuation == Attenuation::inverseSquare) fade = 1 / (distance * distance);
            } else {
                l = unitOf(V(light.direction));
            }
            const Real cosine = along(s.normal, l), above = along(s.geometric, l);
            const double cosineOpen = s.normalError + error + 8 * kUnit, aboveOpen = s.geometricError + error + 8 * kUnit;
            if (double(cosine) < -cosineOpen || double(above) < -aboveOpen) continue;
            const glm::dvec3 toward = rounded(l);
            const double nl = std::max(0.0, double(cosine)), reflected = glm::dot(2 * nl * n - toward, v);
            Highlight shine;
            if constexpr (kDrawn)
                shine.value = m.shininess == 0 ? 1 : reflected > 0 ? std::pow(reflected, double(m.shininess)) : 0;
            else
                shine = highlightOf(reflected, 2 * (cosineOpen + s.normalError) + error + r.directionError + kMirrorRounding,
                                    double(m.shininess));
            const glm::dvec3 added =
                fade * glm::dvec3(light.intensity) * (glm::dvec3(m.diffuse) * nl + glm::dvec3(m.specular) * shine.value);
            const double stake = weight * largest(added);
            if (double(cosine) <= cosineOpen || double(above) <= aboveOpen) doubt(stake);
            if constexpr (kDrawn) {
                most += added;
                boundLight(r, s, m, light, fade, error, added, weight);
            } else {
                const int power = light.directional ? 0 : int(light.attenuation);
                const LightPart part{double(cosine), cosineOpen + 2 * kDoubleUnit, shine, fade,
                                     power == 0    ? 0
                                     : error < 0.5 ? power * (error + 8 * kDoubleUnit)
                                                   : kInfinity};
                BoundedColour own;
                addPart(part, m.diffuse, m.specular, light.intensity, own);
                bound_ += weight * own.error;
                roundings_ += 8;
            }
            if (!(cosine > 0 && above > 0)) continue;
            if (!(largest(added) > 0)) continue;
            double share = 1;
            if (scene_.shadows) {
                Ray shadowRay;
                shadowRay.origin = s.position;
                shadowRay.originError = s.leavingError;
                shadowRay.direction = l;
                shadowRay.directionError = error;
                shadowRay.kind = h.kind;
                shadowRay.index = h.index;
                shadowRay.inside = s.within;
                share = passed(shadowRay, distance,
                               light.directional ? 0 : s.positionError + 8 * kUnit * (distance + glm::length(light.position)), i, stake);
            }
            colour += share * added;
        }
        if (kDrawn) bound_ += weight * most * ((2 + double(scene_.lights.size())) * kUnit);
        return colour;
    }
    // What the errors of normal, light and eye make of one light's part.
    void boundLight(const Ray& r, const Surface& s, const Material& m, const Light& light, double fade, double lightError,
                    const glm::dvec3& added, double weight) {
        const double towardError = lightError + kUnitLength, viewError = r.directionError + kUnitLength;
        const double diffuseError = s.normalError + towardError + kUnit;
        const double mirrorError = 2 * (s.normalError + diffuseError) + towardError + viewError + kUnit;
        const double n = m.shininess;
        const double shineError = n == 0 ? 0 : std::min(1.0, highlightError(n, mirrorError, kPowerFloor) + kPowerError);
        const double fadeError = (light.directional ? 0 : int(light.attenuation)) * towardError + kUnit;
        if (mirrorError > kDrawnVague) doubt(weight * largest(added + glm::dvec3(light.intensity) * fade));
        bound_ +=
            weight * (fade * glm::dvec3(light.intensity) * (glm::dvec3(m.diffuse) * diffuseError + glm::dvec3(m.specular) * shineError) +
                      fadeError * added);
    }

    void follow(const Ray& r) {
        ++rays_;
        roundings_ += r.depth + 8;
        const Hit h = nearest(r);
        if (stops()) return;
        if (h.kind == Kind::none) {
            seen_.colour += r.weight * sky_;
            if (kDrawn) bound_ += r.weight * sky_ * (r.depth * kUnit);
            return;
        }
        const Surface s = surfaceOf(r, h);
        if (stops()) return;
        if (r.depth == 1) note(h);
        const RayShares shares = world_.shares(s.material);
        if (shares.local > 0) {
            const glm::dvec3 own = r.weight * double(shares.local) * localOf(r, h, s, r.weight * double(shares.local));
            seen_.colour += own;
            if (kDrawn) bound_ += own * (r.depth * kUnit);
        }
        if (stops()) return;
        sendOn(r, h, s, shares);
    }

    void note(const Hit& h) {
        seen_.distance = double(h.t);
        distanceError_ = h.error + 4 * kUnit * double(h.t);
        seen_.primitive = 0;
        if (h.kind == Kind::sphere) seen_.object = uint32_t(scene_.objects.size()) + h.index;
        if (h.kind == Kind::plane) seen_.object = uint32_t(scene_.objects.size() + scene_.spheres.size()) + h.index;
        if (h.kind != Kind::facet) return;
        const RayWorld::Owner& owner = world_.ownerOf(h.index);
        seen_.object = owner.object;
        seen_.primitive = scene_.meshes[scene_.objects[owner.object].mesh].triangles[owner.triangle].face;
    }

    void sendOn(const Ray& r, const Hit& h, const Surface& s, const RayShares& shares) {
        if (shares.reflect == 0 && shares.transmit == 0) return;
        const double index = double(world_.material(s.material).refractiveIndex), u = kUnit;
        const Real cosine = -along(r.direction, s.bends);
        const double cosineError = r.directionError + s.bendsError + 8 * u;
        const Real ratio = s.within ? Real(index) : 1 / Real(index);
        const double bend = double(ratio);
        const Real square = index == 1 ? cosine * cosine : 1 - ratio * ratio * (1 - cosine * cosine);
        bool total = false;
        if (shares.transmit > 0 && (index != 1 || kDrawn)) {
            const double open =
                bend * bend * (2 * std::abs(double(cosine)) * cosineError + cosineError * cosineError) + 8 * u * (1 + bend * bend);
            if (std::abs(double(square)) <= open) doubt(r.weight * double(shares.transmit) * brightest_);
            total = square <= 0;
        }
        Ray child;
        child.origin = s.position;
        child.originError = s.leavingError;
        child.depth = r.depth + 1;
        child.kind = h.kind;
        child.index = h.index;

        child.weight = r.weight * (double(shares.reflect) + (total ? double(shares.transmit) : 0.0));
        child.inside = s.within;
        child.direction = unitOf(r.direction + s.bends * (2 * cosine));
        child.directionError = r.directionError + 4 * s.bendsError + 12 * u;
        send(child);
        if (total || shares.transmit == 0 || stops()) return;
        child.weight = r.weight * double(shares.transmit);
        child.inside = !s.within;
        if (index == 1) {
            child.direction = r.direction;
            child.directionError = r.directionError;
            // The passes refract it, too: their radicand is the cosine squared, rounded.
            if (kDrawn) child.directionError += 12 * u + std::min(2 * u / std::max(double(cosine), u), std::sqrt(2 * u));
        } else {
            const Real root = rootOf(square);
            const double steep =
                double(root) > 0 ? (bend * bend * std::abs(double(cosine)) * cosineError + 4 * u * (1 + bend * bend)) / double(root) : 1;
            child.direction = unitOf(r.direction * ratio + s.bends * (ratio * cosine - root));
            child.directionError = bend * r.directionError + (bend + 1) * s.bendsError + bend * cosineError + steep + 16 * u * (1 + bend);
            if (h.kind == Kind::facet) leave(r, s, child);
        }
        send(child);
    }
    // A refracted ray leaves the polygon with the least slope at least.
    void leave(const Ray& r, const Surface& s, Ray& child) {
        const Real missing = slopeOf(r, s) + along(child.direction, s.geometric);
        const double missingError = child.directionError + s.geometricError + slopeErrorOf(r, s) + 8 * kUnit;
        if (double(missing) < -missingError) return;
        V kept = child.direction;
        if (missing > 0) kept = kept - s.geometric * missing;
        const double length = double(lengthOf(kept));
        child.direction = unitOf(kept);
        child.directionError = (child.directionError + missingError + s.geometricError) / length + 8 * kUnit;
    }
    void send(const Ray& child) {
        if (child.weight == 0) return;
        if (kDrawn && child.depth <= limits_.maxDepth && std::abs(child.weight - leastWeight_) <= child.depth * kUnit * leastWeight_)
            doubt(child.weight * brightest_);
        if (child.depth > limits_.maxDepth || child.weight < leastWeight_) {
            seen_.leftOut += child.weight;
            return;
        }
        if (kDrawn ? child.directionError > kDrawnVague
                   : child.directionError > kVagueDirection || child.directionError * child.weight * brightest_ > kVagueColour)
            doubt(child.weight * brightest_);
        if (stops()) return;
        if (!kDrawn && child.directionError > kVagueDirection) {  // counted; from here on the ray is taken as it is
            Ray known = child;
            known.originError = known.directionError = kUnit;
            follow(known);
        } else {
            follow(child);
        }
    }

    const RayWorld& world_;
    const Scene& scene_;
    const glm::dvec3& sky_;
    const RayLimits& limits_;
    const double brightest_;
    const double farthest_;  // what lies further is not hit (docs/scene-format.md)
    const double leastWeight_;
    RaySeen seen_;
    uint32_t rays_ = 0;
    bool doubtful_ = false;
    uint64_t undecided_ = 0;
    uint64_t roundings_ = 0;  // of weights, shares and colours
    // Error of the colour, and what hangs on decisions that are open and are not made again.
    glm::dvec3 bound_{0};
    double open_ = 0, distanceError_ = 0;
    bool primaryOpen_ = false;
};

}  // namespace

RayTruth::RayTruth(const RayWorld& world, const Pinhole& pinhole, const glm::dvec3& sky, const RayLimits& limits)
    : world_(world),
      pinhole_(pinhole),
      sky_(sky),
      limits_(limits),
      brightest_(world.brightness(sky).most),
      boundedBy_(world.brightness(sky).holds ? brightest_ : kInfinity),
      farthest_(std::ldexp(pinhole.near, 60)) {}

RaySeen RayTruth::look(double x, double y) {
    for (double least = limits_.leastWeight;; least *= kCoarserCut) {
        Tracer<Computed<double>> fast(world_, sky_, limits_, brightest_, farthest_, least);
        fast.look(pinhole_, x, y);
        if (fast.tooMany()) continue;
        if (!fast.doubtful()) return fast.judged(boundedBy_);
        ++redone_;
        Tracer<Computed<long double>> middle(world_, sky_, limits_, brightest_, farthest_, least);
        middle.look(pinhole_, x, y);
        if (middle.tooMany()) continue;
        if (!middle.doubtful()) return middle.judged(boundedBy_);
        Tracer<Computed<Quad>> slow(world_, sky_, limits_, brightest_, farthest_, least);
        slow.look(pinhole_, x, y);
        if (slow.tooMany()) continue;
        undecided_ += slow.undecided();
        return slow.judged(boundedBy_);
    }
}

RayDrawn RayTruth::lookDrawn(double x, double y) {
    Tracer<AsDrawn> tracer(world_, sky_, limits_, brightest_, farthest_, limits_.leastWeight);
    tracer.look(pinhole_, x, y);
    RayDrawn out;
    out.seen = tracer.seen();
    out.decided = !tracer.doubtful() && !tracer.primaryIsOpen() && !tracer.tooMany();
    out.bound = tracer.bound() + out.seen.colour * (tracer.rays() * kSingle) + kDrawnNothing;
    out.distanceError = tracer.distanceError();
    return out;
}

}  // namespace plumb::truth
