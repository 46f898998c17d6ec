// SPDX-License-Identifier: MIT
// Are the rays right? The twin's pictures against a textbook tracer in binary64, and rows 13 to 18 of docs/extremes.md.
#include "tests/oracle/trace_oracle.h"

#include "pipeline/render/rays/trace_frame.h"
#include "tests/support/plain_picture.h"
#include "tests/support/ray_scenes.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <glm/glm.hpp>
#include <ostream>
#include <string>
#include <vector>

namespace plumb::test {
namespace {

constexpr double kU = 0x1p-24;

struct Row {
    const char* name;
    Scene (*build)();
};
std::ostream& operator<<(std::ostream& out, const Row& r) { return out << r.name; }
class TraceOracleRows : public ::testing::TestWithParam<Row> {};

// How far float32 may displace a primary ray, in pixels: a hit adds an error of position and direction below 64 u of its own size, times
// reach / radius where the surface is curved; mirrors spread what comes before, so an error counts in full only where it arises.
double edgeOf(const Scene& s, double focal) {
    double reach = 0, least = 1;
    for (const SphereShape& b : s.spheres)
        reach = std::max(reach, glm::length(b.centre - s.camera->eye) + b.radius), least = std::min(least, b.radius);
    return s.maxDepth * 64 * kU * (1 + reach / least) * focal;
}

TEST_P(TraceOracleRows, EveryPixelAwayFromAnEdgeIsRight) {
    const Scene scene = GetParam().build();
    RenderRequest request;
    request.width = 131;
    request.height = 97;
    request.shading = Shading::ray;
    request.background = *scene.background;
    request.maxDepth = scene.maxDepth;
    request.planes = kPlaneColour | kPlaneLinear | kPlaneObject | kPlaneDistance;
    const RenderResult result = renderCpu(scene, request);
    const TraceOracle oracle(scene, glm::dvec3(*scene.background), scene.maxDepth);
    const Camera& camera = *scene.camera;
    const double focal = request.height / 2.0 / std::tan(glm::radians(camera.fovYDegrees / 2)), edge = edgeOf(scene, focal);
    ASSERT_LT(edge, 0.5);
    int nearEdges = 0, differing = 0;
    for (uint32_t y = 0; y < request.height; ++y)
        for (uint32_t x = 0; x < request.width; ++x) {
            const auto at = [&](double dx, double dy) {
                return oracle.look(camera.eye, camera.forward + camera.right * ((x + 0.5 + dx - request.width / 2.0) / focal) -
                                                   camera.up * ((y + 0.5 + dy - request.height / 2.0) / focal));
            };
            const OracleSeen centre = at(0, 0);
            bool nearEdge = false;
            int low[3], high[3];
            for (int c = 0; c < 3; ++c) low[c] = high[c] = srgb8(centre.colour[c]);
            for (int k = 0; k < 8; ++k) {
                const OracleSeen beside = at(edge * std::cos(k * 0.7853981634), edge * std::sin(k * 0.7853981634));
                nearEdge |= beside.path != centre.path;
                for (int c = 0; c < 3; ++c)
                    low[c] = std::min(low[c], srgb8(beside.colour[c])), high[c] = std::max(high[c], srgb8(beside.colour[c]));
            }
            const size_t i = size_t(y) * request.width + x;
            bool far = false;
            for (int c = 0; c < 3; ++c) {
                const int code = srgb8(double(result.frame.linear[3 * i + size_t(c)]));
                far |= code < low[c] - 1 || code > high[c] + 1;
            }
            nearEdges += nearEdge;
            differing += far;
            if (nearEdge) continue;
            EXPECT_EQ(int(result.frame.object[i]), centre.object) << "pixel " << x << ", " << y;
            EXPECT_FALSE(far) << fmt::format("pixel ({}, {}): twin {} {} {}, oracle {} {} {}", x, y, result.frame.linear[3 * i],
                                             result.frame.linear[3 * i + 1], result.frame.linear[3 * i + 2], centre.colour.x,
                                             centre.colour.y, centre.colour.z);
            if (centre.object < 0) continue;
            // From the shape of the solution: t is off by the direction's and the radicand's rounding, relative to the way, over the
            // cosine at which the surface is met; the hull of the neighbours bounds that.
            EXPECT_NEAR(double(result.frame.distance[i]), centre.distance,
                        64 * kU * centre.distance + std::abs(at(edge, 0).distance - centre.distance) +
                            std::abs(at(0, edge).distance - centre.distance));
        }
    std::printf("%s: %d of %u pixels within %.2g px of an edge, %d differ by more than a level\n", GetParam().name, nearEdges,
                request.width * request.height, edge, differing);
    EXPECT_LT(nearEdges, int(request.width * request.height * 3 / 4)) << "the oracle would say nothing";
}

INSTANTIATE_TEST_SUITE_P(Rows, TraceOracleRows, ::testing::Values(Row{"mirrors", mirrors}, Row{"glass", glass}, Row{"inGlass", inGlass}),
                         [](const auto& info) { return std::string(info.param.name); });

using gpu::vec3;

// Row 13: radii and distances over fifteen decades, impact up to the silhouette. Hit or miss is wrong only within the bound.
TEST(TraceStress, SpheresOfEverySizeAndDistance) {
    Random r(113);
    uint64_t asked = 0, wrong = 0;
    for (int size = -6; size <= 9; size += 3)
        for (int ratio = 0; ratio <= 9; ++ratio)
            for (int i = 0; i < 2000; ++i) {
                const double radius = std::ldexp(1.0, int(size * 3.3219)), way = radius * (1 + std::ldexp(1.0, int(ratio * 3.3219)));
                if (way > 0x1p50) continue;
                const vec3 d = gpu::unitLength(vec3(r.direction()));
                vec3 side = glm::cross(d, vec3(r.direction()));
                side = side / glm::length(side);
                const double impact = radius * (i % 4 == 0 ? 1 + r(-1e-3, 1e-3) : r(0, 1.2));
                const vec3 c = d * float(way) + side * float(impact);
                const gpu::SphereHit hit = gpu::hitSphere(vec3(0), d, c, float(radius), 0, gpu::kStartElsewhere, true, false);
                // The exact impact of the floats as they are.
                long double k = 0, dd = 0, cc = 0;
                for (int a = 0; a < 3; ++a) k += static_cast<long double>(c[a]) * d[a], dd += static_cast<long double>(d[a]) * d[a];
                for (int a = 0; a < 3; ++a) {
                    const long double l = k / dd * d[a] - c[a];
                    cc += l * l;
                }
                const double exact = double(std::sqrt(cc)), rr = double(float(radius));
                ++asked;
                // l: 8 u of itself (each coordinate about one rounding, then the small step along d); its square and the difference 6 u.
                // k is off by 6 u of the way (products, sums, length of d), so l is found from a point that far along: a rounding of that, too.
                const double size = rr + 6 * kU * way, bound = 16 * kU * size;
                const bool hits = hit.t > 0;
                if (hits != (exact <= rr)) {
                    ++wrong;
                    EXPECT_LE(std::abs(exact - rr), bound) << "radius " << radius << ", distance " << way;
                }
                if (!hits) continue;
                EXPECT_NEAR(double(glm::length(glm::dvec3(hit.offset))), rr, 32 * kU * size) << "radius " << radius << ", distance " << way;
            }
    std::printf("row 13: %llu rays, %llu decided otherwise within the bound\n", static_cast<unsigned long long>(asked),
                static_cast<unsigned long long>(wrong));
}

// Row 13 from close by: every radius, gaps from 2^-30 of it to 16 of them, the eye and other origins near it outside and inside. What float32 gives is
// the root of a quadratic whose coefficients are off by their rounding; long double has the roots of both ends.
TEST(TraceStress, SpheresFromCloseBy) {
    Random r(213);
    uint64_t asked = 0, open = 0;
    for (int size = -6; size <= 9; ++size)
        for (int ratio = -30; ratio <= 4; ++ratio)
            for (const bool inside : {false, true}) {
                if (inside && ratio > -1) continue;
                for (int i = 0; i < 60; ++i) {
                    const long double radius = std::pow(10.0L, size),
                                      gap = std::ldexp(radius, ratio) * (1 + r(0, 1)) * (inside ? -0.5L : 1.0L);
                    const glm::dvec3 down = r.direction();
                    long double centre[3];
                    vec3 c;
                    for (int a = 0; a < 3; ++a) centre[a] = down[a] / glm::length(down) * (radius + gap), c[a] = float(centre[a]);
                    long double cc = 0;
                    for (int a = 0; a < 3; ++a) cc += centre[a] * centre[a];
                    const float power = float((std::sqrt(cc) - radius) * (std::sqrt(cc) + radius));
                    const bool eye = i % 2 == 0;
                    const vec3 o = eye ? vec3(0) : vec3(r.direction()) * float(std::abs(gap) * r(0, 0.9));
                    vec3 d = gpu::unitLength(vec3(r.direction()));
                    if (i % 3 == 0)
                        d = gpu::unitLength(d - vec3(down) * float(glm::dot(glm::dvec3(d), down) -
                                                                   r(0, 2) * std::sqrt(2 * double(std::abs(gap) / radius))));
                    const gpu::SphereHit hit = gpu::hitSphere(o, d, c, float(radius), power, gpu::kStartElsewhere, true, true);
                    long double k = 0, dd = 0, oo = 0, oc = 0, spread = 0;
                    for (int a = 0; a < 3; ++a) {
                        const long double f = static_cast<long double>(o[a]) - centre[a];
                        k -= f * d[a];
                        dd += static_cast<long double>(d[a]) * d[a];
                        oo += static_cast<long double>(o[a]) * o[a];
                        oc += static_cast<long double>(o[a]) * centre[a];
                        spread +=
                            std::abs(static_cast<long double>(o[a])) * (std::abs(static_cast<long double>(o[a])) + 2 * std::abs(centre[a]));
                    }
                    const long double p = (std::sqrt(cc) - radius) * (std::sqrt(cc) + radius) + oo - 2 * oc,
                                      reach = std::sqrt(cc) + std::sqrt(oo);
                    // powerAt: 5 u of its terms, u of the eye's power, u of the centre in 2 o.c; further off than two radii the plain form: 8 u of both squares.
                    const bool near = gpu::startsClose(o, c, float(radius));
                    const long double powerError =
                        kU * (near ? 8 * spread + 2 * std::abs(p) + 2 * std::abs(double(power)) : 8 * (reach * reach + radius * radius));
                    // k: its three products and sums, and the centre's rounding; the far form's refinement adds its own.
                    const long double alongError = 8 * kU * reach;
                    ++asked;
                    if (std::abs(p) <= powerError) {
                        ++open;
                        continue;
                    }
                    // The root for coefficients moved as far as they may be, toward the least and the greatest way.
                    const auto way = [&](long double along, long double outside) -> long double {
                        const long double square = along * along - dd * outside;
                        if (square < 0) return 0;
                        const long double h = std::sqrt(square);
                        if (outside < 0) return along > 0 ? (along + h) / dd : -outside / (h - along);
                        return along > 0 ? outside / (along + h) : 0;
                    };
                    const int toward = p < 0 ? -1 : 1;
                    long double least = way(k + toward * alongError, p - powerError),
                                greatest = way(k - toward * alongError, p + powerError);
                    if (p < 0) least = way(k - alongError, p + powerError), greatest = way(k + alongError, p - powerError);
                    const bool meets = hit.t > 0;
                    const auto where = [&] {
                        return fmt::format("radius 1e{}, gap 2^{}{}, {}", size, ratio, inside ? " inside" : "", eye ? "eye" : "elsewhere");
                    };
                    if (!near && p > 0) {  // the plain form's own test has that bound
                        ++open;
                        continue;
                    }
                    if (greatest == 0 && least > 0) {  // the silhouette lies between
                        ++open;
                        continue;
                    }
                    ASSERT_EQ(meets, least > 0) << where();
                    if (!meets) continue;
                    // Root, sum and quotient: 4 u; dd in the plain quotient 18 u.
                    EXPECT_GE(hit.t, least * (1 - 24 * kU)) << where();
                    EXPECT_LE(hit.t, greatest * (1 + 24 * kU)) << where();
                }
            }
    std::printf("row 13 from close by: %llu rays, %llu left open\n", static_cast<unsigned long long>(asked),
                static_cast<unsigned long long>(open));
    EXPECT_LT(open, asked / 4) << "the closed form would say little";
}

// Row 14: grazing a plane from 45 degrees to 1e-8 from parallel: met ahead, or counted.
TEST(TraceStress, GrazingRaysAreMetOrCounted) {
    Random r(114);
    for (int k = 0; k <= 8; ++k)
        for (int i = 0; i < 2000; ++i) {
            const vec3 n = gpu::unitLength(vec3(r.direction()));
            vec3 along = glm::cross(n, vec3(r.direction()));
            along = along / glm::length(along);
            const vec3 d = gpu::unitLength(along - n * float(std::pow(10.0, -k)));
            const gpu::PlaneHit hit = gpu::hitPlane(n * 2.0f, d, {n, 0}, {along, 0}, {glm::cross(n, along), 0},
                                                    {-1e30f, 1e30f, -1e30f, 1e30f}, true, gpu::kStartElsewhere);
            if (hit.undecided) {
                EXPECT_EQ(hit.t, 0.0f);
                EXPECT_GE(k, 6);
                continue;
            }
            // Decided: the sign of the slope is the exact one.
            const double slope = double(n.x) * d.x + double(n.y) * d.y + double(n.z) * d.z;
            EXPECT_EQ(hit.t > 0, slope < 0);
            if (k <= 4) {
                EXPECT_GT(hit.t, 0.0f);
            }
        }
}

// Row 16: refraction around the critical angle is continuous, and never not a number.
TEST(TraceStress, TotalReflectionIsContinuous) {
    double largest = 0;
    for (const double index : {1.0 / 3, 0.5, 0.75, 1.0, 1.33, 1.5, 2.0, 3.0})
        for (const bool inside : {false, true}) {
            const double ratio = inside ? index : 1 / index;
            if (ratio <= 1) continue;
            const double critical = std::asin(1 / ratio);
            vec3 before(0);
            for (int i = -4000; i <= 4000; ++i) {
                const double angle = critical + i * 1e-8;
                const vec3 d = gpu::unitLength({float(std::sin(angle)), -float(std::cos(angle)), 0});
                const gpu::Children c = gpu::childrenOf(d, {0, 1, 0}, inside, 0, 1, float(index), float(1 / index), 1, 1, 5, 0);
                // What carries the weight: refracted along the surface, then mirrored by at most what the angle allows.
                const vec3 attributes = c.pass ? c.passDirection : c.mirrorDirection;
                ASSERT_TRUE(std::isfinite(attributes.x) && std::isfinite(attributes.y) && std::isfinite(attributes.z));
                EXPECT_NE(c.pass, c.mirror);
                if (c.pass && before != vec3(0)) largest = std::max(largest, double(glm::length(attributes - before)));
                before = c.pass ? attributes : vec3(0);
                // Refraction in place of total reflection, or the reverse, costs at most the square root of the radicand's rounding
                // (docs/derivations.md#total-reflection).
                if (c.pass) {
                    EXPECT_LE(std::abs(double(attributes.y)), std::sqrt(2 * ratio * ratio * (std::abs(i) * 1e-8 + 8 * kU)) * 2);
                }
            }
        }
    std::printf("row 16: neighbours 1e-8 rad apart differ by at most %.3g\n", largest);
}

// Row 17: the eye inside a sphere, and on it up to a few ULP: from inside the far side is met, at the diameter's end or nearer.
TEST(TraceStress, FromInsideTheFarSideIsMet) {
    Random r(117);
    uint64_t selfHits = 0, beyond = 0;
    for (int i = 0; i < 1000000; ++i) {
        const float radius = float(std::exp2(r(-10, 10)));
        const vec3 c = vec3(r.direction()) * float(std::exp2(r(-5, 12)));
        const gpu::SurfacePoint s = gpu::pointOnSphere(c, radius, vec3(r.direction()) * radius);
        const vec3 d = gpu::unitLength(vec3(r.direction()));
        const bool inward = gpu::dot3(d, s.normal) < 0;
        const vec3 o = gpu::leaveSurface(s.point, inward ? -s.normal : s.normal, s.error);
        // A child of the sphere itself, and a stranger that starts there.
        const gpu::SphereHit own = gpu::hitSphere(o, d, c, radius, 0, inward ? gpu::kStartInside : gpu::kStartOutside, true, false);
        const gpu::SphereHit stranger = gpu::hitSphere(o, d, c, radius, 0, gpu::kStartElsewhere, true, false);
        if (!inward) {
            selfHits += own.t != 0 || stranger.t != 0;
            continue;
        }
        // The origin is off the surface by up to 3 sum |n_i| error_i, which shortens the way across by that over the cosine; where that is
        // more than a quarter of it, float32 cannot tell inside from outside, and nothing is promised.
        const double cosine = -glm::dot(glm::dvec3(d), glm::dvec3(s.normal)), chord = 2 * cosine * double(radius);
        const double shift = 3 * glm::dot(glm::abs(glm::dvec3(s.normal)), glm::dvec3(s.error));
        if (shift > 0.25 * cosine * chord) {
            ++beyond;
            continue;
        }
        selfHits += !(own.t > 0.5 * chord) || !(stranger.t > 0.5 * chord);
    }
    std::printf("row 17: 1000000 rays, %llu of them along the surface or on spheres too small for their distance\n",
                static_cast<unsigned long long>(beyond));
    EXPECT_EQ(selfHits, 0u);
}

// Row 18: a box of six mirrors, a million bounces in paths of fifty: no ray leaves.
TEST(TraceStress, NoRayLeavesABoxOfMirrors) {
    Random r(118);
    std::vector<gpu::PlaneRecord> walls;
    const vec3 centre(3, -2, 5), half(2, 1, 4);
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            gpu::PlaneRecord w{};
            w.normal[axis] = -side;
            w.distance = -side * (centre[axis] + side * half[axis]);
            w.u[(axis + 1) % 3] = 1;
            w.v[(axis + 2) % 3] = 1;
            w.uMin = w.vMin = -1e30f;  // without end: a corner belongs to three walls
            w.uMax = w.vMax = 1e30f;
            walls.push_back(w);
        }
    uint64_t escapes = 0, bounces = 0;
    for (int path = 0; path < 20000; ++path) {
        vec3 o = centre + half * vec3(float(r(-0.99, 0.99)), float(r(-0.99, 0.99)), float(r(-0.99, 0.99)));
        vec3 d = gpu::unitLength(vec3(r.direction()));
        uint32_t from = gpu::kNoObject;
        for (int depth = 0; depth < 50; ++depth) {
            float t = gpu::kFarthestHit;
            uint32_t best = gpu::kNoObject;
            gpu::PlaneHit hit{};
            for (uint32_t i = 0; i < 6; ++i) {
                const gpu::PlaneRecord& w = walls[i];
                const gpu::PlaneHit h = gpu::hitPlane(o, d, {w.normal, w.distance}, {w.u, 0}, {w.v, 0}, {w.uMin, w.uMax, w.vMin, w.vMax},
                                                      true, gpu::startOn(i, from, false));
                if (gpu::isNearer(h.t, i, t, best)) t = h.t, best = i, hit = h;
            }
            if (best == gpu::kNoObject) {
                ++escapes;
                break;
            }
            ++bounces;
            const vec3 n = gpu::dot3(walls[best].normal, d) > 0 ? -walls[best].normal : walls[best].normal;
            const gpu::SurfacePoint s = gpu::pointOnPlane(walls[best].normal, hit.point);
            o = gpu::leaveSurface(s.point, n, s.error);
            d = gpu::mirrored(d, n, -gpu::dot3(d, n));
            from = best;
        }
    }
    std::printf("row 18: %llu bounces, %llu escapes\n", static_cast<unsigned long long>(bounces), static_cast<unsigned long long>(escapes));
    EXPECT_EQ(escapes, 0u);
    EXPECT_EQ(bounces, 1000000u);
}

}  // namespace
}  // namespace plumb::test
