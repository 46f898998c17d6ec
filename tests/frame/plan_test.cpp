// SPDX-License-Identifier: MIT
// The plan is what runs: for each way to draw, the steps that a plan promises are those that were timed, but for those that state why they had
// nothing to do; and a plan that promises something else is refused.
#include "host/error.h"
#include "pipeline/render/prepare.h"
#include "tests/support/device_fixture.h"
#include "tests/support/ray_scenes.h"
#include "tests/support/scenes.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace plumb::test {
namespace {

constexpr uint32_t kWidth = 67, kHeight = 45;

struct Way {
    std::string name;
    RenderRequest request;
};

RenderRequest small(Shading shading, Fill fill = Fill::exact, uint32_t samples = 1) {
    RenderRequest r;
    r.width = kWidth;
    r.height = kHeight;
    r.shading = shading;
    r.fill = fill;
    r.samples = samples;
    return r;
}

std::vector<Way> waysOfMeshes() {
    std::vector<Way> ways;
    for (const Choice<Shading>& shading : kShadings) {
        if (shading.value == Shading::wire || shading.value == Shading::ray) continue;
        for (const Choice<Fill>& fill : kFills)
            for (const uint32_t samples : {1u, 4u})
                for (const uint32_t planes : {uint32_t(kPlaneColour), kPlaneColour | kPlaneNormal | kPlaneLinear}) {
                    RenderRequest r = small(shading.value, fill.value, samples);
                    r.planes = planes;
                    ways.push_back(
                        {fmt::format("shading {}, fill {}, {} samples, planes {:#x}", shading.word, fill.word, samples, planes), r});
                }
    }
    for (const Choice<WireView>& view : kWireViews)
        for (const uint32_t samples : {1u, 4u}) {
            RenderRequest r = small(Shading::wire, Fill::exact, samples);
            r.wire = view.value;
            ways.push_back({fmt::format("wire {}, {} samples", view.word, samples), r});
        }
    return ways;
}

std::vector<Way> waysOfRays() {
    std::vector<Way> ways;
    for (const Choice<Sampling>& sampling : kSamplings) {
        RenderRequest r = small(Shading::ray);
        r.rays.sampling = sampling.value;
        ways.push_back({fmt::format("rays, sampling {}", sampling.word), r});
    }
    ways.push_back({"rays, 4 samples", small(Shading::ray, Fill::exact, 4)});
    return ways;
}

class PlanOf : public DeviceTest {
protected:
    // Draws on both sides. What ran equals what was planned and not stated to be idle; returns the steps that were idle on the device.
    std::set<std::string> walk(const Scene& scene, const Way& way) {
        SCOPED_TRACE(way.name);
        expectWalked(renderCpu(scene, way.request), planRender(scene, way.request, RunsOn::twin));
        const RenderResult drawn = renderGpu(device(), scene, way.request);
        expectWalked(drawn, planRender(scene, way.request, RunsOn::device));
        std::set<std::string> idle;
        for (const PlanStep& step : drawn.plan.steps)
            if (!step.ran) idle.insert(step.name);
        return idle;
    }

private:
    static void expectWalked(const RenderResult& drawn, const Plan& planned) {
        EXPECT_EQ(drawn.plan.names(), planned.names()) << "what --explain prints is what is drawn";
        std::set<std::string> ran, walked;
        for (const PassTime& time : drawn.times)
            if (time.dispatches > 0) ran.insert(time.pass);
        for (const PlanStep& step : drawn.plan.steps) {
            EXPECT_FALSE(step.why.empty()) << step.name;
            EXPECT_NE(step.ran, !step.idle.empty()) << step.name << ": it ran, or says why not";
            if (step.ran && step.fusedIn.empty()) walked.insert(step.name);
        }
        EXPECT_EQ(ran, walked);
    }
};

TEST_F(PlanOf, MeshesIsWhatRuns) {
    std::set<std::string> everIdle, everRan;
    const View view{kWidth, kHeight};
    const std::vector<std::pair<const char*, std::function<Scene()>>> scenes = {
        {"inside", [&] { return inside(view); }},         // crosses the near plane
        {"soup", [&] { return soup(view, 1, 60, 12); }},  // small triangles, none is cut
        {"large", [&] { return soup(view, 2, 40, 150); }},
        {"outside", [&] {
             Scene s = soup(view, 1, 60, 12);
             s.camera->eye += 1000.0 * s.camera->forward;
             return s;
         }}};
    for (const auto& [name, build] : scenes) {
        SCOPED_TRACE(name);
        const Scene scene = build();
        std::vector<Way> ways = waysOfMeshes();
        ways.push_back({"phong in bands", small(Shading::phong)});  // whose triangles the set-up pass cannot list
        ways.back().request.knobs.bandRows = 9;
        for (const Way& way : ways) {
            const std::set<std::string> idle = walk(scene, way);
            everIdle.insert(idle.begin(), idle.end());
            for (const std::string& step : planRender(scene, way.request, RunsOn::device).names())
                if (!idle.contains(step)) everRan.insert(step);
        }
    }
    // A step that is idle in one picture runs in another: no statement stands for every picture.
    for (const std::string& step : everIdle) EXPECT_TRUE(everRan.contains(step)) << step << " had nothing to do in any picture";
    for (const char* step : {"clip", "bin strips", "illuminate", "lines", "scanline", "scanpaint", "resolve"})
        EXPECT_TRUE(everRan.contains(step)) << step;
    EXPECT_TRUE(everIdle.contains("clip"));
}

TEST_F(PlanOf, RaysIsWhatRuns) {
    for (const Scene& scene : {mirrors(), glass(), meshesAmongMirrors()})
        for (const Way& way : waysOfRays()) walk(scene, way);
}

TEST_F(PlanOf, APictureInChunksAndBandsIsWhatRuns) {
    for (Way way : waysOfMeshes()) {
        way.request.knobs.chunkTriangles = 7;
        way.request.knobs.bandRows = 9;
        walk(soup({kWidth, kHeight}, 1, 60, 12), way);
    }
}

std::string refusalOf(const std::function<void()>& body) {
    try {
        body();
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(Plan, RefusesWhatIsNoStep) {
    Plan plan;
    plan.add({"fill", RunsOn::device, "the picture"});
    EXPECT_EQ(refusalOf([&] { Plan(plan).close({{"fill", 1, 1}, {"blur", 1, 1}}); }), "plan: 'blur' ran and is no step of the plan");
    plan.add({"encode", RunsOn::device, "bytes", "fill"});
    EXPECT_EQ(refusalOf([&] {
                  Plan(plan).close({{"fill", 1, 1}, {"encode", 1, 1}});
              }),
              "plan: 'encode' ran and is no step of the plan")
        << "it runs in fill";
    EXPECT_EQ(refusalOf([&] { Plan(plan).close({{"fill", 1, 1}}); }), "");
}

TEST(Plan, RefusesAStepThatIsPassedOverInSilence) {
    Plan plan;
    plan.add({"fill", RunsOn::device, "the picture"});
    EXPECT_EQ(refusalOf([&] { Plan(plan).close({}); }), "plan: the step 'fill' neither ran nor had nothing to do");
    plan.skip("fill", "no triangle is drawn");
    plan.skip("blur", "no step of this plan");
    EXPECT_EQ(refusalOf([&] { Plan(plan).close({}); }), "");
    plan.close({{"fill", 1, 2}});
    EXPECT_TRUE(plan.steps[0].ran);
    EXPECT_EQ(plan.steps[0].idle, "") << "it ran in another band";
}

TEST_F(PlanOf, ARecorderRefusesALabelThatIsNoStep) {
    Recorder recorder(device());
    recorder.allow({"clear"});
    Buffer<uint32_t> words(device(), 16, "words");
    EXPECT_EQ(refusalOf([&] { recorder.fill("wash", words, 0); }), "wash: no step of the plan has this name (its steps here are clear)");
    recorder.fill("clear", words, 0);
    recorder.run();
}

}  // namespace
}  // namespace plumb::test
