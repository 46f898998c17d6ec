// SPDX-License-Identifier: MIT
// Errors are held against their bounds figure by figure and pixel by pixel, and a bound that is too small is told with its place.
#include "pipeline/measure/error_bound.h"
#include "tests/support/scenes.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <optional>
#include <vector>

namespace plumb {
namespace {

constexpr uint32_t kWidth = 40, kHeight = 30;
constexpr size_t kPixels = size_t(kWidth) * kHeight;

// A truth, a default picture near it, and one whose choice moved each colour by as much as `brighter` and `darker` allow.
struct Case {
    Truth truth;
    Frame base, moved;
    glm::dvec3 brighter{0.03, 0.1, 0.002}, darker{0.05, 0, 0.2};
    ColourMoves moves() const { return {brighter, darker}; }
    FrameError error(bool transparent = false) const { return errorOf(moved, truth, Encoding::srgb, transparent); }
};

void encode(Frame& frame) {
    frame.rgba.assign(kPixels, 0xff000000u);
    for (size_t at = 0; at < kPixels; ++at)
        for (size_t c = 0; c < 3; ++c) frame.rgba[at] |= uint32_t(std::lround(srgbCode(frame.linear[3 * at + c]))) << (8 * c);
}

Case caseOf(uint32_t seed, double most = 1.2) {
    test::Random random(seed);
    Case k;
    k.truth.width = k.base.width = kWidth;
    k.truth.height = k.base.height = kHeight;
    k.base.depth.assign(kPixels, 1.0f);
    k.base.primitive.assign(kPixels, 0);
    k.truth.alpha.assign(kPixels, 1.0);
    k.truth.depth.assign(kPixels, 1.0);
    for (size_t at = 0; at < kPixels; ++at) {
        const bool nothing = random.below(4) == 0;
        k.base.object.push_back(nothing ? kNone : 0);
        if (nothing) k.truth.alpha[at] = 0;
    }
    k.truth.object = k.base.object;
    k.truth.primitive.assign(kPixels, 0);
    for (size_t i = 0; i < 3 * kPixels; ++i) {
        k.truth.linear.push_back(random(0, most));
        k.base.linear.push_back(float(std::max(0.0, k.truth.linear[i] + random(-0.02, 0.02))));
    }
    k.moved = k.base;
    for (size_t i = 0; i < 3 * kPixels; ++i) {
        const auto c = glm::length_t(i % 3);
        const bool up = random.below(2) == 0;
        const double value = double(k.base.linear[i]), end = up ? value + k.brighter[c] : value - k.darker[c];
        k.moved.linear[i] = float(end);
        // float32 rounds the end; the moved colour stays within it.
        if (up ? double(k.moved.linear[i]) > end : double(k.moved.linear[i]) < end)
            k.moved.linear[i] = std::nextafter(k.moved.linear[i], k.base.linear[i]);
    }
    encode(k.base);
    encode(k.moved);
    return k;
}

TEST(ErrorBound, HoldsForAllThatAChoiceMayDoAndIsReached) {
    for (uint32_t seed = 1; seed <= 40; ++seed) {
        const Case k = caseOf(seed);
        const ErrorBound bound = errorBoundOf(k.base, k.truth, false, k.moves(), 0);
        const FrameError error = k.error();
        EXPECT_FALSE(breachOf(error, bound, kWidth)) << seed;
        EXPECT_FALSE(breachOfMoves(k.base, k.moved, k.moves())) << seed;
        EXPECT_LE(error.picture.max, bound.max);
        EXPECT_LE(error.picture.rms, bound.rms);
        EXPECT_EQ(bound.brighter, std::max({k.brighter.x, k.brighter.y, k.brighter.z}));
        EXPECT_EQ(bound.darker, std::max({k.darker.x, k.darker.y, k.darker.z}));
        EXPECT_EQ(bound.why(), "");
        // Half of the pixels go the way that is worse for them, and rounding to bytes is half a step.
        EXPECT_GT(error.picture.max, 0.9 * bound.max);
        EXPECT_GT(error.picture.rms, bound.rms / 2);
    }
}

TEST(ErrorBound, ThatIsTooSmallIsToldWithItsPlace) {
    const Case k = caseOf(7);
    const FrameError error = k.error();
    const ErrorBound whole = errorBoundOf(k.base, k.truth, false, k.moves(), 0);
    // Each part of it left out.
    Case less = k;
    less.brighter = glm::dvec3(0);
    const std::optional<BoundBreach> dark = breachOf(error, errorBoundOf(k.base, k.truth, false, less.moves(), 0), kWidth);
    ASSERT_TRUE(dark);
    EXPECT_GT(dark->error, dark->bound);
    const size_t at = size_t(dark->y) * kWidth + dark->x;
    EXPECT_NEAR(dark->error, 255 * double(error.perPixel[at]), 1e-4);
    EXPECT_TRUE(breachOfMoves(k.base, k.moved, less.moves()));
    less = k;
    less.darker *= 0.9;
    EXPECT_TRUE(breachOf(error, errorBoundOf(k.base, k.truth, false, less.moves(), 0), kWidth));
    const std::optional<BoundBreach> change = breachOfMoves(k.base, k.moved, less.moves());
    ASSERT_TRUE(change);
    EXPECT_EQ(change->figure, "linear");
    EXPECT_NEAR(change->error, 0.2, 1e-7);
    EXPECT_NEAR(change->bound, 0.18, 1e-7);
    // One pixel alone.
    ErrorBound pixel = whole;
    const auto most = size_t(std::max_element(error.perPixel.begin(), error.perPixel.end()) - error.perPixel.begin());
    pixel.perPixel[most] = 255 * double(error.perPixel[most]) * (1 - 0x1p-20);
    const std::optional<BoundBreach> one = breachOf(error, pixel, kWidth);
    ASSERT_TRUE(one);
    EXPECT_EQ(size_t(one->y) * kWidth + one->x, most);
    // Each figure alone.
    for (double ErrorBound::*figure : {&ErrorBound::max, &ErrorBound::p99, &ErrorBound::mean, &ErrorBound::rms}) {
        ErrorBound small = whole;
        small.*figure = 0.1;
        const std::optional<BoundBreach> found = breachOf(error, small, kWidth);
        ASSERT_TRUE(found);
        EXPECT_EQ(found->bound, 0.1);
        EXPECT_GT(found->error, 0.1);
    }
}

TEST(ErrorBound, TellsWhatIsNotANumberFirst) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const Case k = caseOf(9);
    FrameError error = k.error();
    ErrorBound bound = errorBoundOf(k.base, k.truth, false, {glm::dvec3(0), glm::dvec3(0)}, 0);
    ASSERT_TRUE(breachOf(error, bound, kWidth)) << "too small everywhere";
    bound.perPixel[333] = nan;
    std::optional<BoundBreach> breach = breachOf(error, bound, kWidth);
    ASSERT_TRUE(breach);
    EXPECT_EQ(breach->y * kWidth + breach->x, 333u);
    bound.perPixel[333] = 300;
    error.perPixel[444] = std::nanf("");
    breach = breachOf(error, bound, kWidth);
    ASSERT_TRUE(breach);
    EXPECT_EQ(breach->y * kWidth + breach->x, 444u);
    error.perPixel[444] = 0;
    bound.rms = nan;
    breach = breachOf(error, bound, kWidth);
    ASSERT_TRUE(breach);
    EXPECT_EQ(breach->figure, "rms");
    Case broken = k;
    broken.moved.linear[3 * 555 + 1] = std::nanf("");
    breach = breachOfMoves(k.base, broken.moved, k.moves());
    ASSERT_TRUE(breach);
    EXPECT_EQ(breach->y * kWidth + breach->x, 555u);
}

TEST(ErrorBound, IsNoNumberWhereAnyCodeMayBeLeft) {
    const Case k = caseOf(11, 0.9);
    // Any code everywhere.
    ErrorBound bound = errorBoundOf(k.base, k.truth, false, {glm::dvec3(2), glm::dvec3(2)}, 0);
    EXPECT_TRUE(bound.empty());
    EXPECT_EQ(bound.why(), "no bound below full scale");
    EXPECT_FALSE(breachOf(k.error(), bound, kWidth)) << "nothing is claimed";
    // In some pixels.
    std::vector<float> brighter(3 * kPixels, 0.1f), darker(3 * kPixels, 0.1f);
    for (size_t i = 0; i < 30; ++i) brighter[i] = darker[i] = 5276;
    bound = errorBoundOf(k.base, k.truth, false, {brighter, darker}, 0);
    EXPECT_EQ(bound.max, ErrorBound::kNoBound);
    EXPECT_EQ(bound.brighter, ErrorBound::kNoBound);
    EXPECT_EQ(bound.darker, ErrorBound::kNoBound);
    EXPECT_LT(bound.p99, 255);
    EXPECT_LT(bound.rms, 255);
    EXPECT_FALSE(bound.empty());
    EXPECT_EQ(bound.why(), "max, choice.brighter, choice.darker: no bound below full scale");
    // A choice that can only brighten says something of whatever is not black.
    bound = errorBoundOf(k.base, k.truth, false, {glm::dvec3(5276), glm::dvec3(0)}, 0);
    EXPECT_LT(bound.mean, 255);
    EXPECT_LT(bound.rms, 255);
    EXPECT_EQ(bound.brighter, ErrorBound::kNoBound);
    EXPECT_EQ(bound.darker, 0);
}

TEST(ErrorBound, CountsAlphaAndStepsAndNothingThatIsNotShown) {
    Case k = caseOf(13);
    for (size_t at = 0; at < kPixels; ++at)
        k.truth.alpha[at] = k.truth.alpha[at] > 0 ? 0.25 : 0,
        k.base.rgba[at] = (k.base.rgba[at] & 0xffffffu) | (k.base.object[at] == kNone ? 0 : 0xff000000u);
    k.moved.rgba = k.base.rgba;
    k.moved.linear = k.base.linear;
    const ErrorBound still = errorBoundOf(k.base, k.truth, true, {glm::dvec3(0), glm::dvec3(0)}, 0);
    EXPECT_FALSE(breachOf(k.error(true), still, kWidth));
    EXPECT_NEAR(still.max, 255 * 0.75, 1);
    EXPECT_TRUE(breachOf(k.error(true), errorBoundOf(k.base, k.truth, false, {glm::dvec3(0), glm::dvec3(0)}, 0), kWidth))
        << "alpha left out";
    for (size_t at = 0; at < kPixels; ++at) EXPECT_EQ(still.perPixel[at] > 0, k.base.object[at] != kNone);
    // A code beside the right one.
    Case beside = caseOf(15);
    beside.moved = beside.base;
    for (uint32_t& word : beside.moved.rgba) word = (word & 0xff) < 255 ? word + 1 : word;
    EXPECT_FALSE(breachOf(beside.error(), errorBoundOf(beside.base, beside.truth, false, {glm::dvec3(0), glm::dvec3(0)}, 1), kWidth));
    EXPECT_TRUE(breachOf(beside.error(), errorBoundOf(beside.base, beside.truth, false, {glm::dvec3(0), glm::dvec3(0)}, 0), kWidth))
        << "no steps";
}

}  // namespace
}  // namespace plumb
