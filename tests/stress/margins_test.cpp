// SPDX-License-Identifier: MIT
// The search for margins, with pictures that are spoilt at known values: what is found is what was planted. And the moves of the axes: a picture that
// a move must not change stays the same.
#include "pipeline/scene/load.h"
#include "pipeline/stress/move.h"
#include "pipeline/stress/stress.h"
#include "pipeline/truth/frame_error.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

namespace plumb::stress {
namespace {

constexpr double kBisected = 1.02;  // factor to which a margin is found

Picture torus() {
    Picture p;
    p.request.width = 64;
    p.request.height = 48;
    p.scene = loadScene({std::filesystem::path(PLUMB_SOURCE_DIR) / "scenes/procedural/torus.ply"}, {});
    completeScene(p.scene, {p.request.width, p.request.height}, "", true);
    return p;
}

// A picture in which every face is another one.
RenderResult spoilt(RenderResult result) {
    for (uint32_t& face : result.frame.primitive) face = face == kNone ? kNone : face + 1;
    return result;
}

// Plan that draws by the twin, and spoils what `bad` says.
StressPlan planFor(const std::vector<std::string>& axes, const std::function<bool(const Scene&, const RenderRequest&)>& bad) {
    StressPlan plan;
    plan.axes = rowsOf(axes);
    plan.budget = budgetOr({});
    plan.draw = [bad](const Scene& scene, const RenderRequest& request) {
        RenderResult result = renderCpu(scene, request);
        return bad(scene, request) ? spoilt(std::move(result)) : result;
    };
    return plan;
}

const AxisMargin& marginOf(const StressReport& report, const std::string& name, bool rises) {
    const auto found = std::find_if(report.axes.begin(), report.axes.end(),
                                    [&](const AxisMargin& a) { return a.axis->name == name && a.axis->rises == rises; });
    EXPECT_NE(found, report.axes.end());
    return *found;
}

TEST(Margins, APlantedMarginIsFoundToTwoDigits) {
    const Picture picture = torus();
    for (const double planted : {1e-4, 3.3e-8, 2.5e-15}) {
        const StressReport report = findMargins(picture, planFor({"near"}, [&](const Scene& s, const RenderRequest&) {
                                                    return s.camera->near > 0 && s.camera->near < planted;
                                                }));
        const Margin& m = marginOf(report, "near", false).margin;
        EXPECT_EQ(m.end, End::breaks) << planted;
        EXPECT_GE(m.margin, planted);
        EXPECT_LT(m.beyond, planted);
        EXPECT_LE(m.margin / m.beyond, kBisected);
        EXPECT_TRUE(m.islands.empty());
        EXPECT_FALSE(report.beyond());
        // Both claims of a margin were drawn.
        const auto drawn = [&](double value, Outcome outcome) {
            return std::any_of(m.tried.begin(), m.tried.end(), [&](const Tried& t) { return t.value == value && t.outcome == outcome; });
        };
        EXPECT_TRUE(drawn(m.margin * 2, Outcome::within));
        EXPECT_TRUE(drawn(m.margin / 2, Outcome::beyond));
        EXPECT_TRUE(drawn(m.margin / 4, Outcome::beyond));
    }
}

TEST(Margins, AnIslandIsNamedAndNotTheMargin) {
    constexpr double kMargin = 1e-12, kHigh = 3e-5, kLow = 1.2e-5;  // a power of two apart
    const auto bad = [](const Scene& s, const RenderRequest&) {
        const double near = s.camera->near;
        return near > 0 && (near < kMargin || (near < kHigh && near > kLow));
    };
    const Margin m = marginOf(findMargins(torus(), planFor({"near"}, bad)), "near", false).margin;
    EXPECT_EQ(m.end, End::breaks);
    EXPECT_GE(m.margin, kMargin);
    EXPECT_LE(m.margin, kMargin * kBisected);
    ASSERT_EQ(m.islands.size(), 1u);
    EXPECT_GT(m.islands[0], kLow);
    EXPECT_LT(m.islands[0], kHigh);
}

TEST(Margins, WhatFloat32AloneSpoilsIsItsOwnMargin) {
    constexpr double kPlanted = 100;
    const auto isLarge = [](const Scene& s) { return s.objects[0].worldFromObject[0][0] > kPlanted; };
    StressPlan plan = planFor({"size"}, [&](const Scene& s, const RenderRequest& r) { return r.knobs.float32Only && isLarge(s); });
    // Pictures that need nothing beyond float32 are the same in both arithmetics, and drawn once.
    AxisMargin axis = marginOf(findMargins(torus(), plan), "size", true);
    EXPECT_EQ(axis.margin.end, End::holds);
    ASSERT_TRUE(axis.float32);
    EXPECT_EQ(axis.float32->end, End::holds);
    EXPECT_EQ(axis.float32->tried.size(), axis.margin.tried.size());

    plan.draw = [draw = plan.draw, isLarge](const Scene& s, const RenderRequest& r) {
        RenderResult result = draw(s, r);
        if (isLarge(s) && !r.knobs.float32Only) result.plan.raised.push_back({.what = "precision"});
        return result;
    };
    axis = marginOf(findMargins(torus(), plan), "size", true);
    EXPECT_EQ(axis.margin.end, End::holds);
    EXPECT_EQ(axis.float32->end, End::breaks);
    EXPECT_LE(axis.float32->margin, kPlanted);
    EXPECT_GE(axis.float32->margin * kBisected, kPlanted);
}

TEST(Margins, ASceneBeyondItsMarginIsToldHowFar) {
    constexpr double kPlanted = 2;
    Picture picture = torus();
    picture.scene.camera->near = picture.scene.camera->focusDistance / 1024;
    for (Light& light : picture.scene.lights) light.intensity = glm::vec3(7.0f);
    const StressReport report = findMargins(picture, planFor({"light-strength", "size", "near"}, [](const Scene& s, const RenderRequest&) {
                                                return s.lights[0].intensity.x > kPlanted;
                                            }));
    EXPECT_TRUE(report.beyond());
    const AxisMargin& rising = marginOf(report, "light-strength", true);
    EXPECT_EQ(rising.margin.end, End::passed);
    EXPECT_EQ(*rising.present, 7);
    EXPECT_LE(rising.margin.margin, kPlanted);
    EXPECT_GE(rising.margin.margin * kBisected, kPlanted);
    EXPECT_GT(rising.margin.beyond, kPlanted);
    EXPECT_EQ(marginOf(report, "size", true).margin.end, End::other);
    EXPECT_EQ(marginOf(report, "near", false).margin.end, End::other);
}

TEST(Margins, WhatCannotBeToldIsNamed) {
    const Picture picture = torus();
    const auto never = [](const Scene&, const RenderRequest&) { return false; };
    StressReport report = findMargins(picture, planFor({"size", "fov", "vertices", "depth", "light-distance"}, never));
    EXPECT_EQ(marginOf(report, "size", true).margin.end, End::holds);
    EXPECT_NE(marginOf(report, "size", true).margin.why.find("refused: "), std::string::npos) << marginOf(report, "size", true).margin.why;
    EXPECT_NE(marginOf(report, "fov", true).margin.why.find("pixels are seen"), std::string::npos)
        << marginOf(report, "fov", true).margin.why;
    EXPECT_NE(marginOf(report, "vertices", true).margin.why.find("is seen"), std::string::npos);
    EXPECT_NE(marginOf(report, "depth", true).absent.find("not traced"), std::string::npos);
    EXPECT_NE(marginOf(report, "light-distance", true).absent.find("no point light"), std::string::npos);
    StressPlan late = planFor({"size"}, never);
    late.limitMs = 0;
    report = findMargins(picture, late);
    EXPECT_EQ(report.axes[0].margin.end, End::cut);
    Picture small = picture;
    small.request.width = small.request.height = 8;
    EXPECT_THROW(findMargins(small, late), Error);
}

// --- moves ------------------------------------------------------------------------------------------------------------------------------

struct Figures {
    uint64_t pixels;
    std::vector<uint32_t> rgba;
};
Frame frameOf(const Picture& p) {
    RenderRequest request = p.request;
    request.planes |= kCheckedPlanes;
    return renderCpu(p.scene, request).frame;
}
Figures drawn(const Picture& p) {
    const Frame frame = frameOf(p);
    const FrameError error = errorOf(frame, truthOf(p.scene, p.request), p.request.encoding, false);
    return {error.pixels, frame.rgba};
}

// Pixels whose colour differs by more than a step. A rounded coordinate moves an edge by a small part of a pixel, and few pixels lie so near to one.
uint64_t differing(const Figures& a, const Figures& b) {
    uint64_t count = 0;
    for (size_t i = 0; i < a.rgba.size(); ++i)
        for (int shift = 0; shift < 24; shift += 8)
            if (std::abs(int(a.rgba[i] >> shift & 0xff) - int(b.rgba[i] >> shift & 0xff)) > 1) {
                ++count;
                break;
            }
    return count;
}

TEST(Moves, WhatMovesTheWholeSceneLeavesThePicture) {
    const Picture picture = torus();
    const Figures before = drawn(picture);
    ASSERT_GT(before.pixels, 400u);
    const std::vector<std::pair<const char*, double>> moves = {
        {"vertices", 1024}, {"place", 1024}, {"size", 64}, {"extent", 64}, {"density", 2}};
    for (const auto& [name, value] : moves) {
        Picture moved = picture;
        rowsOf({name})[0]->move(moved, value);
        const Figures after = drawn(moved);
        EXPECT_LE(differing(before, after), before.pixels / 100) << name;
    }
}

TEST(Moves, OffsetsAreWhatAFileWouldState) {
    Picture picture = torus();
    rowsOf({"vertices"})[0]->move(picture, 1e6);
    const TriangleMesh& mesh = picture.scene.meshes[0];
    const glm::dvec3 middle = mesh.statedMin * 0.5 + mesh.statedMax * 0.5;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(std::abs(middle[i]), 1e6, 1e-6);
    EXPECT_GT(largestOf(mesh.origin), 9e5) << "the mesh has an origin of its own";
    rowsOf({"extent"})[0]->move(picture, 1e6);
    EXPECT_EQ(largestOf(picture.scene.meshes[0].origin), 0) << "no origin serves both ends";
    EXPECT_EQ(picture.scene.meshes[0].degenerateFaces, 1u);
    EXPECT_GT(largestOf(picture.scene.meshes[0].lost), 0) << "float32 loses digits there";
}

TEST(Moves, ALayerCoversThePixelsOfTheScene) {
    const Picture picture = torus();
    const Figures before = drawn(picture);
    Picture moved = picture;
    rowsOf({"gap"})[0]->move(moved, 0.25);
    const Frame frame = frameOf(moved);
    uint64_t layer = 0, first = 0;
    for (const uint32_t object : frame.object) layer += object == 1, first += object == 0;
    EXPECT_EQ(first, 0u);
    EXPECT_NEAR(double(layer), double(before.pixels), double(before.pixels) / 100);
}

TEST(Moves, AFlatterAngleKeepsEachVertexOnItsPixel) {
    const Picture picture = torus();
    const Figures before = drawn(picture);
    Picture moved = picture;
    rowsOf({"grazing"})[0]->move(moved, 1);
    const Frame frame = frameOf(moved), old = frameOf(picture);
    uint64_t other = 0;
    for (size_t i = 0; i < old.primitive.size(); ++i) other += old.primitive[i] != frame.primitive[i];
    EXPECT_LE(other, before.pixels / 100);
    EXPECT_LT(moved.scene.camera->fovYDegrees, picture.scene.camera->fovYDegrees / 40);
}

}  // namespace
}  // namespace plumb::stress
