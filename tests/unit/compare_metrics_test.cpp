// SPDX-License-Identifier: MIT
// Each measure on pictures whose answer is known in closed form. tests/fault/compare_mutants.py shows that each of these can fail.
#include "compare_pictures.h"
#include "host/error.h"
#include "pipeline/compare/draw.h"
#include "pipeline/compare/metrics.h"

#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

namespace plumb {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
// Sums of at most 2^12 terms of size 1 in binary64, and a handful of elementary functions after them.
constexpr double kRounding = 4096 * std::numeric_limits<double>::epsilon();
// FLIP's features are a root of a difference of filtered lightness, whose rounding grows to its root.
const double kFeatureRounding = std::sqrt(kRounding);
// Colours pass through float32 before the perceptual measures: 2^-24 of 1, times the steepest slope of lightness (903.3 for L* near black) over the 100 of its range.
constexpr double kFloatColour = 0x1p-24 * 903.3;

Picture dotted(uint32_t width, uint32_t height, std::initializer_list<std::array<uint32_t, 3>> dots,
               double ground = 0) {  // x, y, code of red
    return coded(width, height, 3, [&](uint32_t x, uint32_t y, uint32_t c) {
        for (const auto& [u, v, code] : dots)
            if (x == u && y == v && c == 0) return double(code);
        return ground;
    });
}

TEST(CompareNorms, AreThoseOfOneChannelInTwelve) {
    const LayerDifference d = only(dotted(4, 3, {}), dotted(4, 3, {{2, 1, 51}}));
    const double e = 51 / 255.0;
    EXPECT_EQ(d.max, e);
    EXPECT_EQ(d.mean, e / 36) << "4x3 pixels of three channels";
    EXPECT_EQ(d.rmse, std::sqrt(e * e / 36));
    EXPECT_EQ(d.psnr, 10 * std::log10(36 / (e * e)));
    EXPECT_EQ(d.differing, 1u);
    EXPECT_EQ(d.maxAt.x, 2u);
    EXPECT_EQ(d.maxAt.y, 1u);
    EXPECT_EQ(d.maxChannel, 0u);
    EXPECT_EQ(d.valueA, 0);
    EXPECT_EQ(d.valueB, 51);
    EXPECT_FALSE(d.ulp) << "codes have no ULP";
}

TEST(CompareNorms, EqualPicturesDifferInNothing) {
    const Picture p = coded(16, 12, 3, [](uint32_t x, uint32_t y, uint32_t c) { return double((x * 31 + y * 17 + c * 7) % 256); });
    const Comparison c = compare(p, p, {});
    EXPECT_TRUE(c.equal());
    const LayerDifference& d = c.layers[0];
    EXPECT_EQ(d.max, 0);
    EXPECT_EQ(d.mean, 0);
    EXPECT_EQ(d.rmse, 0);
    EXPECT_EQ(d.psnr, kInf);
    EXPECT_EQ(d.differing, 0u);
    EXPECT_EQ(d.region.pixels, 0u);
    EXPECT_NEAR(d.ssim->mean, 1, kRounding);
    EXPECT_EQ(d.flip->mean, 0);
    EXPECT_EQ(d.deltaE->mean, 0);
}

TEST(CompareNorms, CountPixelsOverEachLevel) {
    const LayerDifference d =
        only(dotted(8, 1, {}), dotted(8, 1, {{0, 0, 1}, {1, 0, 2}, {2, 0, 3}, {3, 0, 4}, {4, 0, 5}, {5, 0, 8}, {6, 0, 9}}));
    EXPECT_EQ(d.over, (std::array<uint64_t, 4>{6, 5, 3, 1})) << "over 1, 2, 4 and 8 of 255; exactly that many levels is not over";
    EXPECT_EQ(d.max, 9 / 255.0);
    EXPECT_EQ(d.maxAt.x, 6u);
}

TEST(CompareNorms, EightAndSixteenBitsAreTheSameScale) {
    const Picture a = coded(3, 2, 3, [](uint32_t x, uint32_t y, uint32_t c) { return double(40 * x + 20 * y + c); });
    Picture b = a;
    b.layers[0].fullScale = 65535;
    for (double& s : b.layers[0].samples) s *= 257;
    EXPECT_TRUE(compare(a, b, {}).equal());
    b.layers[0].samples[4] += 1;
    const LayerDifference d = only(a, b);
    EXPECT_EQ(d.max, 1 / 65535.0);
    EXPECT_EQ(d.over[0], 0u);
}

TEST(CompareNorms, GreyIsRgbAndMissingAlphaIsOpaque) {
    const auto ramp = [](uint32_t x, uint32_t, uint32_t) { return 10.0 * x; };
    const Picture grey = coded(5, 4, 1, ramp), rgb = coded(5, 4, 3, ramp);
    const Picture rgba = coded(5, 4, 4, [](uint32_t x, uint32_t, uint32_t c) { return c == 3 ? 255.0 : 10.0 * x; });
    EXPECT_TRUE(compare(grey, rgb, {}).equal());
    EXPECT_TRUE(compare(rgba, grey, {}).equal());
    Picture clear = rgba;
    clear.layers[0].samples[3] = 0;
    EXPECT_EQ(only(clear, rgb).max, 1);
}

TEST(CompareNorms, ConnectTheRegionBySidesAndCorners) {
    //  # . . # #
    //  . # . . #      three pixels at the left, four at the right
    //  . . # . #      the diagonal is one region
    const LayerDifference d =
        only(dotted(6, 3, {}), dotted(6, 3, {{0, 0, 9}, {1, 1, 9}, {2, 2, 9}, {4, 0, 9}, {5, 0, 9}, {5, 1, 9}, {5, 2, 9}}));
    EXPECT_EQ(d.differing, 7u);
    EXPECT_EQ(d.region.pixels, 4u);
    EXPECT_EQ(d.region.least.x, 4u);
    EXPECT_EQ(d.region.most.y, 2u);
    EXPECT_EQ(largestRegion({1, 0, 0, 0, 1, 0, 0, 0, 1}, 3, 3).pixels, 3u) << "a diagonal";
    EXPECT_EQ(largestRegion(std::vector<uint8_t>(300 * 200, 1), 300, 200).pixels, 60000u);
}

TEST(CompareRadius, FindsAShiftedPictureAndNothingMore) {
    const auto bar = [](uint32_t shift) {
        return coded(24, 12, 3, [=](uint32_t x, uint32_t, uint32_t) { return x + shift >= 10 && x + shift < 14 ? 200.0 : 0.0; });
    };
    CompareOptions options;
    EXPECT_GT(only(bar(0), bar(2), options).differing, 0u);
    options.radius = 1;
    EXPECT_GT(only(bar(0), bar(2), options).differing, 0u);
    options.radius = 2;
    const LayerDifference d = only(bar(0), bar(2), options);
    EXPECT_EQ(d.differing, 0u);
    EXPECT_EQ(d.max, 0);
    EXPECT_EQ(d.psnr, kInf);
}

TEST(CompareRadius, ALineThatOneSideLacksIsSeenFromEitherSide) {
    const Picture ground = dotted(9, 9, {}), dot = dotted(9, 9, {{4, 4, 255}});
    CompareOptions options;
    options.radius = 3;
    EXPECT_EQ(only(ground, dot, options).differing, 1u) << "every pixel of the ground has a match, the dot has none";
    EXPECT_EQ(only(dot, ground, options).differing, 1u);
    EXPECT_EQ(only(dot, ground, options).max, 1);
}

TEST(CompareNan, IsNamedAndKeptOutOfNorms) {
    const Picture a = plane(3, 2, {1, kNan, 2, 3, 4, kNan}), b = plane(3, 2, {1, 7, 2, 3, 6, kNan});
    const Comparison c = compare(a, b, {});
    const LayerDifference& d = c.layers[0];
    EXPECT_FALSE(c.equal());
    EXPECT_EQ(d.nanA.pixels, 2u);
    EXPECT_EQ(d.nanA.first.x, 1u);
    EXPECT_EQ(d.nanB.pixels, 1u);
    EXPECT_EQ(d.nanB.first.y, 1u);
    EXPECT_EQ(d.compared, 4u);
    EXPECT_EQ(d.differing, 2u) << "a NaN on one side, and 4 against 6";
    EXPECT_EQ(d.max, 2);
    EXPECT_EQ(d.mean, 0.5);
    EXPECT_FALSE(compare(a, a, {}).equal()) << "a NaN is never equal";
    EXPECT_FALSE(only(plane(1, 1, {kNan}), plane(1, 1, {0})).max) << "there is no norm of nothing";
}

TEST(CompareInfinity, IsEqualToItselfOnly) {
    EXPECT_TRUE(compare(plane(2, 1, {kInf, 1}), plane(2, 1, {kInf, 1}), {}).equal());
    const LayerDifference same = only(plane(2, 1, {kInf, 1}), plane(2, 1, {kInf, 1}));
    EXPECT_EQ(same.compared, 2u) << "it is no NaN";
    EXPECT_EQ(same.max, 0);
    const LayerDifference d = only(plane(2, 1, {kInf, 1}), plane(2, 1, {9, 1}));
    EXPECT_EQ(d.max, kInf);
    EXPECT_EQ(d.differing, 1u);
    EXPECT_EQ(only(plane(1, 1, {kInf}), plane(1, 1, {-kInf})).max, kInf);
}

TEST(CompareUlp, CountsRepresentableNumbers) {
    EXPECT_EQ(ulpDistance(1.0, double(std::nextafter(1.0f, 2.0f)), 32), 1);
    EXPECT_EQ(ulpDistance(0.0, -0.0, 32), 0);
    EXPECT_EQ(ulpDistance(double(std::numeric_limits<float>::denorm_min()), -double(std::numeric_limits<float>::denorm_min()), 32), 2)
        << "across both zeros, which are one";
    EXPECT_EQ(ulpDistance(1.0, 2.0, 32), 0x1p23);
    EXPECT_EQ(ulpDistance(1.0, 2.0, 64), 0x1p52);
    EXPECT_EQ(ulpDistance(1.0, 2.0, 16), 0x1p10);
    EXPECT_EQ(ulpDistance(kInf, double(std::numeric_limits<float>::max()), 32), 1);
    EXPECT_EQ(ulpDistance(1.0, std::nextafter(1.0, 2.0), 64), 1);
    const LayerDifference d =
        only(plane(2, 2, {1, 2, 3, 4}), plane(2, 2, {1, 2, double(std::nextafter(std::nextafter(3.0f, 4.0f), 4.0f)), 4}));
    EXPECT_EQ(d.ulp, 2);
    EXPECT_EQ(d.ulpAt.y, 1u);
    EXPECT_EQ(d.ulpPrecision, 32);
}

TEST(CompareIds, AreEqualOrNot) {
    const LayerDifference d = only(plane(2, 1, {7, 4294967295.0}, 32, LayerKind::id), plane(2, 1, {7, 3}, 32, LayerKind::id));
    EXPECT_EQ(d.differing, 1u);
    EXPECT_EQ(d.firstDiffering->x, 1u);
    EXPECT_FALSE(d.max) << "a distance of names means nothing";
}

// Without variance SSIM is the comparison of means alone, whatever the windows.
TEST(CompareSsim, OfUniformPicturesIsThatOfTheirMeans) {
    const double a = 40 / 255.0, b = 90 / 255.0, c1 = 0.01 * 0.01;
    const LayerDifference d = only(uniform(17, 13, {40, 40, 40}), uniform(17, 13, {90, 90, 90}));
    EXPECT_NEAR(d.ssim->mean, (2 * a * b + c1) / (a * a + b * b + c1), kFloatColour);
    EXPECT_FALSE(only(uniform(10, 40, {1, 2, 3}), uniform(10, 40, {1, 2, 4})).ssim) << "no window of 11x11";
}

TEST(CompareSsim, OfOneWindowIsItsFormula) {
    // 11x11: one window. A is a dot of 1 in the middle of 0, B its negative, whose covariance is minus A's variance.
    const auto dot = [](bool negative) {
        return coded(11, 11, 1, [=](uint32_t x, uint32_t y, uint32_t) { return ((x == 5 && y == 5) != negative) ? 255.0 : 0.0; });
    };
    double sum = 0;
    for (int i = -5; i <= 5; ++i) sum += std::exp(-i * i / 4.5);
    const double w = 1 / (sum * sum), variance = w - w * w, c1 = 1e-4, c2 = 9e-4;
    const double want = (2 * w * (1 - w) + c1) * (-2 * variance + c2) / ((w * w + (1 - w) * (1 - w) + c1) * (2 * variance + c2));
    EXPECT_NEAR(only(dot(false), dot(true)).ssim->mean, want, kRounding);
}

// The largest difference of FLIP's colours is that of green and blue, by construction 1; features are none in a uniform picture.
TEST(CompareFlip, OfGreenAndBlueIsOne) {
    const LayerDifference d = only(uniform(40, 30, {0, 255, 0}), uniform(40, 30, {0, 0, 255}));
    EXPECT_NEAR(d.flip->mean, 1, kRounding);
    EXPECT_NEAR(d.flip->worst, 1, kRounding);
    EXPECT_EQ(d.flipMap.size(), 1200u);
}

TEST(CompareFlip, OfBlackAndWhiteIsItsFormula) {
    // Lightness differs by 100 and chroma by nothing. Green and blue in Hunt-adjusted L*a*b*, worked out here from their XYZ over the white.
    const auto f = [](long double t) { return std::cbrt(t); };
    const long double xg = 8788810.0L / 24577794, xb = 4435075.0L / 24577794, xw = (10135552.0L + 8788810 + 4435075) / 24577794;
    const long double yg = 8788810.0L / 12288897, yb = 887015.0L / 12288897, zg = 8788810.0L / 73733382, zb = 70074185.0L / 73733382;
    const long double zw = (1425312.0L + 8788810 + 70074185) / 73733382;
    const long double lg = 116 * f(yg) - 16, lb = 116 * f(yb) - 16;
    const long double ag = lg * 5 * (f(xg / xw) - f(yg)), bg = lg * 2 * (f(yg) - f(zg / zw)), ab = lb * 5 * (f(xb / xw) - f(yb)),
                      bb = lb * 2 * (f(yb) - f(zb / zw));
    const long double most = std::pow(lg - lb + std::hypot(ag - ab, bg - bb), 0.7L), knee = 0.4L * most;
    const long double want = 0.95L + (std::pow(100.0L, 0.7L) - knee) / (most - knee) * 0.05L;
    EXPECT_NEAR(only(uniform(24, 24, {0, 0, 0}), uniform(24, 24, {255, 255, 255})).flip->mean, double(want), kFeatureRounding);
}

TEST(CompareFlip, AMissingDotCountsMoreThanItsColour) {
    // At few pixels a degree filters are short; the dot is a feature, so that FLIP is over the difference of the filtered colours alone.
    CompareOptions options;
    options.pixelsPerDegree = 20;
    const LayerDifference dot = only(dotted(33, 33, {}), dotted(33, 33, {{16, 16, 255}}), options);
    EXPECT_GT(dot.flip->worst, 0.1);
    EXPECT_EQ(dot.flip->at.x, 16u);
    EXPECT_EQ(dot.flip->at.y, 16u);
    EXPECT_EQ(dot.flipMap[0], 0) << "nothing differs within the reach of the filters";
}

TEST(CompareFlip, TheBorderIsRepeatedAndNotWrapped) {
    const LayerDifference d = only(dotted(64, 64, {}), dotted(64, 64, {{0, 0, 255}}));
    EXPECT_GT(d.flipMap[0], 0);
    EXPECT_EQ(d.flipMap[63], 0);
    EXPECT_EQ(d.flipMap[63 * 64], 0);
}

struct Pair {
    Lab a, b;
    double difference;
};
// Table 1 of Sharma, Wu, Dalal 2005, four digits.
constexpr Pair kPairs[] = {
    {{50.0, 2.6772, -79.7751}, {50.0, 0.0, -82.7485}, 2.0425},
    {{50.0, 3.1571, -77.2803}, {50.0, 0.0, -82.7485}, 2.8615},
    {{50.0, 2.8361, -74.02}, {50.0, 0.0, -82.7485}, 3.4412},
    {{50.0, -1.3802, -84.2814}, {50.0, 0.0, -82.7485}, 1.0},
    {{50.0, -1.1848, -84.8006}, {50.0, 0.0, -82.7485}, 1.0},
    {{50.0, -0.9009, -85.5211}, {50.0, 0.0, -82.7485}, 1.0},
    {{50.0, 0.0, 0.0}, {50.0, -1.0, 2.0}, 2.3669},
    {{50.0, -1.0, 2.0}, {50.0, 0.0, 0.0}, 2.3669},
    {{50.0, 2.49, -0.001}, {50.0, -2.49, 0.0009}, 7.1792},
    {{50.0, 2.49, -0.001}, {50.0, -2.49, 0.001}, 7.1792},
    {{50.0, 2.49, -0.001}, {50.0, -2.49, 0.0011}, 7.2195},
    {{50.0, 2.49, -0.001}, {50.0, -2.49, 0.0012}, 7.2195},
    {{50.0, -0.001, 2.49}, {50.0, 0.0009, -2.49}, 4.8045},
    {{50.0, -0.001, 2.49}, {50.0, 0.001, -2.49}, 4.8045},
    {{50.0, -0.001, 2.49}, {50.0, 0.0011, -2.49}, 4.7461},
    {{50.0, 2.5, 0.0}, {50.0, 0.0, -2.5}, 4.3065},
    {{50.0, 2.5, 0.0}, {73.0, 25.0, -18.0}, 27.1492},
    {{50.0, 2.5, 0.0}, {61.0, -5.0, 29.0}, 22.8977},
    {{50.0, 2.5, 0.0}, {56.0, -27.0, -3.0}, 31.903},
    {{50.0, 2.5, 0.0}, {58.0, 24.0, 15.0}, 19.4535},
    {{50.0, 2.5, 0.0}, {50.0, 3.1736, 0.5854}, 1.0},
    {{50.0, 2.5, 0.0}, {50.0, 3.2972, 0.0}, 1.0},
    {{50.0, 2.5, 0.0}, {50.0, 1.8634, 0.5757}, 1.0},
    {{50.0, 2.5, 0.0}, {50.0, 3.2592, 0.335}, 1.0},
    {{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
    {{63.0109, -31.0961, -5.8663}, {62.8187, -29.7946, -4.0864}, 1.263},
    {{61.2901, 3.7196, -5.3901}, {61.4292, 2.248, -4.962}, 1.8731},
    {{35.0831, -44.1164, 3.7933}, {35.0232, -40.0716, 1.5901}, 1.8645},
    {{22.7233, 20.0904, -46.694}, {23.0331, 14.973, -42.5619}, 2.0373},
    {{36.4612, 47.858, 18.3852}, {36.2715, 50.5065, 21.2231}, 1.4146},
    {{90.8027, -2.0831, 1.441}, {91.1528, -1.6435, 0.0447}, 1.4441},
    {{90.9257, -0.5406, -0.9208}, {88.6381, -0.8985, -0.7239}, 1.5381},
    {{6.7747, -0.2908, -2.4247}, {5.8714, -0.0985, -2.2286}, 0.6377},
    {{2.0776, 0.0795, -1.135}, {0.9033, -0.0636, -0.5514}, 0.9082},
};
constexpr double kTableRounding = 0.5e-4 + 1e-12;  // half a unit of the last digit printed

TEST(CompareDeltaE, AgreesWithThePublishedTable) {
    EXPECT_EQ(std::size(kPairs), 34u);
    for (const Pair& pair : kPairs) {
        EXPECT_NEAR(ciede2000(pair.a, pair.b), pair.difference, kTableRounding);
        EXPECT_NEAR(ciede2000(pair.b, pair.a), pair.difference, kTableRounding) << "it is symmetric";
    }
}

TEST(CompareDeltaE, OfPicturesIsTheMeanOfPixels) {
    // White and black: lightness 100 apart around 50, S_L = 1.
    const Picture a = uniform(4, 2, {0, 0, 0});
    const Picture b = coded(4, 2, 3, [](uint32_t x, uint32_t, uint32_t) { return x == 3 ? 255.0 : 0.0; });
    const LayerDifference d = only(a, b);
    EXPECT_NEAR(d.deltaE->worst, 100, kFloatColour);
    EXPECT_NEAR(d.deltaE->mean, 25, kFloatColour);
    EXPECT_EQ(d.deltaE->at.x, 3u);
}

TEST(CompareAlpha, IsSeenOnTheWorseOfBlackAndWhite) {
    const auto with = [](double grey, double alpha) {
        return coded(12, 12, 4, [=](uint32_t, uint32_t, uint32_t c) { return c == 3 ? alpha : grey; });
    };
    EXPECT_EQ(only(with(0, 0), with(255, 0)).flip->mean, 0) << "what cannot be seen has no perceived difference";
    EXPECT_EQ(only(with(0, 0), with(255, 0)).max, 1) << "and its samples differ";
    EXPECT_GT(only(with(0, 0), with(0, 255)).flip->mean, 0.9) << "black against clear shows on white only";
    EXPECT_GT(only(with(255, 0), with(255, 255)).flip->mean, 0.9) << "white against clear shows on black only";
}

TEST(ComparePictures, AnotherSizeIsADifferenceAndNeverResized) {
    const Comparison c = compare(uniform(4, 4, {1, 2, 3}), uniform(4, 5, {1, 2, 3}), {});
    EXPECT_FALSE(c.sameSize);
    EXPECT_FALSE(c.equal());
    EXPECT_TRUE(c.layers.empty());
    EXPECT_EQ(c.sizeDifference, "4x4 against 4x5");
}

TEST(ComparePictures, AMissingPlaneIsADifference) {
    Picture a = plane(2, 2, {1, 2, 3, 4}), b = a;
    b.layers.push_back(b.layers[0]);
    b.layers[1].name = "depth";
    EXPECT_FALSE(compare(a, b, {}).equal());
    EXPECT_EQ(compare(a, b, {}).onlyB, std::vector<std::string>{"depth"});
    CompareOptions options;
    options.layers = {"array"};
    EXPECT_TRUE(compare(a, b, options).equal());
    options.layers = {"nothing"};
    EXPECT_THROW(compare(a, b, options), Error);
    EXPECT_THROW(compare(a, uniform(2, 2, {0, 0, 0}), {}).equal() ? 0 : throw renderError("planes differ by name"), Error);
}

TEST(ComparePictures, ThreadsChangeNoBit) {
    const auto wild = [](uint32_t seed) {
        return coded(70, 90, 3, [=](uint32_t x, uint32_t y, uint32_t c) {
            return double(((x * 2654435761u + seed) ^ (y * 40503u + c * 97u)) >> 7 & 255u);
        });
    };
    CompareOptions one, four;
    one.threads = 1;
    four.threads = 4;
    const LayerDifference p = only(wild(1), wild(2), one), q = only(wild(1), wild(2), four);
    EXPECT_EQ(p.mean, q.mean);
    EXPECT_EQ(p.rmse, q.rmse);
    EXPECT_EQ(p.ssim->mean, q.ssim->mean);
    EXPECT_EQ(p.flip->mean, q.flip->mean);
    EXPECT_EQ(p.flipMap, q.flipMap);
    EXPECT_EQ(p.deltaE->mean, q.deltaE->mean);
}

TEST(CompareDrawing, ShowsEachChannelTimesAPowerOfTwo) {
    const Picture a = dotted(3, 1, {}), b = dotted(3, 1, {{0, 0, 3}, {1, 0, 1}});
    const DifferencePicture d = drawDifference(a, b, only(a, b));
    EXPECT_EQ(d.exponent, 6) << "3 * 64 = 192, 3 * 128 is over 255";
    EXPECT_EQ(d.frame.rgba, (std::vector<uint32_t>{0xff0000c0u, 0xff000040u, 0xff000000u}));
    const Picture white = uniform(3, 1, {255, 255, 255});
    EXPECT_EQ(drawDifference(a, white, only(a, white)).exponent, 0);
    EXPECT_EQ(drawDifference(a, a, only(a, a)).frame.rgba, std::vector<uint32_t>(3, 0xff000000u));
}

TEST(CompareDrawing, HeatIsDarkAtZeroAndBrightAtTheTop) {
    const LayerDifference d = only(uniform(4, 4, {0, 255, 0}), uniform(4, 4, {0, 0, 255}));
    EXPECT_EQ(drawHeat(d, 4, 4).frame.rgba[0], 0xffbffdfcu);
    const LayerDifference same = only(uniform(4, 4, {9, 9, 9}), uniform(4, 4, {9, 9, 9}));
    EXPECT_EQ(drawHeat(same, 4, 4).frame.rgba[0], 0xff040000u);
    const LayerDifference depth = only(plane(3, 1, {1, 2, kNan}), plane(3, 1, {1, 4, 0}));
    const HeatPicture heat = drawHeat(depth, 3, 1);
    EXPECT_EQ(heat.brightest, 2);
    EXPECT_EQ(heat.frame.rgba, (std::vector<uint32_t>{0xff040000u, 0xffbffdfcu, 0xffff00ffu})) << "NaN is magenta";
}

}  // namespace
}  // namespace plumb
