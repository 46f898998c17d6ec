// SPDX-License-Identifier: MIT
// RGB, hexadecimal codes, CMY, CMYK, and area lights as points.
#include "pipeline/scene/colour.h"
#include "pipeline/scene/area_light.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

namespace plumb {
namespace {

using glm::dvec3;

TEST(Colour, HexCodesComeBackAndNothingElseIsOne) {
    for (int i = 0; i < 256; ++i) {
        const Rgb8 rgb = {uint8_t(i), uint8_t(255 - i), uint8_t(i * 7)};
        const std::optional<Rgb8> back = rgbOfHex(hexOf(rgb));
        ASSERT_TRUE(back);
        EXPECT_EQ(*back, rgb);
    }
    EXPECT_EQ(rgbOfHex("#FfCc0a"), (Rgb8{255, 204, 10}));
    for (const char* bad : {"", "#", "ff0000", "#ff000", "#ff00000", "#gg0000", "#ff00 0", "#-10000"}) EXPECT_FALSE(rgbOfHex(bad)) << bad;
}

TEST(Colour, TheCodeOfIntensitiesIsClampedAtBothEnds) {  // erratum A14
    EXPECT_EQ(hexOf(dvec3(1.01, -0.01, 0.5)), "#ff0080") << "127.5 goes to the even 128";
    EXPECT_EQ(hexOf(dvec3(NAN, INFINITY, -INFINITY)), "#00ff00");
}

TEST(Colour, CmyIsWhatRgbLacks) {
    for (double r = 0; r <= 1; r += 0.125)
        for (double g = 0; g <= 1; g += 0.125)
            EXPECT_EQ(rgbFromCmy(cmyFromRgb(dvec3(r, g, 1 - r))), dvec3(r, g, 1 - r)) << "eighths are exact";
    EXPECT_EQ(mixed(rgbFromCmy(dvec3(1, 0, 0)), rgbFromCmy(dvec3(0, 0, 1))), dvec3(0, 1, 0)) << "cyan and yellow are green";
}

// R -> (1 - R - K) / (1 - K) -> (1 - C) (1 - K): a difference, a quotient, two differences and a product, each within u of 1 at most.
TEST(Colour, CmykTakesAllTheBlackThereIsAndComesBack) {
    constexpr double kBound = 5 * 0x1p-53;
    for (int r = 0; r < 32; ++r)
        for (int g = 0; g < 32; ++g)
            for (int b = 0; b < 32; ++b) {
                const dvec3 rgb = dvec3(r, g, b) / 31.0;
                const Cmyk ink = cmykFromRgb(rgb);
                EXPECT_EQ(std::min({ink.c, ink.m, ink.y}), 0) << "what the three have in common is black";
                const dvec3 back = rgbFromCmyk(ink);
                for (int i = 0; i < 3; ++i) EXPECT_LE(std::abs(back[i] - rgb[i]), kBound);
            }
    const Cmyk black = cmykFromRgb(dvec3(0));
    EXPECT_EQ(black.k, 1);
    EXPECT_EQ(black.c + black.m + black.y, 0) << "black is black ink alone";
}

TEST(Colour, EveryColourOfBytesComesBackFromCmyk) {
    for (int most = 0; most < 256; ++most)
        for (int less = 0; less <= most; ++less) {  // a channel's ink depends on it and on the largest alone
            const Rgb8 rgb = {uint8_t(most), uint8_t(less), uint8_t(most - less)};
            const Cmyk8 ink = cmykFromRgb(rgb);
            ASSERT_EQ(rgbFromCmyk(ink), rgb) << most << ' ' << less;
            ASSERT_EQ(ink.k, 255 - most);
            ASSERT_EQ(std::min({ink.c, ink.m, ink.y}), 0);
        }
    EXPECT_EQ(cmykFromRgb(Rgb8{200, 100, 50}).m, 128) << "127.5: halves go up";
}

AreaLight lampOf(uint32_t m, uint32_t n) {
    AreaLight area;
    area.corner = {1, 5, 2};
    area.u = {4, 0, 0};
    area.v = n > 1 ? dvec3(0, 0, 2) : dvec3(0);
    area.pointsU = m;
    area.pointsV = n;
    area.intensity = {6, 3, 1};
    area.attenuation = Attenuation::inverseSquare;
    return area;
}

TEST(AreaLight, PointsAreTheMiddlesOfEqualCells) {
    const std::vector<Light> points = pointsOf(lampOf(4, 2));
    ASSERT_EQ(points.size(), 8u);
    EXPECT_EQ(points[0].position, dvec3(1.5, 5, 2.5));
    EXPECT_EQ(points[1].position, dvec3(2.5, 5, 2.5)) << "along u first";
    EXPECT_EQ(points[7].position, dvec3(4.5, 5, 3.5));
    dvec3 mean(0);
    for (const Light& p : points) {
        EXPECT_FALSE(p.directional);
        EXPECT_EQ(p.attenuation, Attenuation::inverseSquare);
        EXPECT_EQ(p.intensity, glm::vec3(0.75f, 0.375f, 0.125f));
        mean += p.position / 8.0;
    }
    EXPECT_EQ(mean, dvec3(3, 5, 3)) << "the middle of the lamp";
    EXPECT_EQ(pointsOf(lampOf(1, 1))[0].position, dvec3(3, 5, 2)) << "one point is the middle";
}

// Each point's share is rounded once: off by at most u of itself, so their sum by u of the whole.
TEST(AreaLight, PointsShareTheIntensity) {
    for (uint32_t m : {1u, 3u, 7u, 64u}) {
        double sum = 0;
        for (const Light& p : pointsOf(lampOf(m, 5))) sum += double(p.intensity.x);
        EXPECT_LE(std::abs(sum - 6), 6 * 0x1p-24) << m;
    }
}

}  // namespace
}  // namespace plumb
