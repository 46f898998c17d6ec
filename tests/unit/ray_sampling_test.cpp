// SPDX-License-Identifier: MIT
// Sampling choices of rays (notes 18.4.1, 18.4.3, 18.5): claims that hold whatever side draws; that both sides draw the same is the twin test's.
#include "pipeline/scene/ray_shares.h"
#include "shaders/shared/trace.h"
#include "tests/support/ray_scenes.h"

#include <gtest/gtest.h>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <set>
#include <vector>

namespace plumb::test {
namespace {

using Sampling = RayChoices::Sampling;

TEST(SampleAlong, HasAPlaceForEachChoice) {
    EXPECT_EQ(gpu::sampleAlong(gpu::kSampleGrid, 6, 4, 0.25f), 6.5f);
    EXPECT_EQ(gpu::sampleAlong(gpu::kSampleCentre, 6, 4, 0.25f), 6.0f);  // the middle of samples 4 to 7
    EXPECT_EQ(gpu::sampleAlong(gpu::kSampleCentre, 6, 1, 0.25f), 6.5f);
    EXPECT_EQ(gpu::sampleAlong(gpu::kSampleRandom, 6, 4, 0.25f), 6.25f);
    EXPECT_EQ(gpu::sampleAlong(gpu::kSampleCorner, 6, 4, 0.25f), 6.0f);
    EXPECT_EQ(gpu::sampleAlong(gpu::kSampleNotes, 6, 4, 0.25f), 7.0f);
}

TEST(Noise, IsInItsRangeAndEven) {
    EXPECT_EQ(gpu::unitNoise(0), 0.0f);
    EXPECT_EQ(gpu::unitNoise(~0u), 1 - 0x1p-24f);
    EXPECT_EQ(gpu::signedNoise(0), -1.0f);
    EXPECT_EQ(gpu::signedNoise(~0u), 1 - 0x1p-23f);
    // 2^20 draws in 64 bins: 16384 expected, binomial; six standard deviations of one bin are 762.
    std::vector<int> bins(64);
    for (uint32_t row = 0; row < 1024; ++row)
        for (uint32_t column = 0; column < 1024; ++column)
            ++bins[size_t(gpu::unitNoise(gpu::mixed(gpu::keyOfSample(column, row, 3) + 1)) * 64)];
    for (const int n : bins) EXPECT_LE(std::abs(n - 16384), 762);
}

TEST(Jittered, StaysOnItsSideOfTheSurface) {
    const glm::vec3 up(0, 1, 0);
    Random r(5);
    int turned = 0, kept = 0;
    for (uint32_t key = 0; key < 4000; ++key) {
        const glm::vec3 d = glm::vec3(r.direction());
        const glm::vec3 other = gpu::jittered(d, up, 0.5f, key);
        EXPECT_EQ(d.y > 0, other.y > 0) << key;
        EXPECT_NEAR(glm::length(glm::dvec3(other)), 1, 0x1p-19);
        turned += other != d;
        kept += other == d;
    }
    EXPECT_GT(turned, 2000);
    EXPECT_GT(kept, 100) << "shallow directions that the noise would turn";
}

TEST(Jittered, LevelDirectionsCountAsBelow) {
    const glm::vec3 up(0, 1, 0);
    for (uint32_t key = 0; key < 100; ++key) EXPECT_LE(gpu::jittered({1, 0, 0}, up, 0.5f, key).y, 0.0f) << key;
    // Without noise the result is the unit vector, which is level again.
    EXPECT_NEAR(gpu::jittered({2, 0, 0}, up, 0, 1).x, 1, 0x1p-20);
}

TEST(WholeLevels, AreThoseOfTheNotesProgram) {
    EXPECT_EQ(gpu::wholeLevel(0.47058823529411764f), 120.0f);
    EXPECT_EQ(gpu::cutLevel(0.7f * 255, 0.3f * 120), 214.0f);
    EXPECT_EQ(gpu::cutLevel(0.7f * 150, 0.3f * 120), 141.0f);
    EXPECT_EQ(gpu::cutLevel(0, 0.3f * 200), 60.0f);
}

RenderRequest requestOf(const Scene& scene, uint32_t width = 61, uint32_t height = 43) {
    RenderRequest r;
    r.width = width;
    r.height = height;
    r.shading = Shading::ray;
    r.background = *scene.background;
    r.maxDepth = scene.maxDepth;
    r.planes = kPlaneColour | kPlaneLinear;
    return r;
}
uint64_t rays(const RenderResult& r) {
    uint64_t sum = 0;
    for (const auto& depth : r.counters.rays) sum += depth.primary;
    return sum;
}

TEST(Sampling, FourRaysThroughTheCentreAreOne) {
    RenderRequest request = requestOf(mirrors());
    const RenderResult one = renderCpu(mirrors(), request);
    request.rays.sampling = Sampling::centre;
    request.samples = 4;
    const RenderResult four = renderCpu(mirrors(), request);
    EXPECT_EQ(one.frame.rgba, four.frame.rgba);
    EXPECT_EQ(one.frame.linear, four.frame.linear);
    EXPECT_EQ(rays(four), 4 * rays(one));
}

TEST(Sampling, CornersAreSharedByFourPixels) {
    RenderRequest request = requestOf(mirrors());
    request.rays.sampling = Sampling::corners;
    const RenderResult shared = renderCpu(mirrors(), request);
    EXPECT_EQ(rays(shared), uint64_t(request.width + 1) * (request.height + 1));
    for (const uint32_t rows : {1u, 7u}) {
        request.knobs.bandRows = rows;
        const RenderResult bands = renderCpu(mirrors(), request);
        EXPECT_EQ(bands.frame.rgba, shared.frame.rgba) << rows;
        EXPECT_EQ(bands.frame.linear, shared.frame.linear) << rows;
        EXPECT_EQ(rays(bands), rays(shared)) << "a row that two bands need is traced once";
    }
    // Against the picture with a ray at the corner of every pixel, and that of pixels to the right and below.
    Scene scene = mirrors();
    request.knobs.bandRows = 0;
    request.rays.sampling = Sampling::notes;
    const RenderResult lowerRight = renderCpu(scene, request);
    for (uint32_t y = 1; y < request.height; ++y)
        for (uint32_t x = 1; x < request.width; ++x)
            for (uint32_t k = 0; k < 3; ++k) {
                const auto at = [&](uint32_t i, uint32_t j) { return lowerRight.frame.linear[3 * (size_t(j) * request.width + i) + k]; };
                const float mean = (((at(x - 1, y - 1) + at(x, y - 1)) + at(x - 1, y)) + at(x, y)) * 0.25f;
                ASSERT_EQ(mean, shared.frame.linear[3 * (size_t(y) * request.width + x) + k]) << x << ", " << y;
            }
}

TEST(Sampling, WhereCornersDifferThereAreTheSixteenSamples) {
    const Scene scene = glass();
    RenderRequest request = requestOf(scene);
    request.samples = 16;
    const Frame sixteen = renderCpu(scene, request).frame;
    request.samples = 1;
    request.rays.sampling = Sampling::corners;
    const Frame corners = renderCpu(scene, request).frame;
    request.rays.sampling = Sampling::adaptive;
    const RenderResult adaptive = renderCpu(scene, request);
    uint64_t fine = 0, coarse = 0;
    for (size_t i = 0; i < corners.rgba.size(); ++i) {
        const bool isFine = adaptive.frame.rgba[i] == sixteen.rgba[i], isCoarse = adaptive.frame.rgba[i] == corners.rgba[i];
        EXPECT_TRUE(isFine || isCoarse) << i;
        fine += isFine && !isCoarse;
        coarse += isCoarse && !isFine;
    }
    EXPECT_GT(fine, 0u);
    EXPECT_GT(coarse, 0u);
    EXPECT_GE(adaptive.counters.refinedPixels, fine);
    EXPECT_EQ(rays(adaptive), uint64_t(request.width + 1) * (request.height + 1) + 16 * adaptive.counters.refinedPixels);
    request.knobs.bandRows = 5;
    const RenderResult bands = renderCpu(scene, request);
    EXPECT_EQ(bands.frame.rgba, adaptive.frame.rgba);
    EXPECT_EQ(rays(bands), rays(adaptive));
}

// Nothing differs from itself: a picture of the sky alone is refined nowhere.
TEST(Sampling, EqualCornersAreLeftAlone) {
    RenderRequest request = requestOf(rayScene());
    request.rays.sampling = Sampling::adaptive;
    EXPECT_EQ(renderCpu(rayScene(), request).counters.refinedPixels, 0u);
}

TEST(Sampling, NoiseIsTheSeedsAndNothingElses) {
    const Scene scene = glass();
    RenderRequest request = requestOf(scene);
    request.samples = 4;
    const Frame plain = renderCpu(scene, request).frame;
    request.rays.seed = 9;
    EXPECT_EQ(renderCpu(scene, request).frame.rgba, plain.rgba) << "a seed without noise changes nothing";
    for (const auto& set : {+[](RayChoices& r) { r.sampling = Sampling::random; }, +[](RayChoices& r) { r.jitterReflect = 0.05f; },
                            +[](RayChoices& r) { r.jitterRefract = 0.05f; }, +[](RayChoices& r) { r.jitterShadow = 0.05f; }}) {
        request.rays = {};
        set(request.rays);
        const Frame noisy = renderCpu(scene, request).frame;
        EXPECT_NE(noisy.rgba, plain.rgba);
        EXPECT_EQ(renderCpu(scene, request).frame.linear, noisy.linear);
        request.threads = 1;
        request.knobs.bandRows = 3;
        EXPECT_EQ(renderCpu(scene, request).frame.linear, noisy.linear) << "neither threads nor bands matter";
        request.threads = request.knobs.bandRows = 0;
        request.rays.seed = 10;
        EXPECT_NE(renderCpu(scene, request).frame.linear, noisy.linear);
    }
}

// Two seeds apart by the noise alone: their distance grows with its amount.
double distanceOfSeeds(const Scene& scene, RenderRequest request) {
    request.samples = 4;
    request.rays.seed = 1;
    const std::vector<float> a = renderCpu(scene, request).frame.linear;
    request.rays.seed = 2;
    const std::vector<float> b = renderCpu(scene, request).frame.linear;
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += std::pow(double(a[i]) - double(b[i]), 2);
    return sum;
}
TEST(Sampling, VarianceOfReflectionsRisesWithTheNoise) {
    double before = 0;
    for (const float amount : {0.0f, 0.005f, 0.05f, 0.4f}) {
        RenderRequest request = requestOf(mirrors());
        request.rays.jitterReflect = amount;
        const double now = distanceOfSeeds(mirrors(), request);
        EXPECT_TRUE(amount == 0 ? now == 0 : now > before) << amount;
        before = now;
    }
}

// A ball above a floor, light from above: with plain shadow rays a sample is lit or not; with noise pixels lie between.
TEST(Sampling, JitteredShadowRaysMakeAPenumbra) {
    Scene scene = rayScene();
    scene.lights.resize(1);
    scene.ambient = glm::vec3(0);
    scene.spheres = {ball({0, 1, 0}, 0.6, 0)};
    scene.planes.push_back(floorAt(-1, 0, 0, 0));
    scene.camera->eye = {0, 8, 4};
    scene.camera->forward = glm::normalize(glm::dvec3(0, -2, -1));
    scene.camera->up = glm::normalize(glm::dvec3(0, 1, -2));
    const auto between = [&](float amount) {
        RenderRequest request = requestOf(scene, 160, 120);
        request.samples = 16;
        request.rays.sampling = Sampling::centre;
        request.rays.jitterShadow = amount;
        request.planes |= kPlaneObject;
        const Frame f = renderCpu(scene, request).frame;
        request.rays.jitterShadow = 0;
        Scene open = scene;
        open.shadows = false;
        const Frame lit = renderCpu(open, request).frame;
        int count = 0;
        for (size_t i = 0; i < f.object.size(); ++i)
            count += f.object[i] == 1 && f.linear[3 * i] > 0 && f.linear[3 * i] < 0.99f * lit.linear[3 * i];
        return count;
    };
    const int none = between(0), small = between(0.02f), large = between(0.08f);
    EXPECT_EQ(none, 0);
    EXPECT_GT(small, 0);
    EXPECT_GT(large, small);
}

TEST(RaysAsked, ByMaterialsOfObjectsOnly) {
    Scene scene = meshesAmongMirrors();
    EXPECT_NE(raysAskedBy(scene), "");
    scene.spheres.clear();
    scene.planes.clear();
    for (Material& m : scene.materials) m.reflect = m.transmit = 0, m.statesRays = false;
    EXPECT_EQ(raysAskedBy(scene), "");
    scene.materials[3].statesRays = true;
    scene.materials[3].reflect = 0.25f;
    EXPECT_EQ(raysAskedBy(scene), "material 'default' reflects 0.25");
    scene.objects.clear();
    EXPECT_EQ(raysAskedBy(scene), "") << "no object has the material";
}

TEST(RaysAsked, IllumMapsAsMtlNumbersIt) {
    Material m;
    m.specular = glm::vec3(0.2f, 0.5f, 0.1f);
    m.opacity = 0.25f;
    for (int illum = 0; illum <= 10; ++illum) {
        m.illum = illum;
        const RayShares s = raySharesOf(m);
        const bool glass = illum == 4 || illum == 6 || illum == 7 || illum == 9, mirror = illum >= 3 && illum <= 9;
        EXPECT_EQ(s.transmit, glass ? 0.75f : 0.0f) << illum;
        EXPECT_EQ(s.reflect, glass ? 0.25f : mirror ? 0.5f : 0.0f) << illum;
        EXPECT_EQ(s.local, 1 - s.transmit - s.reflect) << illum;
        EXPECT_EQ(asksForRays(m), mirror) << illum;
    }
    m.illum = 3;
    m.specular = glm::vec3(0);
    EXPECT_FALSE(asksForRays(m)) << "a black mirror";
}

TEST(RaysAsked, RefusesWhatDoesNotGoTogether) {
    RenderRequest request = requestOf(glass());
    request.rays.sampling = Sampling::corners;
    request.samples = 4;
    EXPECT_THROW(renderCpu(glass(), request), Error);
    request = requestOf(glass());
    request.rays.jitterShadow = 0.75f;
    EXPECT_THROW(renderCpu(glass(), request), Error);
    request = requestOf(glass());
    request.rays.cutLevels = true;
    EXPECT_THROW(renderCpu(mirrors(), request), Error) << "sRGB";
    request.encoding = Encoding::linear;
    EXPECT_NO_THROW(renderCpu(mirrors(), request));
    EXPECT_THROW(renderCpu(glass(), request), Error) << "two children";
}

}  // namespace
}  // namespace plumb::test
