// SPDX-License-Identifier: MIT
// Gates say what they are, hold when they should, and point at the worst pixel.
#include "compare_pictures.h"
#include "host/error.h"
#include "pipeline/compare/gate.h"

#include <gtest/gtest.h>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace plumb {
namespace {

Picture dot(double code, uint32_t x = 2, uint32_t y = 1) {
    return coded(12, 11, 3, [=](uint32_t u, uint32_t v, uint32_t c) { return u == x && v == y && c == 1 ? code : 0.0; });
}

bool holds(const std::string& text, const Comparison& c) {
    const std::vector<Gate> gates = {parseGate(text)};
    const std::vector<GateResult> results = judge(gates, c);
    EXPECT_EQ(results.size(), 1u) << text;
    return results.at(0).held;
}

TEST(Gate, IsParsedAsDocumented) {
    const Gate g = parseGate(" normal.X.over( 4/255 ) <= 0.1 % ");
    EXPECT_EQ(g.layer, "normal.X");
    EXPECT_EQ(g.metric, Metric::over);
    EXPECT_EQ(g.level, 4 / 255.0);
    EXPECT_TRUE(g.share);
    EXPECT_EQ(g.limit, 0.1 / 100);
    EXPECT_FALSE(g.larger);
    EXPECT_FALSE(g.strict);
    EXPECT_TRUE(parseGate("ssim>0.9").larger);
    EXPECT_TRUE(parseGate("max<2/255").strict);
}

TEST(Gate, RefusesWhatHasNoMeaning) {
    for (const char* text : {"",           "max",       "max=2",         "max<=",       "max<=x",   "max<=-1",   "max<=1/0",
                             "max<=nan",   "max<=inf",  "max<=1e999",    "max<=2%",     "max>=2",   "ssim<=0.9", "psnr<=40",
                             "over<=3",    "over()<=3", "over(4/255<=3", "max(3)<=1",   "worst<=1", ".max<=1",   "max<=2/255 or so",
                             "max<=1/2/3", "<=3",       "max<==3",       "differing<=%"}) {
        try {
            parseGate(text);
            ADD_FAILURE() << "'" << text << "' is taken";
        } catch (const Error& e) {
            EXPECT_EQ(e.exit(), Exit::usage) << text;
            EXPECT_NE(std::string(e.what()).find("accepted"), std::string::npos) << text;
            EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << text;
        }
    }
}

TEST(Gate, HoldsUpToItsLimitAndNotBeyond) {
    const Comparison c = compare(dot(0), dot(2), {});
    EXPECT_TRUE(holds("max<=2/255", c));
    EXPECT_FALSE(holds("max<2/255", c));
    EXPECT_FALSE(holds("max<=1/255", c));
    EXPECT_TRUE(holds("over(2/255)<=0", c));
    EXPECT_FALSE(holds("over(1/255)<=0", c));
    EXPECT_TRUE(holds("over(1/255)<=1", c));
    EXPECT_TRUE(holds("over(1/255)<=1%", c)) << "one of 132 pixels";
    EXPECT_FALSE(holds("over(1/255)<=0.7%", c));
    EXPECT_TRUE(holds("differing<=1", c));
    EXPECT_FALSE(holds("differing<1", c));
    EXPECT_FALSE(holds("region<=0", c));
    for (const char* text : {"mean<=0", "rmse<=0", "flip<=0", "flip_max<=0", "deltae<=0", "deltae_max<=0", "psnr>=90", "ssim>=1"})
        EXPECT_FALSE(holds(text, c)) << text;
    for (const char* text : {"mean<=1", "rmse<=1", "flip<=1", "flip_max<=1", "deltae<=1", "deltae_max<=9", "psnr>=30", "ssim>=0.9"})
        EXPECT_TRUE(holds(text, c)) << text;
    EXPECT_TRUE(holds("psnr>=1000", compare(dot(5), dot(5), {}))) << "infinite when equal";
}

TEST(Gate, PointsAtTheWorstPixel) {
    const Comparison c = compare(dot(0), dot(200), {});
    for (const char* text : {"max<=0", "flip_max<=0", "deltae_max<=0", "differing<=0", "over(0)<=0", "region<=0"}) {
        const std::vector<Gate> gates = {parseGate(text)};
        const GateResult r = judge(gates, c).at(0);
        EXPECT_FALSE(r.held);
        ASSERT_TRUE(r.at) << text;
        EXPECT_EQ(r.at->x, 2u) << text;
        EXPECT_EQ(r.at->y, 1u) << text;
    }
}

TEST(Gate, IsOnThePlanesThatHaveTheMetric) {
    Picture a = dot(0), b = dot(2);
    Layer depth = plane(12, 11, std::vector<double>(132, 1.0)).layers[0];
    depth.name = "depth";
    a.layers.push_back(depth);
    depth.samples[7] = 3;
    b.layers.push_back(depth);
    const Comparison c = compare(a, b, {});
    const std::vector<Gate> all = {parseGate("max<=1")}, one = {parseGate("depth.max<=1")};
    EXPECT_EQ(judge(all, c).size(), 2u);
    ASSERT_EQ(judge(one, c).size(), 1u);
    EXPECT_FALSE(judge(one, c)[0].held);
    EXPECT_THROW(judge({parseGate("nothing.max<=1")}, c), Error);
    EXPECT_THROW(judge({parseGate("depth.ssim>=1")}, c), Error);
    EXPECT_THROW(judge({parseGate("ssim>=0.5")},
                       compare(coded(5, 5, 1, [](auto...) { return 0.0; }), coded(5, 5, 1, [](auto...) { return 0.0; }), {})),
                 Error)
        << "no window";
}

TEST(Gate, SpeaksOfNanOnlyWhenAsked) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const Comparison c = compare(plane(2, 1, {nan, 1}), plane(2, 1, {nan, 1}), {});
    EXPECT_FALSE(nanIsJudged({parseGate("max<=9")}, "array"));
    EXPECT_TRUE(nanIsJudged({parseGate("nan<=9")}, "array"));
    EXPECT_FALSE(nanIsJudged({parseGate("depth.nan<=9")}, "array"));
    EXPECT_TRUE(holds("nan<=1", c));
    EXPECT_FALSE(holds("nan<=0", c));
}

}  // namespace
}  // namespace plumb
