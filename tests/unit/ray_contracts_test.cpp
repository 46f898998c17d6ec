// SPDX-License-Identifier: MIT
// Every decision of the contracts of rays, asked directly; the notes' worked numbers where they have some.
#include "shaders/shared/trace.h"
#include "tests/support/scenes.h"

#include <gtest/gtest.h>
#include <cmath>
#include <glm/glm.hpp>

namespace plumb::gpu {
namespace {

constexpr double kUlp = 0x1p-24;
const vec3 kZ(0, 0, 1), kYAxis(0, 1, 0);

SphereHit ask(vec3 o, vec3 d, vec3 c, float r, uint start = kStartElsewhere) { return hitSphere(o, d, c, r, 0, start, false, false); }

TEST(StartOn, KnowsTheObjectAndTheSide) {
    EXPECT_EQ(startOn(3, 4, true), kStartElsewhere);
    EXPECT_EQ(startOn(3, 3, true), kStartInside);
    EXPECT_EQ(startOn(3, 3, false), kStartOutside);
}

TEST(IsNearer, PrefersTheNearerThenTheLowerObject) {
    EXPECT_TRUE(isNearer(1, 7, 2, 3));
    EXPECT_FALSE(isNearer(2, 3, 1, 7));
    EXPECT_TRUE(isNearer(1, 2, 1, 3));
    EXPECT_FALSE(isNearer(1, 3, 1, 2));
    EXPECT_FALSE(isNearer(0, 3, 1, 7));
    EXPECT_FALSE(isNearer(-1, 3, 1, 7));
}

// Notes 18.2.1: (0,0,0) through (5,4,12), centre (5,4,10), radius 2: t = 137/185 of the way.
TEST(HitSphere, FindsTheWorkedExample) {
    const double length = std::sqrt(185.0);
    const SphereHit hit = ask(vec3(0), unitLength({5, 4, 12}), {5, 4, 10}, 2);
    EXPECT_NEAR(hit.t, 137.0 / 185 * length, 32 * kUlp * length);
    EXPECT_NEAR(hit.offset.x, 137.0 / 37 - 5, 32 * kUlp * length);
    EXPECT_NEAR(hit.offset.y, 548.0 / 185 - 4, 32 * kUlp * length);
    EXPECT_NEAR(hit.offset.z, 1644.0 / 185 - 10, 32 * kUlp * length);
}

TEST(HitSphere, HasTheCasesOfTheNotes) {
    EXPECT_EQ(ask(vec3(0), kZ, {3, 0, 10}, 2).t, 0.0f);     // miss
    EXPECT_EQ(ask(vec3(0), kZ, {2, 0, 10}, 2).t, 10.0f);    // graze: one root
    EXPECT_EQ(ask({0, 0, 20}, kZ, {0, 0, 10}, 2).t, 0.0f);  // behind: both roots negative
    const SphereHit inside = ask({0, 0, 10}, kZ, {0, 0, 10}, 2);
    EXPECT_EQ(inside.t, 2.0f);  // roots -2 and 2
    EXPECT_EQ(inside.offset, vec3(0, 0, 2));
    const SphereHit front = ask(vec3(0), kZ, {0, 0, 10}, 2);
    EXPECT_EQ(front.t, 8.0f);
    EXPECT_EQ(front.offset, vec3(0, 0, -2));
}

TEST(HitSphere, InsideItLeavesAheadOrBehindTheCentre) {
    EXPECT_EQ(ask({0, 0, 9}, kZ, {0, 0, 10}, 2).t, 3.0f);
    EXPECT_EQ(ask({0, 0, 11}, kZ, {0, 0, 10}, 2).t, 1.0f);
}

TEST(HitSphere, OnItWithoutKnowingIsInside) {
    EXPECT_EQ(ask({0, 0, 8}, kZ, {0, 0, 10}, 2).t, 4.0f);
    EXPECT_EQ(ask({0, 0, 12}, kZ, {0, 0, 10}, 2).t, 0.0f);
}

// A short chord from the sphere itself: h^2 = k^2 + (r^2 - f.f) has k's own precision, r^2 - l.l only that of r^2.
TEST(HitSphere, ShortChordsKeepTheirPrecision) {
    const float slope = 1e-4f;
    const double chord = 2 * 2.0 * slope;  // 2 |f.d| for f = (2, 0, 0); d is of unit length to 1e-8
    EXPECT_NEAR(ask({2, 0, 10}, vec3(-slope, 0, 1), {0, 0, 10}, 2).t, chord, 8 * kUlp * chord);
}

TEST(HitSphere, ItsOwnIsMetFromInsideAtTheFarSideOnly) {
    const vec3 nearly(0, 0, 8.000001f);
    EXPECT_EQ(ask(nearly, kZ, {0, 0, 10}, 2, kStartOutside).t, 0.0f);
    EXPECT_EQ(ask({0, 0, 7.999999f}, kZ, {0, 0, 10}, 2, kStartOutside).t, 0.0f);
    const SphereHit across = ask({0, 0, 8}, kZ, {0, 0, 10}, 2, kStartInside);
    EXPECT_EQ(across.t, 4.0f);
    EXPECT_EQ(across.offset, vec3(0, 0, 2));
    EXPECT_EQ(ask({0, 0, 12}, kZ, {0, 0, 10}, 2, kStartInside).t, 0.0f);
    // Just outside by rounding, on its way in: still the far side.
    const SphereHit outside = ask({0, 0, 7.999999f}, kZ, {0, 0, 10}, 2, kStartInside);
    EXPECT_NEAR(outside.t, 4, 4 * 8 * kUlp);
    EXPECT_GT(outside.offset.z, 0.0f);
}

TEST(HitSphere, NothingIsHitBeyondTheFarLimit) {
    EXPECT_EQ(ask(vec3(0), kZ, {0, 0, 1.25f * kFarthestHit}, 1).t, 0.0f);
    EXPECT_GT(ask(vec3(0), kZ, {0, 0, 0.5f * kFarthestHit}, 1).t, 0.0f);
}

// A sphere a million radii away: offsets from the centre keep the precision of the radius.
TEST(HitSphere, FarSpheresKeepTheirShape) {
    const vec3 d = unitLength({0.3f, -0.2f, 1});
    const double dd[3] = {d.x, d.y, d.z};
    const float distance = 1e6f;
    const vec3 c = d * distance + vec3(0.8f, 0.3f, -0.05f);
    // In binary64: the point nearest to the centre.
    const double k = (c.x * dd[0] + c.y * dd[1] + c.z * dd[2]) / (dd[0] * dd[0] + dd[1] * dd[1] + dd[2] * dd[2]);
    double l[3], ll = 0;
    for (int i = 0; i < 3; ++i) l[i] = k * dd[i] - double(c[i]), ll += l[i] * l[i];
    ASSERT_LT(ll, 1);
    const double h = std::sqrt(1 - ll);
    const SphereHit hit = hitSphere(vec3(0), d, c, 1, 0, kStartElsewhere, true, false);
    // Error of l: a few roundings of values of its own size; of h: that of l times l / h.
    const double bound = 32 * kUlp * (1 + 1 / h);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(hit.offset[i], l[i] - h * dd[i], bound);
    EXPECT_GT(glm::length(hit.offset - hitSphere(vec3(0), d, c, 1, 0, kStartElsewhere, false, false).offset), 1e3f * float(bound))
        << "the plain form is as good";
}

TEST(PointOnLine, ItsErrorTermsAreNeverSubnormal) {
    EXPECT_EQ(productError(0x1.000002p-31f, 0x1.000002p-31f, 0x1.000002p-31f * 0x1.000002p-31f), 0.0f);
    EXPECT_EQ(productError(0x1.000002p-20f, 0x1.000002p-20f, 0x1.000002p-20f * 0x1.000002p-20f), 0x1p-86f);
}

// A sphere of 2^30 under an eye 2 above it: |c| and r are the same float, and only the power of the eye knows the gap.
constexpr float kHuge = 0x1p30f;
const vec3 kBelow(0, -kHuge, 0);
constexpr float kPower = 4 * kHuge;  // (|c| - r)(|c| + r) = 2 * 2^31; 4 more is beyond float32
SphereHit askClose(vec3 o, vec3 d, float power, uint start = kStartElsewhere, bool close = true) {
    return hitSphere(o, d, kBelow, kHuge, power, start, false, close);
}

TEST(PowerAt, IsTheSquareOfTheDistanceWithoutThatOfTheRadius) {
    EXPECT_EQ(powerAt(vec3(0), kBelow, kPower), kPower);
    EXPECT_EQ(powerAt({0, -2, 0}, kBelow, kPower), 0.0f);
    EXPECT_EQ(powerAt({0, 1, 0}, kBelow, kPower), kPower + 2 * kHuge);
    EXPECT_EQ(powerAt({1, 0, 0}, {3, 0, 0}, 5), 0.0f);  // r = 2
}

TEST(StartsClose, WhereEyeAndOriginAreWithinTwoRadii) {
    EXPECT_TRUE(startsClose(vec3(0), {0, 0, 3.9f}, 2));
    EXPECT_FALSE(startsClose({0, 0, 1}, {0, 0, 4.1f}, 2)) << "the eye is further off";
    EXPECT_FALSE(startsClose({0, 0, -1}, {0, 0, 3.9f}, 2)) << "the origin is further off";
    EXPECT_TRUE(startsClose({0, 0, 7}, {0, 0, 3.9f}, 2));
}

TEST(HitSphere, AGapFarBelowItsRadiusIsSeen) {
    EXPECT_EQ(askClose(vec3(0), -kYAxis, kPower).t, 2.0f);
    EXPECT_EQ(askClose(vec3(0), kYAxis, kPower).t, 0.0f);
    EXPECT_EQ(askClose(vec3(0), -kYAxis, kPower, kStartElsewhere, false).t, 2 * kHuge) << "the plain form knows the gap too";
    // From inside, just as near: up to the near side, down to the far one.
    EXPECT_EQ(askClose(vec3(0), kYAxis, -kPower).t, 2.0f);
    EXPECT_EQ(askClose(vec3(0), -kYAxis, -kPower).t, 2 * kHuge);
    // From elsewhere: 3 above the eye, 5 above the sphere.
    EXPECT_EQ(askClose({0, 3, 0}, -kYAxis, kPower).t, 5.0f);
}

// A quarter of a dip of the horizon below it: k^2 and the power are 2^-28 of r^2, which r^2 - l.l cannot hold.
TEST(HitSphere, TheHorizonOfAHugeSphereIsSeen) {
    const double dip = std::sqrt(2.0 * 2 / double(kHuge));
    for (const double steep : {1.25, 0.75}) {
        const vec3 d(1, float(-dip * steep), 0);  // unit to 2^-28
        const double k = dip * steep, h = steep < 1 ? 0 : std::sqrt(k * k - dip * dip);
        const double way = steep < 1 ? 0 : 4 / (k + h);
        // d.y is known to u of itself, k^2 - dip^2 to 4 u of k^2, which over h is 8 u; the last quotient adds what is left.
        EXPECT_NEAR(askClose(vec3(0), d, kPower).t, way, 16 * kUlp * way) << steep;
    }
}

// A ray's own sphere, from an origin moved in by s: to the far side it is 2 k and what the step took off, s / cosine.
TEST(HitSphere, AnOriginMovedInIsThatMuchFurtherFromTheFarSide) {
    const vec3 d = unitLength({1, -0.25f, 0});
    const float moved = 1024;  // 2^-20 of the radius
    const SphereHit across = askClose({0, -2 - moved, 0}, d, kPower, kStartInside);
    const double k = (double(kHuge) - moved) * -double(d.y), h = std::sqrt(k * k + 2.0 * moved * double(kHuge) - double(moved) * moved);
    EXPECT_NEAR(across.t, k + h, 16 * kUlp * (k + h));
    EXPECT_GT(k + h - 2 * k, 64 * kUlp * (k + h)) << "2 k is as good";
    EXPECT_NEAR(double(glm::length(glm::dvec3(across.offset))), double(kHuge), 16 * kUlp * double(kHuge));
    EXPECT_NEAR(askClose({0, -2 - moved, 0}, d, kPower, kStartInside, false).t, 2 * k, 16 * kUlp * k)
        << "the plain form may not use its own h";
    // Just outside by rounding: 2 k, as ever.
    EXPECT_EQ(askClose({0, moved - 2, 0}, -kYAxis, kPower, kStartInside).t, 2 * (kHuge + moved));
}

TEST(PointOnCloseSphere, IsAsNearToItAsToTheEye) {
    const vec3 d = unitLength({1, -1, 0.5f});
    const SphereHit hit = askClose(vec3(0), d, kPower);
    const SurfacePoint s = pointOnCloseSphere(vec3(0), d, hit.t, kBelow, kHuge, kPower, hit.offset);
    EXPECT_NEAR(s.point.y, -2, 16 * kUlp * 2);
    EXPECT_NEAR(s.point.x, 2, 16 * kUlp * 2);
    EXPECT_LT(dot3(magnitudes(s.normal), s.error), 64 * kUlp * 3);
    EXPECT_GT(pointOnSphere(kBelow, kHuge, hit.offset).error.x, 256.0f) << "the plain form is as good";
    // A place that is off is stepped back along the normal, and the step is counted as lost by 2^-17 of it.
    const SurfacePoint off = pointOnCloseSphere(vec3(0), d, hit.t * 1.25f, kBelow, kHuge, kPower, hit.offset);
    EXPECT_NEAR(off.point.y, -2, 16 * kUlp * 4);
    EXPECT_GT(off.error.y, 0.25f * 2 * 0x1p-17f);
    // From three radii away the place along the ray is no better than c + r n, and that is where the way ends.
    const vec3 o(0, 3 * kHuge, 0);
    const SurfacePoint far = pointOnCloseSphere(o, -kYAxis, 1.0f, kBelow, kHuge, kPower, {0, kHuge, 0});
    EXPECT_NEAR(far.point.y, -2, far.error.y);
    EXPECT_LT(far.error.y, 12 * 0x1p-24f * kHuge * 0x1p-17f);  // of c + r n, known to 12 u r
}

struct Slab {
    vec4 plane{0, 0, 1, 10}, u{1, 0, 0, 0}, v{0, 1, 0, 0}, bounds{-100, 100, -100, 100};
    bool twoSided = true;
    uint start = kStartElsewhere;
    PlaneHit from(vec3 o, vec3 d) const { return hitPlane(o, d, plane, u, v, bounds, twoSided, start); }
};

// Notes 18.2.2: (0,0,-10) through (10,5,12), plane z = 10: (100/11, 50/11, 10).
TEST(HitPlane, FindsTheWorkedExample) {
    const vec3 d = unitLength({10, 5, 22});
    const PlaneHit hit = Slab().from({0, 0, -10}, d);
    EXPECT_NEAR(hit.point.x, 100.0 / 11, 32 * kUlp * 10);
    EXPECT_NEAR(hit.point.y, 50.0 / 11, 32 * kUlp * 10);
    EXPECT_NEAR(hit.point.z, 10, 2 * kUlp * 10);
    EXPECT_NEAR(hit.t, 10.0 / 11 * std::sqrt(609.0), 32 * kUlp * 25);
    EXPECT_EQ(hit.undecided, 0u);
}

TEST(HitPlane, ParallelOrBehindOrOwnIsNoHit) {
    const vec3 along = unitLength({1, 2, 0});
    EXPECT_EQ(Slab().from({0, 0, -10}, along).t, 0.0f);
    EXPECT_EQ(Slab().from({0, 0, -10}, along).undecided, 1u);
    EXPECT_EQ(Slab().from({0, 0, 20}, kZ).t, 0.0f);
    Slab own;
    own.start = kStartOutside;
    EXPECT_EQ(own.from({0, 0, 9}, kZ).t, 0.0f);
    EXPECT_EQ(own.from({0, 0, 9}, along).undecided, 0u);
    // n.d = 2^-26 of products that cancel: within their rounding.
    Slab slanted;
    slanted.plane = {0.70710677f, 0.70710677f, 0, 10};
    EXPECT_EQ(slanted.from(vec3(0), {0.70710677f, -0.70710671f, 0}).undecided, 1u);
    EXPECT_EQ(slanted.from(vec3(0), {0.70710677f, -0.70710671f, 0}).t, 0.0f);
}

TEST(HitPlane, OneSidedLetsRaysPassFromBehind) {
    Slab s;
    s.twoSided = false;
    EXPECT_EQ(s.from({0, 0, 0}, kZ).t, 0.0f);
    EXPECT_EQ(s.from({0, 0, 20}, -kZ).t, 10.0f);
    s.twoSided = true;
    EXPECT_EQ(s.from({0, 0, 0}, kZ).t, 10.0f);
}

TEST(HitPlane, NothingIsHitBeyondTheFarLimit) {
    Slab s;
    s.plane.w = 2 * kFarthestHit;
    s.bounds = {-2 * kFarthestHit, 2 * kFarthestHit, -2 * kFarthestHit, 2 * kFarthestHit};
    EXPECT_EQ(s.from(vec3(0), kZ).t, 0.0f);
    s.plane.w = 0.5f * kFarthestHit;
    EXPECT_GT(s.from(vec3(0), kZ).t, 0.0f);
}

TEST(HitPlane, BoundsAreInclusive) {
    Slab s;
    s.bounds = {-1, 2, -3, 4};
    for (const vec3 in : {vec3(-1, 0, 0), vec3(2, 0, 0), vec3(0, -3, 0), vec3(0, 4, 0)}) EXPECT_EQ(s.from(in, kZ).t, 10.0f);
    for (const vec3 out : {vec3(-1.001f, 0, 0), vec3(2.001f, 0, 0), vec3(0, -3.001f, 0), vec3(0, 4.001f, 0)})
        EXPECT_EQ(s.from(out, kZ).t, 0.0f);
}

// Notes 18.3 with squares of 100: red is the first material. The notes' board is mirrored at Z = 0.
TEST(OtherSquare, IsTheNotesBoard) {
    const struct {
        float x, z;
        bool white;
    } points[] = {{275, 450, false},  {-320, 380, true},  {0, 0, false},       {100, 0, false},  {100.5f, 0, true},   {200, 0, false},
                  {200.5f, 0, false}, {300, 0, false},    {-1, 0, true},       {-100, 0, true},  {-100.5f, 0, false}, {-200, 0, true},
                  {50, 100, false},   {50, 150, true},    {50, 200, false},    {50, -50, false}, {-50, -50, true},    {-150, -150, true},
                  {1e-9f, 50, false}, {-1e-9f, 50, true}, {399.999f, 50, true}};
    for (const auto& p : points) EXPECT_EQ(otherSquare(p.x, p.z, 100, 1), p.white) << p.x << ", " << p.z;
    EXPECT_TRUE(otherSquare(50, -50, 100, 0));
    EXPECT_FALSE(otherSquare(50, 50, 100, 0));
    EXPECT_FALSE(otherSquare(50, 0, 100, 0));
}

Children childrenAt(vec3 d, bool inside, float mirror, float pass, uint depth = 1, float least = 0) {
    return childrenOf(unitLength(d), {0, 1, 0}, inside, mirror, pass, 2.0f, 0.5f, 0.5f, depth, 5, least);
}

// Notes 18.2.3 and 18.2.4 with unit T: R = (sqrt 1/2, sqrt 1/2, 0), Trans = (sqrt 2 / 4, -sqrt 14 / 4, 0).
TEST(Children, HaveTheDirectionsOfTheNotes) {
    const Children c = childrenAt({0.7f, -0.7f, 0}, false, 0.25f, 0.5f);
    EXPECT_TRUE(c.mirror);
    EXPECT_TRUE(c.pass);
    EXPECT_NEAR(c.mirrorDirection.x, std::sqrt(0.5), 32 * kUlp);
    EXPECT_NEAR(c.mirrorDirection.y, std::sqrt(0.5), 32 * kUlp);
    EXPECT_NEAR(c.passDirection.x, std::sqrt(2.0) / 4, 32 * kUlp);
    EXPECT_NEAR(c.passDirection.y, -std::sqrt(14.0) / 4, 32 * kUlp);
    EXPECT_EQ(c.mirrorWeight, 0.125f);
    EXPECT_EQ(c.passWeight, 0.25f);
}

// Leaving index 2 at 45 degrees: total reflection takes both weights; near the normal the ray bends away by sin ratio 2.
TEST(Children, TotalReflectionTakesTheTransmittedWeight) {
    const Children total = childrenAt({0.7f, -0.7f, 0}, true, 0.25f, 0.5f);
    EXPECT_TRUE(total.mirror);
    EXPECT_FALSE(total.pass);
    EXPECT_EQ(total.mirrorWeight, 0.375f);
    EXPECT_EQ(total.passWeight, 0.0f);
    const Children leaving = childrenAt({0.25f, -std::sqrt(0.9375f), 0}, true, 0.25f, 0.5f);
    EXPECT_TRUE(leaving.pass);
    EXPECT_NEAR(leaving.passDirection.x, 0.5, 64 * kUlp);
    // Exactly critical: sin = 1/2, ratio 2.
    EXPECT_FALSE(childrenOf({0.6f, -0.8f, 0}, {0, 1, 0}, true, 0, 1, 2.0f, 0.5f, 1, 1, 5, 0).pass);
}

TEST(Children, AreFollowedWhileTheyAreNeitherTooDeepNorTooLight) {
    EXPECT_TRUE(childrenAt({1, -1, 0}, false, 0.25f, 0.5f, 4).mirror);
    EXPECT_TRUE(childrenAt({1, -1, 0}, false, 0.25f, 0.5f, 4).pass);
    EXPECT_FALSE(childrenAt({1, -1, 0}, false, 0.25f, 0.5f, 5).mirror);
    EXPECT_FALSE(childrenAt({1, -1, 0}, false, 0.25f, 0.5f, 5).pass);
    EXPECT_FALSE(childrenAt({1, -1, 0}, false, 0, 0.5f).mirror);
    EXPECT_FALSE(childrenAt({1, -1, 0}, false, 0.5f, 0).pass);
    // Weights are 0.125 and 0.25: as much as the least is enough.
    EXPECT_TRUE(childrenAt({1, -1, 0}, false, 0.25f, 0.5f, 1, 0.125f).mirror);
    EXPECT_FALSE(childrenAt({1, -1, 0}, false, 0.25f, 0.5f, 1, 0.126f).mirror);
    EXPECT_TRUE(childrenAt({1, -1, 0}, false, 0.25f, 0.5f, 1, 0.25f).pass);
    EXPECT_FALSE(childrenAt({1, -1, 0}, false, 0.25f, 0.5f, 1, 0.251f).pass);
}

TEST(ShadowRay, ReachesAPointLightAndNoFurther) {
    const ShadowRay sun = shadowRayTo({0, 1, 0, 0}, {5, 5, 5});
    EXPECT_EQ(sun.direction, vec3(0, 1, 0));
    EXPECT_EQ(sun.reach, kFarthestHit);
    const ShadowRay lamp = shadowRayTo({5, 9, 5, 1}, {5, 5, 5});
    EXPECT_NEAR(lamp.direction.y, 1, 16 * kUlp);
    EXPECT_LT(lamp.reach, 4.0f);
    EXPECT_GT(lamp.reach, 4 * (1 - 40 * kUlp));
    EXPECT_TRUE(blocks(1, 4));
    EXPECT_FALSE(blocks(4, 4));
    EXPECT_FALSE(blocks(0, 4));
    EXPECT_FALSE(blocks(5, 4));
}

TEST(Chosen, IsTheOneOrTheOther) {
    EXPECT_EQ(chosen(true, {1, 2, 3}, {4, 5, 6}), vec3(1, 2, 3));
    EXPECT_EQ(chosen(false, {1, 2, 3}, {4, 5, 6}), vec3(4, 5, 6));
}

TEST(RayFrame, TurnsTheLargestAxisLast) {
    EXPECT_EQ(turned({1, 2, 3}, 0), vec3(2, 3, 1));
    EXPECT_EQ(turned({1, 2, 3}, 1), vec3(3, 1, 2));
    EXPECT_EQ(turned({1, 2, 3}, 2), vec3(1, 2, 3));
    EXPECT_EQ(frameOfRay(vec3(0), {-3, 2, 1}, 1).axis, 0u);
    EXPECT_EQ(frameOfRay(vec3(0), {2, -3, 1}, 1).axis, 1u);
    EXPECT_EQ(frameOfRay(vec3(0), {2, 1, -3}, 1).axis, 2u);
    EXPECT_EQ(frameOfRay(vec3(0), {1, 3, 2}, 1).axis, 1u);
    EXPECT_EQ(frameOfRay(vec3(0), {3, 1, 2}, 1).axis, 0u);
    EXPECT_EQ(safeInverse(0), 0x1p60f);
    EXPECT_EQ(safeInverse(-1e-30f), -0x1p60f);
    EXPECT_EQ(safeInverse(4), 0.25f);
}

// Each slab decides once: entered or left by the axis whose planes come last or first.
TEST(Boxes, AreEnteredLastAndLeftFirst) {
    const vec3 low(-1, -2, -3), high(1, 2, 3);
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            vec3 o(0), d(0.01f);
            o[axis] = -10 * side;
            d[axis] = side;
            const RayFrame f = frameOfRay(o, d, 3);
            EXPECT_NEAR(entryOfBox(f, low, high), 10 - high[axis], 1e-3);
            EXPECT_NEAR(exitOfBox(f, low, high), 10 + high[axis], 1e-3);
            EXPECT_LT(entryOfBox(f, low, high), 10 - high[axis]);
            EXPECT_GT(exitOfBox(f, low, high), 10 + high[axis]);
        }
    EXPECT_TRUE(opens(1, 1, 1));
    EXPECT_FALSE(opens(2, 1, 3));
    EXPECT_FALSE(opens(-2, -1, 3));
    EXPECT_TRUE(opens(-1, 0, 3));
    EXPECT_FALSE(opens(2, 3, 1));
}

TEST(Boxes, OfABundleOpenForEveryRayOfIt) {
    test::Random r(51);
    int opened = 0, straddling = 0;
    for (int i = 0; i < 20000; ++i) {
        const vec3 o(r(-3, 3), r(-3, 3), r(-3, 3)), middle = r.direction();
        const float reach = 20, width = i % 3 ? 0.01f : 0.4f;
        RayFrame rays[8];
        RayBundle bundle{o, vec3(0x1p100f), vec3(-0x1p100f), 0};
        for (RayFrame& ray : rays) {
            ray = frameOfRay(o, unitLength(middle + vec3(r.direction()) * width), reach);
            bundle.least = lesser3(bundle.least, ray.inverse);
            bundle.most = greater3(bundle.most, ray.inverse);
            bundle.pad = ray.pad;
        }
        straddling += bundle.least.x < 0 && bundle.most.x > 0;
        const vec3 low = o + middle * float(r(-2, 9)) + vec3(r.direction()) * float(r(0, 1));
        const vec3 high = low + vec3(r(0, 1), r(0, 1), r(0, 1));
        for (const RayFrame& ray : rays) {
            // As far as the bundle is narrow its bounds are close: they are attained when all rays are one.
            const RayBundle alone{o, ray.inverse, ray.inverse, ray.pad};
            EXPECT_EQ(earliestEntry(alone, low, high), entryOfBox(ray, low, high));
            EXPECT_EQ(latestExit(alone, low, high), exitOfBox(ray, low, high));
            EXPECT_LE(earliestEntry(bundle, low, high), entryOfBox(ray, low, high));
            EXPECT_GE(latestExit(bundle, low, high), exitOfBox(ray, low, high));
            opened += opens(entryOfBox(ray, low, high), exitOfBox(ray, low, high), reach);
        }
    }
    EXPECT_GT(opened, 10000);
    EXPECT_GT(straddling, 100);
}

TEST(CrossValue, HasTheExactSign) {
    EXPECT_EQ(crossValue(2, 3, 4, 5), -14.0f);
    // Products that round alike: (1 + u)^2 against 1 + 2u, with u = 2^-23.
    const float a = 1 + 0x1p-23f, b = 1 + 0x1p-22f;
    EXPECT_EQ(a * a - b * 1.0f, 0.0f);
    EXPECT_GT(crossValue(a, a, b, 1), 0.0f);
    EXPECT_LT(crossValue(b, 1, a, a), 0.0f);
}

// z = 10, the origin behind its middle; corners counter-clockwise or clockwise.
TEST(HitTriangle, IsMetFromBothSidesInsideAndOnItsEdges) {
    const vec3 p0(-1, -1, 10), p1(3, -1, 10), p2(-1, 3, 10);
    const RayFrame f = frameOfRay(vec3(0), kZ, 10);
    const TriangleHit hit = hitTriangle(f, p0, p1, p2, false);
    EXPECT_EQ(hit.t, 10.0f);
    EXPECT_EQ(hit.w0, 0.5f);
    EXPECT_EQ(hit.w1, 0.25f);
    EXPECT_EQ(hit.w2, 0.25f);
    EXPECT_EQ(hitTriangle(f, p0, p2, p1, false).t, 10.0f);
    EXPECT_EQ(hitTriangle(f, p0, p1, p2, true).t, 0.0f);
    for (const vec3 beside : {vec3(2, 0, 0), vec3(0, 2, 0), vec3(-4, 0, 0), vec3(0, -4, 0), vec3(3, 3, 0)}) {
        EXPECT_EQ(hitTriangle(f, p0 + beside, p1 + beside, p2 + beside, false).t, 0.0f);
        EXPECT_EQ(hitTriangle(f, p0 + beside, p2 + beside, p1 + beside, false).t, 0.0f);
    }
    for (const vec3 edge : {vec3(1, 0, 0), vec3(0, 1, 0), vec3(-1, -1, 0), vec3(1, 1, 0)}) {  // three edges and a corner
        EXPECT_EQ(hitTriangle(f, p0 + edge, p1 + edge, p2 + edge, false).t, 10.0f);
        EXPECT_EQ(hitTriangle(f, p0 + edge, p2 + edge, p1 + edge, false).t, 10.0f);
    }
    const vec3 behind(0, 0, -20);
    EXPECT_EQ(hitTriangle(f, p0 + behind, p1 + behind, p2 + behind, false).t, 0.0f);
    const vec3 along(0, 4, 0);
    EXPECT_EQ(hitTriangle(f, p0, p0 + along, p0 + 2.0f * along, false).t, 0.0f);            // no area
    const TriangleHit edgeOn = hitTriangle(f, {0, -1, 10}, {0, 1, 10}, {0, 3, 10}, false);  // no area, and the ray goes through it
    EXPECT_EQ(edgeOn.t, 0.0f);
    EXPECT_EQ(edgeOn.w0, 0.0f);
    const float far = 1.5f * kFarthestHit;
    EXPECT_EQ(hitTriangle(f, {-far, -far, far}, {3 * far, -far, far}, {-far, 3 * far, far}, false).t, 0.0f);
}

// A ray through the triangle's box is not enough: beyond each edge in turn, behind its origin, and further than anything is hit.
TEST(HitTriangle, IsMissedWithinItsBox) {
    const RayFrame f = frameOfRay(vec3(0), kZ, 10);
    const vec3 corner[3] = {{-2.5f, -2.5f, 10}, {1.5f, -2.5f, 10}, {-2.5f, 1.5f, 10}};  // the ray passes beyond the longest edge
    for (int k = 0; k < 3; ++k) {
        const vec3 &a = corner[k], &b = corner[(k + 1) % 3], &c = corner[(k + 2) % 3];
        EXPECT_EQ(hitTriangle(f, a, b, c, false).t, 0.0f) << k;
        EXPECT_EQ(hitTriangle(f, c, b, a, false).t, 0.0f) << k;
    }
    // Met at half of the first corner's z and a quarter of both others'.
    const auto leaning = [&](float z0, float z1) { return hitTriangle(f, {-1, -1, z0}, {3, -1, z1}, {-1, 3, z1}, false).t; };
    EXPECT_EQ(leaning(-3, 5), 1.0f);
    EXPECT_EQ(leaning(-5, 3), 0.0f);
    EXPECT_EQ(leaning(0.5f * kFarthestHit, 1.25f * kFarthestHit), 0.875f * kFarthestHit);
    EXPECT_EQ(leaning(0.5f * kFarthestHit, 2.5f * kFarthestHit), 0.0f);
}

// The box of a triangle holds all three corners, whichever is the least or the greatest.
TEST(HitTriangle, IsNotEnteredLate) {
    const vec3 corner[3] = {{-1, -1, 10}, {3, 0.5f, 10}, {0.2f, 3, 10}};
    for (int k = 0; k < 3; ++k) {
        const vec3 &a = corner[k], &b = corner[(k + 1) % 3], &c = corner[(k + 2) % 3];
        EXPECT_NEAR(hitTriangle(frameOfRay(vec3(0), kZ, 10), a, b, c, false).t, 10, 1e-5);
        vec3 tilted[3] = {a, b, c};
        for (vec3& p : tilted) p.z = p == corner[0] ? 14.0f : 10.0f;
        const double z = 10 + 4 * hitTriangle(frameOfRay(vec3(0), kZ, 10), corner[0], corner[1], corner[2], false).w0;
        EXPECT_NEAR(hitTriangle(frameOfRay({0, 0, 20}, -kZ, 20), tilted[0], tilted[1], tilted[2], false).t, 20 - z, 1e-4);
    }
}

TEST(LeastSlope, IsHalfThatOfTheRayAndNoMoreThanAThousandth) {
    const vec3 up(0, 1, 0);
    EXPECT_EQ(leastSlope({0.6f, -0.8f, 0}, up), 0x1p-10f);
    EXPECT_EQ(leastSlope({0.6f, 0.8f, 0}, up), 0x1p-10f);
    EXPECT_EQ(leastSlope({1, -0x1p-9f, 0}, up), 0x1p-10f);
    EXPECT_EQ(leastSlope({1, -0x1p-12f, 0}, up), 0x1p-13f);
    EXPECT_EQ(leastSlope({1, 0x1p-12f, 0}, up), 0x1p-13f);
    EXPECT_EQ(leastSlope({1, 0, 0}, up), 0.0f);
}

TEST(OnSideOf, TurnsWhatRunsBelowTheSlope) {
    const vec3 up(0, 1, 0);
    EXPECT_EQ(onSideOf({0.6f, 0.8f, 0}, up, 0.5f), vec3(0.6f, 0.8f, 0));
    EXPECT_NEAR(onSideOf({0.6f, -0.8f, 0}, up, 0).x, 1, 16 * kUlp);
    EXPECT_EQ(onSideOf({0.6f, -0.8f, 0}, up, 0).y, 0.0f);
    for (const float y : {-0.8f, 0.0f, 0.5f}) {
        const vec3 turned = onSideOf({0.6f, y, 0}, up, 0.625f);
        EXPECT_NEAR(turned.y, 0.625 / std::hypot(0.6, 0.625), 16 * kUlp) << y;
        EXPECT_NEAR(turned.x, 0.6 / std::hypot(0.6, 0.625), 16 * kUlp) << y;
    }
    EXPECT_EQ(onSideOf({3, 4, 0}, up, 4), vec3(3, 4, 0));  // with the slope: as it is, not made unit
}

TEST(NormalForRays, IsTheSmoothOneUntilTheMirroredRayWouldRunIntoThePolygon) {
    const vec3 up(0, 1, 0), tilted = unitLength({0.3f, 1, 0});
    EXPECT_EQ(normalForRays({0, -1, 0}, up, tilted), tilted);
    const auto mirroredAt = [&](vec3 d, vec3 smooth_) {
        const vec3 n = normalForRays(d, up, smooth_);
        return mirrored(d, n, -dot3(d, n));
    };
    // Direction above the polygon that a part of `across` along it and the least slope make.
    const auto leaving = [](double across) { return 0x1p-10 / std::hypot(across, 0x1p-10); };
    // Mirrored ray that would run below the polygon: it leaves with the least slope, toward its image.
    const vec3 d = unitLength({-0.2f, -1, 0}), leaning = unitLength({3, 1, 0}), image = mirrored(d, leaning, -dot3(d, leaning));
    ASSERT_LT(image.y, 0.0f);
    const vec3 below = mirroredAt(d, leaning);
    EXPECT_NEAR(below.y, leaving(double(image.x)), 64 * kUlp);
    EXPECT_NEAR(below.x, 1, 64 * kUlp);
    // Mirrored ray above the polygon, with half of the least slope.
    const vec3 shallow = mirroredAt({0, -1, 0}, unitLength({1, 1 + 0x1p-11f, 0}));
    EXPECT_NEAR(shallow.y, 0x1p-10, 64 * kUlp);
    // Met from behind: straight on, but for the least slope.
    const vec3 behind = mirroredAt(unitLength({1, -0.2f, 0}), unitLength({0.5f, 0.8f, 0.4f}));
    EXPECT_NEAR(behind.x, 1, 64 * kUlp);
    EXPECT_NEAR(behind.y, leaving(1 / std::hypot(1, 0.2)), 64 * kUlp);
    EXPECT_NEAR(behind.z, 0, 64 * kUlp);
    // A normal of another surface.
    EXPECT_EQ(normalForRays(unitLength({0.3f, -1, 0}), up, unitLength({0.3f, -1, 0})), up);
    // Along the polygon but for 2^-30; d is unit within rounding, and so is what it is compared with.
    EXPECT_EQ(normalForRays({0.60000002f, -1e-9f, 0.8f}, up, tilted), up);
}

// From the face normal to beyond the horizon, and from straight down to along the polygon: no step of what is mirrored is longer than a few times the step of the angles.
TEST(NormalForRays, IsContinuous) {
    const vec3 up(0, 1, 0);
    const int steps = 4096;
    const double step = 1.5 / steps;
    for (int way = 0; way < 2; ++way)
        for (const double other : {0.1, 0.5, 0.9, 1.3}) {
            vec3 before(0);
            for (int i = 0; i < steps; ++i) {
                const double tilt = way == 0 ? i * step : other, slope = way == 0 ? other : i * step;
                const vec3 smooth_(float(std::sin(tilt) * 0.8), float(std::cos(tilt)), float(std::sin(tilt) * 0.6));
                const vec3 d = unitLength({float(-std::sin(slope)), -float(std::cos(slope)), 0});
                const vec3 n = normalForRays(d, up, smooth_), m = mirrored(d, n, -dot3(d, n));
                ASSERT_GE(m.y, leastSlope(d, up) - 16 * float(kUlp)) << tilt << ", " << slope;
                // Where the image is turned toward the polygon it is at least kLeastLean long before it is made unit.
                if (i > 0) {
                    ASSERT_LE(double(glm::length(m - before)), 4 * step / double(kLeastLean)) << tilt << ", " << slope;
                }
                before = m;
            }
        }
}

TEST(PassesTriangle, OpaqueBlocksTranslucentDimsOnTheWayOut) {
    EXPECT_EQ(passesTriangle(0, -1), 0.0f);
    EXPECT_EQ(passesTriangle(0, 1), 0.0f);
    EXPECT_EQ(passesTriangle(0.25f, 1), 0.25f);
    EXPECT_EQ(passesTriangle(0.25f, -1), 1.0f);
}

}  // namespace
}  // namespace plumb::gpu
