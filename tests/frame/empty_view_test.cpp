// SPDX-License-Identifier: MIT
// A picture in which nothing is drawn: every plane is the same on both sides, and is what docs/outputs.md says of it. For each shading, fill, number of
// samples and background, and for each way in which nothing comes to be drawn.
#include "host/error.h"
#include "tests/support/compare.h"
#include "tests/support/device_fixture.h"
#include "tests/support/ray_scenes.h"
#include "tests/support/scenes.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <set>
#include <string>
#include <vector>

namespace plumb::test {
namespace {

// Means of 4 and of 16 of these round.
constexpr glm::vec3 kBackground{0.1f, 0.51f, 0.0201f};
constexpr View kView{19, 11};

Scene oneTriangle(double z, bool facing) {
    Scene s = litScene();
    const glm::vec3 a(-1, -1, z), b(1, -1, z), c(0, 1, z);
    addObject(s, soupOf({facing ? Corners{a, b, c} : Corners{a, c, b}}, 1));
    s.cullBackFaces = true;
    return s;
}

struct Emptiness {
    const char* name;
    Scene scene;
    bool toRays, toLines, toCulledLines;  // rays, and the wire frames, see nothing of it either
    bool toTheNotes = true;               // nor does the fill of the notes
};

std::vector<Emptiness> emptinesses() {
    Scene beside = oneTriangle(-4, true), away = oneTriangle(-4, false), none = litScene(), far = oneTriangle(-4, true),
          flat = oneTriangle(-4, true);
    beside.objects[0].worldFromObject[3].x = 1000;
    far.camera->near = 8;
    for (glm::vec3& p : flat.meshes[0].positions) p.y = p.x;  // no area
    return {{"behind the viewer", oneTriangle(4, true), true, true, true}, {"beside the view", beside, true, true, true},
            {"nearer than the near plane", far, false, true, true, false}, {"every polygon faces away", away, false, false, true},
            {"every polygon is of zero area", flat, false, false, false},  {"no object", none, true, true, true}};
}

uint32_t planesOf(Shading shading) {
    const uint32_t lines = kPlaneColour | kPlaneLinear | kPlaneObject | kPlanePrimitive;
    if (shading == Shading::wire) return lines;
    return shading == Shading::ray ? kEveryPlane & ~uint32_t(kPlaneTriangle) : kEveryPlane;
}

// The mean of equal samples, added one after another.
float meanOf(float value, uint32_t samples) {
    float sum = 0;
    for (uint32_t i = 0; i < samples; ++i) sum += value;
    return sum * (1.0f / float(samples));
}
// As --background has it: black where it is transparent.
glm::vec3 backgroundOf(bool transparent) { return transparent ? glm::vec3(0) : kBackground; }

class EmptyView : public DeviceTest {
protected:
    static void expectNothing(const Frame& f, const RenderRequest& request) {
        const size_t pixels = size_t(request.width) * request.height;
        EXPECT_EQ(f.coveredPixels, 0u);
        ASSERT_EQ(f.rgba.size(), pixels);
        ASSERT_EQ(f.linear.size(), 3 * pixels);
        const auto all = [](const auto& values, auto want) {
            return std::all_of(values.begin(), values.end(), [&](auto v) { return v == want; });
        };
        EXPECT_TRUE(all(f.rgba, f.rgba[0])) << "the pixels differ";
        EXPECT_EQ(f.rgba[0] >> 24, request.transparent ? 0u : 255u);
        for (size_t i = 0; i < f.linear.size(); ++i)
            ASSERT_EQ(f.linear[i], meanOf(request.background[int(i % 3)], request.samples)) << "linear " << i;
        for (const std::vector<float>* plane : {&f.depth, &f.distance}) EXPECT_TRUE(all(*plane, INFINITY));
        for (const std::vector<float>* plane : {&f.normal, &f.z}) EXPECT_TRUE(all(*plane, 0.0f));
        for (const std::vector<uint32_t>* plane : {&f.object, &f.primitive, &f.triangle}) EXPECT_TRUE(all(*plane, kNone));
    }
    static void verify(const Scene& scene, RenderRequest request) {
        request.planes = planesOf(request.shading);
        const Frame twin = renderCpu(scene, request).frame, gpu = renderGpu(device(), scene, request).frame;
        expectNothing(twin, request);
        expectNothing(gpu, request);
        expectSameFrame(twin, gpu);
        const VerifyReport report = verifyRender(device(), scene, request);
        EXPECT_TRUE(report.equal) << report.mismatches.front().pass << ": " << report.mismatches.front().what;
        std::set<std::string> names;
        for (const VerifyPlane& plane : report.planes) names.insert(plane.name);
        EXPECT_EQ(names.count("linear"), 1u);
        EXPECT_EQ(names.size(), request.shading == Shading::wire ? 5u : request.shading == Shading::ray ? 9u : 10u);
        request.planes = kPlaneColour;
        ResidentScene resident(device(), scene, request);
        const ResidentScene::Picture picture = resident.draw();
        for (uint32_t y = 0; y < picture.height; ++y)
            for (uint32_t x = 0; x < picture.width; ++x) ASSERT_EQ(picture.pixels[size_t(y) * picture.pitch + x] >> 24, 0u);
    }
    // 1, 4 and 16 samples, opaque and transparent.
    static void verifyAll(const Scene& scene, RenderRequest request) {
        request.width = kView.width;
        request.height = kView.height;
        for (const uint32_t samples : {1u, 4u, 16u})
            for (const bool transparent : {false, true}) {
                request.background = backgroundOf(transparent);
                SCOPED_TRACE(fmt::format("{} samples{}", samples, transparent ? ", transparent" : ""));
                request.samples = samples;
                request.transparent = transparent;
                verify(scene, request);
            }
    }
};

TEST_F(EmptyView, IsTheBackgroundInEveryShading) {
    for (const Emptiness& e : emptinesses())
        for (const Shading shading : {Shading::wire, Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong, Shading::ray}) {
            if (shading == Shading::ray && !e.toRays) continue;
            for (const WireView view : {WireView::seeThrough, WireView::culled, WireView::solid}) {
                if (shading != Shading::wire && view != WireView::seeThrough) continue;
                if (shading == Shading::wire && !(view == WireView::culled ? e.toCulledLines : e.toLines)) continue;
                SCOPED_TRACE(fmt::format("{}, shading {}, lines {}", e.name, int(shading), int(view)));
                RenderRequest request;
                request.shading = shading;
                request.wire = view;
                verifyAll(e.scene, request);
            }
        }
}

TEST_F(EmptyView, IsTheBackgroundInTheFillOfTheNotes) {
    for (const Emptiness& e : emptinesses())
        for (const Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong}) {
            if (!e.toTheNotes) continue;
            SCOPED_TRACE(fmt::format("{}, shading {}", e.name, int(shading)));
            RenderRequest request;
            request.shading = shading;
            request.fill = Fill::notes;
            verifyAll(e.scene, request);
        }
}

TEST_F(EmptyView, IsTheBackgroundOfSpheresAndPlanes) {
    Scene s = rayScene();
    s.spheres = {ball({0, 0, 30}, 1, 0)};
    s.planes = {floorAt(0, 0, 0, 1)};
    s.planes[0].vMin = 10, s.planes[0].vMax = 20;  // behind the viewer
    for (const Choice<Sampling>& row : kSamplings) {
        const Sampling sampling = row.value;
        SCOPED_TRACE(row.word);
        RenderRequest request;
        request.width = kView.width;
        request.height = kView.height;
        request.background = kBackground;
        request.shading = Shading::ray;
        request.rays.sampling = sampling;
        request.planes = planesOf(Shading::ray);
        const bool ownSamples = sampling == Sampling::corners || sampling == Sampling::adaptive;
        if (!ownSamples) {
            verifyAll(s, request);
            continue;
        }
        const Frame twin = renderCpu(s, request).frame, gpu = renderGpu(device(), s, request).frame;
        expectSameFrame(twin, gpu);
        request.samples = 4;  // corners: a mean of four
        expectNothing(gpu, request);
    }
}

TEST_F(EmptyView, IsTheBackgroundOfTheNotesSpheres) {
    Scene s;
    s.path = "test";
    s.leftHanded = true;
    s.materials.emplace_back();
    Camera camera;
    camera.eye = {0, 0, -500};
    camera.forward = {0, 0, 1};
    camera.focalPixels = camera.focusDistance = 500;
    s.camera = camera;
    s.spheres = {ball({400, 0, 100}, 20, 0)};
    RenderRequest request;
    request.width = kView.width;
    request.height = kView.height;
    request.fill = Fill::notes;
    for (const bool transparent : {false, true}) {
        request.background = backgroundOf(transparent);
        request.transparent = transparent;
        verify(s, request);
    }
}

// What a choice of the trade moves is where something is drawn.
TEST_F(EmptyView, IsTheBackgroundWithEveryTrade) {
    const std::vector<Emptiness> all = emptinesses();
    for (const Emptiness* e : {&all[0], &all[3]})
        for (const TradeAxis& axis : kTradeAxes)
            for (const TradeChoice& choice : axis.choices.subspan(1)) {
                SCOPED_TRACE(fmt::format("{}, {}={}", e->name, axis.name, choice.word));
                RenderRequest request;
                request.width = kView.width;
                request.height = kView.height;
                request.background = kBackground;
                choice.choose(request.trade);
                verify(e->scene, request);
            }
}

}  // namespace
}  // namespace plumb::test
