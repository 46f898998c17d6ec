// SPDX-License-Identifier: MIT
// Detail: what is proved of simplified meshes and tessellated shapes, by brute force that shares no code with the proof.
#include "pipeline/detail/detail.h"
#include "host/error.h"
#include "pipeline/detail/deviation.h"
#include "pipeline/detail/projected_scale.h"
#include "pipeline/scene/shape.h"
#include "tests/support/scenes.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace plumb::test {
namespace {

using detail::Surface;

std::vector<detail::Corners> cornersOf(const TriangleMesh& mesh) {
    std::vector<detail::Corners> out;
    for (const auto& t : mesh.triangles)
        out.push_back(
            {glm::dvec3(mesh.positions[t.vertex[0]]), glm::dvec3(mesh.positions[t.vertex[1]]), glm::dvec3(mesh.positions[t.vertex[2]])});
    return out;
}

TriangleMesh meshOf(const GeneratedShape& shape) {
    std::vector<Material> materials;
    return finishMesh(polygonsOf(shape), materials, 0, {});
}

// Distance from a point to a triangle by its plane and its edges: no clamped barycentric coordinates, as the proof has.
double distanceTo(const glm::dvec3& p, const detail::Corners& t) {
    const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
    double nearest = std::numeric_limits<double>::infinity();
    bool inside = glm::dot(n, n) > 0;
    for (size_t k = 0; k < 3; ++k) {
        const glm::dvec3 a = t[k], b = t[(k + 1) % 3], edge = b - a;
        if (glm::dot(glm::cross(edge, p - a), n) < 0) inside = false;
        const double along = glm::dot(edge, edge) > 0 ? std::min(1.0, std::max(0.0, glm::dot(p - a, edge) / glm::dot(edge, edge))) : 0;
        nearest = std::min(nearest, glm::length(p - a - along * edge));
    }
    return inside ? std::min(nearest, std::abs(glm::dot(p - t[0], n)) / glm::length(n)) : nearest;
}

// Largest distance of random points of `from` to `to`.
double sampledDistance(const std::vector<detail::Corners>& from, const std::vector<detail::Corners>& to, int samples, Random& r) {
    double largest = 0;
    for (int i = 0; i < samples; ++i) {
        const detail::Corners& t = from[r.below(uint32_t(from.size()))];
        double u = r(0, 1), v = r(0, 1);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const glm::dvec3 p = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
        double nearest = std::numeric_limits<double>::infinity();
        for (const detail::Corners& other : to) nearest = std::min(nearest, distanceTo(p, other));
        largest = std::max(largest, nearest);
    }
    return largest;
}

const auto kNothing = [] {};

TEST(Deviation, HoldsWhatIsSoAndRefusesWhatIsNot) {
    Random r(3);
    const TriangleMesh coarse = meshOf({ShapeKind::sphere, 1, 0, 16}), fine = meshOf({ShapeKind::sphere, 1, 0, 96});
    const Surface a(cornersOf(coarse)), b(cornersOf(fine));
    const double bound = deviationOf({ShapeKind::sphere, 1, 0, 16});  // no chord of the finer one is outside the sphere
    EXPECT_TRUE(detail::within(a, b, bound, 1, kNothing));
    EXPECT_TRUE(detail::within(b, a, bound, 2, kNothing));
    const double seen =
        std::max(sampledDistance(cornersOf(fine), cornersOf(coarse), 400, r), sampledDistance(cornersOf(coarse), cornersOf(fine), 400, r));
    EXPECT_GT(seen, bound / 2);
    EXPECT_FALSE(detail::within(a, b, seen * (1 - 0x1p-20), 1, kNothing)) << "points were sampled that are further away";
    EXPECT_FALSE(detail::within(a, b, bound / 2, 1, kNothing));
    EXPECT_FALSE(detail::within(a, b, 0, 1, kNothing));
    EXPECT_FALSE(detail::within(a, b, std::numeric_limits<double>::quiet_NaN(), 1, kNothing));
}

// Random soups, moved: the proof never says yes below a distance that was sampled, and not later than a little above the movement.
TEST(Deviation, NeverHoldsBelowASampledDistance) {
    Random r(7);
    int held = 0;
    for (int round = 0; round < 40; ++round) {
        std::vector<detail::Corners> from, to;
        const glm::dvec3 move = glm::dvec3(r.direction()) * r(0, 0.2);
        for (int i = 0; i < 12; ++i) {
            detail::Corners c;
            for (glm::dvec3& p : c) p = glm::dvec3(r.direction()) * r(0.2, 2);
            from.push_back(c);
            for (glm::dvec3& p : c) p += move;
            to.push_back(c);
        }
        const double seen = std::max(sampledDistance(from, to, 200, r), sampledDistance(to, from, 200, r));
        const Surface a(from), b(to);
        for (const double share : {0.3, 0.6, 0.9, 0.999})
            if (detail::within(a, b, seen * share, 1, kNothing))
                ADD_FAILURE() << round << ": " << seen << " is sampled, " << seen * share << " is proved";
        held += detail::within(a, b, glm::length(move) * 1.001 + 1e-9, 1, kNothing);
    }
    EXPECT_EQ(held, 40) << "a moved surface is within the movement";
}

TEST(ProjectedScale, StretchIsTheLongestImageOfAUnitVector) {
    Random r(11);
    for (int round = 0; round < 200; ++round) {
        glm::dmat3 m;
        for (int c = 0; c < 3; ++c) m[c] = glm::dvec3(r.direction()) * std::exp2(r(-8, 8));
        const double stretch = detail::largestStretch(m);
        double longest = 0;
        glm::dvec3 v(1, 0.7, 0.4);
        for (int i = 0; i < 500; ++i) v = glm::normalize(glm::transpose(m) * (m * v)), longest = std::max(longest, glm::length(m * v));
        ASSERT_GE(stretch, longest);
        ASSERT_LE(stretch, longest * (1 + 0x1p-20)) << round;
    }
    EXPECT_GE(detail::largestStretch(glm::dmat3(3)), 3);
    EXPECT_LE(detail::largestStretch(glm::dmat3(3)), 3 * (1 + 0x1p-30));
    EXPECT_EQ(detail::largestStretch(glm::dmat3(0)), 0);
}

Scene sphereAt(double z, double radius, uint32_t segments) {
    Scene s = litScene();
    TriangleMesh mesh = meshOf({ShapeKind::sphere, radius, 0, segments});
    addObject(s, std::move(mesh));
    s.objects.back().worldFromObject = glm::translate(glm::dmat4(1), {0.2, -0.1, z});
    return s;
}

// Points of the object in the frame, moved by the allowed deviation in any direction.
TEST(ProjectedScale, NoAllowedMovementIsMoreThanThePixels) {
    Random r(13);
    const glm::uvec2 size(320, 240);
    double most = 0;
    for (const double z : {-1.6, -4.0, -40.0})
        for (const double pixels : {0.25, 1.0, 8.0}) {
            Scene s = sphereAt(z, 1, 24);
            s.objects[0].worldFromObject *= glm::scale(glm::dmat4(1), {1, 0.5, 0.25});
            const Camera camera = *s.camera;
            const detail::Allowed allowed = detail::allowedDeviation(s, 0, {&camera, 1}, size, pixels);
            ASSERT_EQ(std::string(allowed.why), "");
            const auto project = [&](const glm::dvec3& p) {
                const glm::dvec3 world(s.objects[0].worldFromObject * glm::dvec4(p, 1));
                return glm::dvec2(world.x, world.y) * (kFocal / -world.z);
            };
            for (int i = 0; i < 4000; ++i) {
                const glm::dvec3 p(s.meshes[0].positions[r.below(uint32_t(s.meshes[0].positions.size()))]);
                const glm::dvec2 seen = project(p);
                if (std::abs(seen.x) > size.x / 2.0 || std::abs(seen.y) > size.y / 2.0) continue;
                const double moved = glm::length(project(p + glm::dvec3(r.direction()) * allowed.deviation) - seen);
                ASSERT_LE(moved, pixels);
                most = std::max(most, moved / pixels);
            }
        }
    EXPECT_GT(most, 0.5) << "the bound is loose";
}

Scene suzanne(glm::uvec2 size) { return committed(std::string(PLUMB_SOURCE_DIR) + "/scenes/suzanne.toml", size); }

TEST(Detail, ASimplifiedMeshIsAsNearAsItSays) {
    Random r(17);
    const Scene scene = suzanne({320, 240});
    uint64_t before = scene.meshes[0].triangles.size();
    for (const double pixels : {0.5, 2.0}) {
        const Detail detail = detailed(scene, {pixels, {320, 240}});
        ASSERT_EQ(detail.rows.size(), 1u);
        const DetailRow& row = detail.rows[0];
        EXPECT_LT(row.drawn, before) << pixels << " px take nothing more away";
        before = row.drawn;
        EXPECT_LE(row.pixels, pixels);
        EXPECT_TRUE(detail.redrawn[0]);
        EXPECT_EQ(detail.scene.meshes.size(), 1u);
        const TriangleMesh& drawn = detail.scene.meshes[0];
        EXPECT_EQ(drawn.triangles.size(), row.drawn);
        EXPECT_LE(sampledDistance(cornersOf(scene.meshes[0]), cornersOf(drawn), 150, r), row.deviation);
        EXPECT_LE(sampledDistance(cornersOf(drawn), cornersOf(scene.meshes[0]), 150, r), row.deviation);
        for (size_t t = 0; t < drawn.triangles.size(); ++t) {
            ASSERT_EQ(drawn.triangles[t].face, t);
            for (const uint32_t v : drawn.triangles[t].vertex) ASSERT_EQ(drawn.vertexMaterial[v], drawn.faceMaterial[t]);
        }
        ASSERT_EQ(detail.sentences(pixels).size(), 1u);
        EXPECT_NE(detail.sentences(pixels)[0].find("'suzanne' is drawn with " + std::to_string(row.drawn)), std::string::npos);
    }
}

TEST(Detail, WhatCannotBeSimplifiedIsKeptByName) {
    Scene s = litScene();
    const std::vector<Corners> near = {{glm::vec3(0, 0, -0.2f), glm::vec3(1, 0, -2), glm::vec3(0, 1, -2)}};
    addObject(s, soupOf(near, 1));
    const std::vector<Corners> one = {{glm::vec3(0, 0, -4), glm::vec3(1, 0, -4), glm::vec3(0, 1, -4)}};
    addObject(s, soupOf(one, 1));
    const Detail detail = detailed(s, {1, {64, 64}});
    EXPECT_EQ(detail.rows[0].kept, "it reaches the near plane");
    EXPECT_EQ(detail.rows[1].kept, "no triangle can be taken away");
    EXPECT_EQ(detail.drawnTriangles(), 2u);
    EXPECT_EQ(detail.sentences(1).size(), 2u);
    for (const double pixels : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) EXPECT_THROW(detailed(s, {pixels, {64, 64}}), Error);
}

// Near and far instances of one mesh; two that are equally far share theirs.
TEST(Detail, EachDistanceHasItsOwnMesh) {
    Scene scene = suzanne({320, 240});
    const Object first = scene.objects[0];
    for (const double away : {0.0, 30.0}) {
        Object more = first;
        more.worldFromObject =
            glm::translate(glm::dmat4(1), scene.camera->forward * away + scene.camera->right * (away + 0.5)) * first.worldFromObject;
        scene.objects.push_back(more);
    }
    const Detail detail = detailed(scene, {1, {320, 240}});
    EXPECT_EQ(detail.scene.objects[0].mesh, detail.scene.objects[1].mesh);
    EXPECT_NE(detail.scene.objects[0].mesh, detail.scene.objects[2].mesh);
    EXPECT_LT(detail.rows[2].drawn, detail.rows[0].drawn);
    EXPECT_EQ(detail.scene.meshes.size(), 2u) << "the whole mesh is not kept";
}

TEST(Detail, ShapesHaveTheSegmentsThatABudgetTakes) {
    Scene s = litScene();
    for (const double z : {-3.0, -30.0, -300.0}) {
        TriangleMesh mesh = meshOf({ShapeKind::sphere, 1, 0, 64});
        mesh.shape = std::make_shared<GeneratedShape>(GeneratedShape{ShapeKind::sphere, 1, 0, 64});
        addObject(s, std::move(mesh));
        s.objects.back().worldFromObject = glm::translate(glm::dmat4(1), {0, 0, z});
    }
    const Detail detail = detailed(s, {0.5, {320, 240}});
    for (size_t o = 0; o < 3; ++o) {
        const DetailRow& row = detail.rows[o];
        EXPECT_LE(row.pixels, 0.5);
        EXPECT_EQ(row.drawn, uint64_t(row.segments) * (row.segments - 2)) << "two triangles a polygon, one at a pole";
        if (o > 0) {
            EXPECT_LT(row.segments, detail.rows[o - 1].segments);
        }
    }
    EXPECT_GT(detail.rows[0].segments, 8u);
    Scene one = litScene();
    TriangleMesh drum = meshOf({ShapeKind::cylinder, 1, 2, 8});
    drum.shape = std::make_shared<GeneratedShape>(GeneratedShape{ShapeKind::cylinder, 1, 2, 8});
    addObject(one, std::move(drum));
    one.objects[0].worldFromObject = glm::translate(glm::dmat4(1), {0, 0, -3});
    const Detail finest = detailed(one, {1e-6, {320, 240}});
    EXPECT_EQ(finest.rows[0].segments, segmentRangeOf(ShapeKind::cylinder).most);
    EXPECT_GT(finest.rows[0].pixels, 1e-6) << "it has no more segments, and says what that leaves";
    EXPECT_NE(finest.sentences(1e-6)[0].find("4096 segments; its outline moves by at most"), std::string::npos)
        << finest.sentences(1e-6)[0];

    const Detail stated = tessellatedScene(s, 9);
    EXPECT_EQ(stated.rows[0].segments, 10u) << "rounded up to what a sphere can have";
    EXPECT_THROW(tessellatedScene(suzanne({64, 64}), 8), Error);
}

}  // namespace
}  // namespace plumb::test
