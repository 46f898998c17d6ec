// SPDX-License-Identifier: MIT
// What is proved of the choices of the trade holds in pictures, and is not so wide that it says nothing; and what float32 costs by itself.
#include "pipeline/render/bounds/bound.h"
#include "host/error.h"
#include "pipeline/render/bounds/rounding.h"
#include "pipeline/truth/frame_error.h"
#include "tests/support/ray_scenes.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace plumb {
namespace {

constexpr glm::uvec2 kSize{160, 120};

Scene committed(const char* name) { return test::committed(std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes" / name, kSize); }

RenderRequest requestOf(Shading shading = Shading::phong) {
    RenderRequest r;
    r.width = kSize.x;
    r.height = kSize.y;
    r.shading = shading;
    r.planes = kPlaneColour | kPlaneLinear | kPlaneDepth | kPlaneObject | kPlanePrimitive | kPlaneTriangle;
    return r;
}

// The largest difference of each channel.
glm::dvec3 apart(const Frame& a, const Frame& b) {
    glm::dvec3 most(0);
    for (size_t i = 0; i < a.linear.size(); ++i) {
        double& channel = most[glm::length_t(i % 3)];
        channel = std::max(channel, std::abs(double(a.linear[i]) - double(b.linear[i])));
    }
    return most;
}

TEST(BoundOfTrade, HoldsInPictures) {
    // Choices, each with the share of its bound that some picture below reaches at least.
    Trade schlick, native, shorter;
    schlick.specular = Trade::Specular::schlick;
    native.specular = Trade::Specular::native;
    shorter.unitNormals = false;
    const std::pair<const char*, std::pair<Trade, double>> choices[] = {
        {"schlick", {schlick, 0.3}}, {"native", {native, 0.001}}, {"as-interpolated", {shorter, 0.01}}};
    for (const auto& [name, choice] : choices) {
        double reached = 0;
        for (const char* file : {"suzanne.toml", "cornell.toml", "still-life.toml"}) {
            const Scene scene = committed(file);
            RenderRequest request = requestOf();
            const Frame plain = renderCpu(scene, request).frame;
            request.trade = choice.first;
            const ColourBound bound = boundOfTrade(scene, request);
            ASSERT_TRUE(bound.proved) << file << ' ' << name << ": " << bound.why;
            EXPECT_EQ(bound.steps, 0);
            const Frame traded = renderCpu(scene, request).frame;
            EXPECT_EQ(plain.triangle, traded.triangle) << "the same triangles are seen";
            const glm::dvec3 moved = apart(plain, traded);
            for (int c = 0; c < 3; ++c) {
                EXPECT_LE(moved[c], bound.linear[c]) << file << ' ' << name;
                if (bound.linear[c] > 0) reached = std::max(reached, moved[c] / bound.linear[c]);
            }
        }
        EXPECT_GT(reached, choice.second) << name;
    }
}

TEST(BoundOfTrade, SaysWhatIsNotProved) {
    const Scene scene = committed("suzanne.toml");
    std::vector<Trade> trades(8);
    trades[6].precision = Precision::blockInteger;
    trades[7].vectors = Trade::Vectors::face;
    trades[0].vectors = Trade::Vectors::scene;
    trades[1].affine = true;
    trades[2].depthBits = 24;
    trades[3].depthBits = Trade::kStandardDepth;
    trades[4].subpixelBits = 4;
    trades[5].coarse = true;
    for (const Trade& trade : trades) {
        RenderRequest request = requestOf();
        request.trade = trade;
        const ColourBound bound = boundOfTrade(scene, request);
        EXPECT_FALSE(bound.proved);
        EXPECT_NE(bound.why, "");
    }
    RenderRequest request = requestOf(Shading::ray);
    EXPECT_FALSE(boundOfTrade(scene, request).proved);
    request = requestOf();
    request.trade.specular = Trade::Specular::schlick;
    Scene dull = scene;
    for (Material& m : dull.materials) m.shininess = 0.5f;
    EXPECT_FALSE(boundOfTrade(dull, request).proved) << "below an exponent of 1 the quotient has no bound";
}

TEST(BoundOfTrade, IsNothingForWhatChangesNothing) {
    const Scene scene = committed("suzanne.toml");
    EXPECT_EQ(boundOfTrade(scene, requestOf()).linear, glm::dvec3(0));
    RenderRequest request = requestOf(Shading::unlit);
    request.trade.specular = Trade::Specular::native;
    EXPECT_EQ(boundOfTrade(scene, request).linear, glm::dvec3(0));
    request.trade = {};
    request.trade.nativeEncode = true;
    EXPECT_EQ(boundOfTrade(scene, request).steps, 1);
    request.encoding = Encoding::linear;
    EXPECT_EQ(boundOfTrade(scene, request).steps, 0) << "no curve, no power";
}

TEST(BoundOfTrade, FollowsTheDistanceOfALight) {
    Scene scene = committed("suzanne.toml");
    RenderRequest request = requestOf();
    request.trade.specular = Trade::Specular::schlick;
    Light lamp;
    lamp.directional = false;
    lamp.attenuation = Attenuation::inverseSquare;
    lamp.intensity = glm::vec3(1);
    const Object& object = scene.objects[0];
    const TriangleMesh& mesh = scene.meshes[object.mesh];
    const auto place = [&](uint32_t v) { return glm::dvec3(object.worldFromObject * glm::dvec4(mesh.positions[v], 1)); };
    const TriangleMesh::Triangle& t = mesh.triangles[0];
    scene.lights = {lamp};
    scene.lights[0].position = (place(t.vertex[0]) + place(t.vertex[1]) + place(t.vertex[2])) / 3.0;
    EXPECT_FALSE(boundOfTrade(scene, request).proved) << "it lies on a triangle";
    scene.lights[0].position = glm::dvec3(0, 100, 0);
    const double far = boundOfTrade(scene, request).linear.x;
    scene.lights[0].position = glm::dvec3(0, 200, 0);
    const double farther = boundOfTrade(scene, request).linear.x;
    EXPECT_GT(far, 3 * farther);
    EXPECT_LT(far, 5 * farther);
}

// A pixel's move is within what its own cut rays can make of it, in the direction in which rays come or go.
TEST(BoundOfRays, HoldsInPicturesAndIsReached) {
    double reachedDepth = 0, reachedCutoff = 0;
    for (const auto& row :
         {std::pair("mirrors", test::mirrors()), std::pair("glass", test::glass()), std::pair("meshes", test::meshesAmongMirrors())}) {
        const char* name = row.first;
        const Scene& scene = row.second;
        RenderRequest base = requestOf(Shading::ray);
        base.planes = kPlaneColour | kPlaneLinear;
        base.width /= 2;
        base.height /= 2;
        base.background = *scene.background;
        base.maxDepth = 4;
        base.minWeight = 0.02f;
        const Frame plain = renderCpu(scene, base).frame;
        const BoundOfRays bounds(scene, base);
        const auto judge = [&](const RenderRequest& request, double& reached) {
            const BoundOfRays::Moves moves = bounds.of(request);
            ASSERT_TRUE(moves.proved) << name << ": " << moves.why;
            const Frame other = renderCpu(scene, request).frame;
            ASSERT_EQ(moves.brighter.size(), other.linear.size());
            double off = 0, allowed = 0;
            size_t beyond = 0;
            for (size_t i = 0; i < other.linear.size(); ++i) {
                const double moved = double(other.linear[i]) - double(plain.linear[i]);
                beyond += !(moved <= double(moves.brighter[i])) || !(-moved <= double(moves.darker[i]));
                off = std::max(off, std::abs(moved));
                allowed = std::max({allowed, double(moves.brighter[i]), double(moves.darker[i])});
            }
            EXPECT_EQ(beyond, 0u) << name << " depth " << request.maxDepth << ", cutoff " << request.minWeight;
            reached = std::max(reached, off / allowed);
        };
        for (const uint32_t depth : {1u, 2u, 3u, 9u}) {
            RenderRequest request = base;
            request.maxDepth = depth;
            judge(request, reachedDepth);
        }
        for (const float least : {0.5f, 0.3f, 0.05f, 0.01f, 0.0f}) {
            RenderRequest request = base;
            request.minWeight = least;
            judge(request, reachedCutoff);
            request.maxDepth = 7;  // more of the one, less of the other
            judge(request, reachedCutoff);
        }
    }
    fmt::print("depth reaches {:.3f} of its bound, cutoff {:.3f}\n", reachedDepth, reachedCutoff);
    EXPECT_GT(reachedDepth, 0.1);
    EXPECT_GT(reachedCutoff, 0.1);
}

// What the deeper picture adds is bounded by what the default cut: next to nothing where the default reaches the end of its rays.
TEST(BoundOfRays, OfMoreRaysIsWhatTheDefaultCut) {
    const Scene scene = test::mirrors();
    RenderRequest base = requestOf(Shading::ray);
    base.background = *scene.background;
    double before = 1e9;
    for (const uint32_t depth : {1u, 2u, 4u, 8u, 16u}) {
        base.maxDepth = depth;
        RenderRequest request = base;
        request.maxDepth = 64;
        const BoundOfRays::Moves moves = BoundOfRays(scene, base).of(request);
        ASSERT_TRUE(moves.proved);
        const double most = *std::max_element(moves.brighter.begin(), moves.brighter.end());
        EXPECT_LT(most, before / 1.4) << "mirrors of at most 0.7, depth " << depth;
        EXPECT_LT(*std::max_element(moves.darker.begin(), moves.darker.end()), 0x1p-12) << "nothing is taken away";
        before = most;
    }
}

TEST(BoundOfRays, SaysWhatIsNotProved) {
    const Scene scene = test::mirrors();
    RenderRequest base = requestOf(Shading::ray);
    base.background = *scene.background;
    RenderRequest request = base;
    request.maxDepth = 2;
    Scene fading = scene;
    fading.lights[0].attenuation = Attenuation::inverseSquare;
    EXPECT_TRUE(BoundOfRays(fading, base).of(request).proved);
    fading.lights[0].position = fading.spheres[0].centre + glm::dvec3(fading.spheres[0].radius, 0, 0);
    EXPECT_FALSE(BoundOfRays(fading, base).of(request).proved) << "a light on a sphere";
    RenderRequest adaptive = base;
    adaptive.rays.sampling = RayChoices::Sampling::adaptive;
    EXPECT_FALSE(BoundOfRays(scene, adaptive).of(request).proved);
    base.rays.cutLevels = true;
    EXPECT_FALSE(BoundOfRays(scene, base).of(request).proved);
}

TEST(Rounding, IsWhatFloat32CostsByItself) {
    const Scene scene = committed("suzanne.toml");
    for (const Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong})
        for (const uint32_t samples : {1u, 4u}) {
            RenderRequest request = requestOf(shading);
            request.samples = samples;
            Frame frame = renderCpu(scene, request).frame;
            const std::optional<Rounding> rounding = roundingOf(scene, request, frame);
            ASSERT_TRUE(rounding);
            const FrameError error = errorOf(frame, truthOf(scene, request), Encoding::srgb, false);
            EXPECT_GT(rounding->pixels, 1000u);
            if (shading == Shading::unlit) {
                EXPECT_EQ(rounding->max, 0) << "a stored colour is not rounded";
            } else {
                EXPECT_GT(rounding->max, 0);
            }
            // Rounding leaves out the error of snapped corners and of another shading.
            EXPECT_LT(rounding->rms, error.unrounded.rms / 4) << int(shading);
            EXPECT_LT(rounding->linearMax, error.linear.max);
            fmt::print(
                "shading {}, {} samples: rounding max {:.3g}, rms {:.3g} steps; error before rounding to bytes: rms "
                "{:.3g}\n",
                int(shading), samples, rounding->max, rounding->rms, error.unrounded.rms);
            // A colour that is off by more than all rounding is noticed where it is.
            const size_t at = size_t(60) * kSize.x + 80;
            ASSERT_NE(frame.object[at], kNone);
            frame.linear[3 * at + 1] += 0.25f;
            const std::optional<Rounding> nudged = roundingOf(scene, request, frame);
            EXPECT_EQ(nudged->x, 80u);
            EXPECT_EQ(nudged->y, 60u);
            EXPECT_NEAR(nudged->linearMax, 0.25, 2 * rounding->linearMax + 0x1p-24);
        }
    RenderRequest request = requestOf();
    request.trade.coarse = true;
    EXPECT_FALSE(roundingOf(scene, request, renderCpu(scene, request).frame));
    request = requestOf(Shading::wire);
    EXPECT_FALSE(roundingOf(scene, request, Frame{}));
}

// Every choice that is read again: none rounds more than float32 does, whatever it costs against the truth.
TEST(Rounding, OfTradesIsNotTheirError) {
    const Scene scene = committed("suzanne.toml");
    RenderRequest request = requestOf();
    const double plain = roundingOf(scene, request, renderCpu(scene, request).frame)->rms;
    std::vector<Trade> trades(9);
    trades[5].precision = Precision::blockInteger;
    trades[6].precision = Precision::fp64;
    trades[7].vectors = Trade::Vectors::face;
    trades[8].vectors = Trade::Vectors::vertex;
    trades[0].specular = Trade::Specular::schlick;
    trades[1].affine = true;
    trades[2].unitNormals = false;
    trades[3].depthBits = 16;
    trades[4].vectors = Trade::Vectors::scene;
    for (size_t t = 0; t < trades.size(); ++t) {
        request.trade = trades[t];
        EXPECT_LT(roundingOf(scene, request, renderCpu(scene, request).frame)->rms, 8 * plain) << t;
    }
}

}  // namespace
}  // namespace plumb
