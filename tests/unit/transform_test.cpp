// SPDX-License-Identifier: MIT
#include "pipeline/transform/steps.h"
#include "pipeline/transform/vector.h"

#include <gtest/gtest.h>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>
#include <limits>
#include <random>
#include <span>
#include <vector>

namespace plumb {
namespace {

using glm::dmat4;
using glm::dvec2;
using glm::dvec3;

constexpr double kUnit = 0x1p-53;

// Bound of a point's error after `steps` matrices of entries <= 1 and translations <= size. Each step sums four products, each factor and
// sum rounded once (at most 8 roundings), and keeps the length of the error before it.
double chainBound(size_t steps, double size) { return double(steps) * 8 * kUnit * 4 * size; }

double distance(const dvec3& a, const dvec3& b) { return glm::length(a - b); }

struct Lines {
    std::mt19937_64 engine{7};
    std::uniform_real_distribution<double> coordinate{-10, 10}, degrees{-360, 360};
    dvec3 point() { return {coordinate(engine), coordinate(engine), coordinate(engine)}; }
};

TEST(LineRotation, KeepsTheLineAndDistancesAndIsRodrigues) {
    Lines r;
    for (int i = 0; i < 1000; ++i) {
        const dvec3 from = r.point(), p = r.point();
        const double phi = r.degrees(r.engine);
        // Every eighth line is parallel to an axis, in both directions: X is the one that needs a case of its own.
        dvec3 way = r.point();
        if (i % 8 == 0) way = dvec3(0), way[i / 8 % 3] = i / 24 % 2 == 0 ? 3 : -3;
        const dvec3 to = from + way;
        ChainCounters counters;
        const std::vector<Step3> steps = lineSteps(from, to, phi);
        ASSERT_EQ(steps.size(), 7u);
        const dmat4 m = productsOf(std::span<const Step3>(steps), counters).back();
        const double bound = chainBound(7, 60);  // |coordinates| of everything that is added up
        EXPECT_LE(distance(transformed(m, from), from), bound);
        EXPECT_LE(distance(transformed(m, to), to), bound);
        EXPECT_LE(std::abs(distance(transformed(m, p), from) - distance(p, from)), bound);
        EXPECT_LE(distance(transformed(m, p), transformed(about(from, rotation(unitVector(to - from), phi)), p)), 2 * bound)
            << "line " << i;
        const std::vector<Step3> back = lineSteps(from, to, -phi);
        EXPECT_LE(distance(transformed(productsOf(std::span<const Step3>(back), counters).back(), transformed(m, p)), p), 2 * bound);
    }
}

TEST(LineRotation, LinesOfTinyAndHugeLengthHaveDirections) {
    for (double scale : {1e-300, 1e-23, 1.0, 1e23, 1e150}) {
        const auto angles = lineAngles(dvec3(0), dvec3(0, 3, 4) * scale);
        ASSERT_TRUE(angles) << scale;
        EXPECT_NEAR(angles->alpha.sine, 0.6, 4 * kUnit) << scale;
        EXPECT_NEAR(angles->alpha.cosine, 0.8, 4 * kUnit) << scale;
        EXPECT_EQ(angles->beta.sine, 0) << scale;
    }
}

TEST(LineRotation, TwoEqualPointsHaveNoLine) {
    EXPECT_FALSE(lineAngles(dvec3(1, 2, 3), dvec3(1, 2, 3)));
    EXPECT_FALSE(lineRotation(dvec3(1, 2, 3), dvec3(1, 2, 3), 30));
    EXPECT_TRUE(lineSteps(dvec3(1, 2, 3), dvec3(1, 2, 3), 30).empty());
}

TEST(Rotation, TurnsTheAxesAsTheNotesSay) {
    EXPECT_EQ(transformed(rotationZ(90), dvec3(1, 0, 0)), dvec3(0, 1, 0));
    EXPECT_EQ(transformed(rotationY(90), dvec3(0, 0, 1)), dvec3(1, 0, 0));
    EXPECT_EQ(transformed(rotationX(90), dvec3(0, 1, 0)), dvec3(0, 0, 1));
    EXPECT_EQ(transformed(rotation(90), dvec2(1, 0)), dvec2(0, 1));
    EXPECT_EQ(transformed(rotationZ(180), transformed(rotationZ(180), dvec3(0.1, 0.2, 0.3))), dvec3(0.1, 0.2, 0.3));
    for (int axis = 0; axis < 3; ++axis) {  // the axis coordinate is kept to the last bit
        const dmat4 m = axis == 0 ? rotationX(33) : axis == 1 ? rotationY(33) : rotationZ(33);
        EXPECT_EQ(transformed(m, dvec3(0.1, 0.2, 0.3))[axis], dvec3(0.1, 0.2, 0.3)[axis]);
        dvec3 unit(0);
        unit[axis] = 1;
        EXPECT_EQ(m, rotation(unit, 33)) << "Rodrigues about a coordinate axis";
    }
}

TEST(InPlace, TheReferencePointStays) {
    const dvec3 p(5, 3, 2);
    for (const dmat4& m : {rotationX(17), rotationY(-45), rotationZ(200), scaling(dvec3(2, 0.5, 3))})
        EXPECT_LE(distance(transformed(about(p, m), p), p), chainBound(3, 20));
    EXPECT_EQ(transformed(about(dvec2(3, 2), rotation(90)), dvec2(3, 2)), dvec2(3, 2));
}

TEST(VisualCentre, DoesNotOverflow) {
    const double big = 1.5e308;
    const std::vector<dvec3> same = {dvec3(big), dvec3(big)}, opposite = {dvec3(-big), dvec3(big)};
    EXPECT_EQ(visualCentre(std::span<const dvec3>(same)), dvec3(big));
    EXPECT_EQ(visualCentre(std::span<const dvec3>(opposite)), dvec3(0));
    // Centre of the box, not of the vertices.
    const std::vector<dvec2> triangle = {{2, 2}, {3, 3}, {4, 2}};
    EXPECT_EQ(visualCentre(std::span<const dvec2>(triangle)), dvec2(3, 2.5));
}

TEST(Inverse, UndoesAndIsRefusedForAScaleOfZero) {
    const dmat4 m = translation(dvec3(1, 2, 3)) * rotationX(30) * scaling(dvec3(2, 4, 0.5));
    const auto inverse = inverseOf(m);
    ASSERT_TRUE(inverse);
    EXPECT_LE(distance(transformed(*inverse, transformed(m, dvec3(7, -8, 9))), dvec3(7, -8, 9)), chainBound(8, 100));
    for (int axis = 0; axis < 3; ++axis) {
        dvec3 factors(1);
        factors[axis] = 0;
        EXPECT_FALSE(inverseOf(scaling(factors))) << axis;
        EXPECT_FALSE(hasInverse(scaling(factors))) << axis;
    }
    EXPECT_FALSE(inverseOf(scaling(dvec2(0, 1))));
    EXPECT_FALSE(inverseOf(scaling(dvec2(1, 0))));
    EXPECT_FALSE(inverseOf(dmat4(std::numeric_limits<double>::quiet_NaN())));
    const auto plane = inverseOf(about(dvec2(1, 2), scaling(dvec2(2, 4))));
    ASSERT_TRUE(plane);
    EXPECT_EQ(transformed(*plane, dvec2(3, 6)), dvec2(2, 3));
}

TEST(Notation, RowsTimesTheTransposeAreTheSamePoint) {
    const dmat4 m = translation(dvec3(1, 2, 3)) * rotationY(40);
    const glm::dvec4 p(0.5, -0.25, 8, 1);
    EXPECT_EQ(m * p, p * rowForm(m));
}

TEST(Handedness, ReversedZIsTheSameMotionSeenInTheOtherSystem) {
    const dmat4 m = translation(dvec3(1, 2, 3)) * rotationX(30) * rotationY(40);
    const dvec3 p(4, 5, 6), mirrored(4, 5, -6);
    const dvec3 q = transformed(m, p), r = transformed(withZReversed(m), mirrored);
    EXPECT_EQ(dvec3(q.x, q.y, -q.z), r);
    EXPECT_EQ(withZReversed(rotationZ(30)), rotationZ(30));
    EXPECT_EQ(withZReversed(rotationX(30)), rotationX(-30));
}

TEST(Chain, TheTreeHasTheSameProductAndTheDepthOfItsLogarithm) {
    Lines r;
    for (size_t n = 1; n <= 33; ++n) {
        std::vector<Step3> chain;
        for (size_t i = 0; i < n; ++i) chain.push_back(i % 2 == 0 ? rotateXStep(r.degrees(r.engine)) : translateStep(r.point() * 0.1));
        ChainCounters sequential, tree;
        const dmat4 m = productsOf(std::span<const Step3>(chain), sequential).back();
        const auto levels = treeOf(std::span<const Step3>(chain), tree);
        EXPECT_EQ(sequential.products, n - 1);
        EXPECT_EQ(tree.products, n - 1);
        size_t depth = 0;
        while (size_t(1) << depth < n) ++depth;
        EXPECT_EQ(levels.size(), depth) << n << " steps";
        if (n == 1) continue;
        ASSERT_EQ(levels.back().size(), 1u);
        EXPECT_EQ(levels.back()[0].first, 0u);
        EXPECT_EQ(levels.back()[0].last, n - 1);
        const dvec3 p(1, -2, 3);
        EXPECT_LE(distance(transformed(m, p), transformed(levels.back()[0].matrix, p)), 2 * chainBound(n, 60)) << n << " steps";
        for (const auto& level : levels)  // neighbours, without gap or overlap
            for (size_t i = 0; i < level.size(); ++i) EXPECT_EQ(level[i].first, i == 0 ? 0 : level[i - 1].last + 1);
    }
}

TEST(Chain, OrderIsTheOrderOfApplication) {
    const std::vector<Step3> chain = {scaleStep(dvec3(2)), translateStep(dvec3(1, 0, 0))};
    ChainCounters counters;
    EXPECT_EQ(transformed(productsOf(std::span<const Step3>(chain), counters).back(), dvec3(1, 1, 1)), dvec3(3, 2, 2));
    EXPECT_EQ(chain[0].name, "S(2, 2, 2)");
    EXPECT_EQ(aboutSteps(dvec3(0, 1, 2), chain[0])[0].name, "T(0, -1, -2)");
}

TEST(Magnitude, SquaresNeitherOverflowNorVanish) {
    EXPECT_EQ(magnitude(dvec2(3, 4)), 5);
    EXPECT_EQ(magnitude(dvec3(0)), 0);
    EXPECT_EQ(magnitude(dvec2(3, 4) * 0x1p1000), 5 * 0x1p1000);
    EXPECT_EQ(magnitude(dvec2(3, 4) * 0x1p-1000), 5 * 0x1p-1000);
}

}  // namespace
}  // namespace plumb
