// SPDX-License-Identifier: MIT
#include "pipeline/scene/flattened.h"

#include "pipeline/transform/matrix.h"

#include <gtest/gtest.h>
#include <cstdint>
#include <glm/glm.hpp>
#include <random>

namespace plumb {
namespace {

using glm::dmat4;
using glm::dvec3;

TEST(Flattened, AScaleOfZeroTurnsNothingAndANegativeOneDoes) {
    std::mt19937 engine(7);
    std::uniform_real_distribution<double> degrees(-180, 180), size(0.01, 100);
    const auto turned = [&] { return rotationX(degrees(engine)) * rotationY(degrees(engine)) * rotationZ(degrees(engine)); };
    const auto scaled = [](double x, double y, double z) { return dmat4(x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1); };
    int negative = 0;
    for (int i = 0; i < 20000; ++i) {
        const double x = size(engine), z = size(engine);
        const dmat4 before = turned(), after = turned(), flat = after * scaled(x, 0, z) * before;
        negative += glm::determinant(glm::dmat3(flat)) < 0;
        EXPECT_FALSE(mirrors(flat));
        EXPECT_FALSE(mirrors(after * scaled(x, 0.001, z) * before));
        EXPECT_TRUE(mirrors(after * scaled(x, -0.001, z) * before));
        // Before or after all rotations a factor may be as small as it likes.
        EXPECT_TRUE(mirrors(scaled(x, -1e-20, z) * before));
        EXPECT_TRUE(mirrors(after * scaled(x, -1e-20, z)));
    }
    EXPECT_GT(negative, 1000) << "rounding has either sign";
}

TEST(Flattened, WhatHasNoAreaIsFound) {
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 0, 2}, {0, 1, 0}};
    mesh.triangles = {{{0, 1, 2}, 0}};
    const auto scaled = [](double x, double y, double z) {
        return rotationX(33) * dmat4(x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1) * rotationY(12);
    };
    EXPECT_FALSE(leavesNoArea(mesh, scaled(1, 0, 1))) << "the triangle lies in the plane that is left";
    EXPECT_TRUE(leavesNoArea(mesh, scaled(1, 1, 0) * rotationY(-12)));
    EXPECT_TRUE(leavesNoArea(mesh, scaled(1, 0, 0)));
    EXPECT_TRUE(leavesNoArea(mesh, scaled(0, 0, 0)));
    EXPECT_FALSE(leavesNoArea(mesh, scaled(1e-20, 1e-20, 1e-20))) << "small is not flat";
    mesh.triangles.push_back({{0, 2, 3}, 1});
    EXPECT_FALSE(leavesNoArea(mesh, scaled(0, 1, 1) * rotationY(-12)));
}

}  // namespace
}  // namespace plumb
