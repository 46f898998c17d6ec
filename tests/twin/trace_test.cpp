// SPDX-License-Identifier: MIT
#include "pipeline/render/rays/trace_frame.h"

#include "pipeline/passes/encode.h"
#include "tests/support/ray_scenes.h"
#include "tests/twin/pass_frame.h"

#include <fmt/format.h>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <ostream>
#include <span>
#include <string>
#include <vector>

namespace plumb::test {
namespace {

struct Row {
    const char* name;
    Scene (*build)();
    uint32_t width, height;
};
std::ostream& operator<<(std::ostream& out, const Row& r) { return out << r.name << ' ' << r.width << 'x' << r.height; }

class TraceTwin : public OnDevice<::testing::TestWithParam<Row>> {};

RenderRequest requestOf(const Scene& scene, uint32_t width, uint32_t height) {
    RenderRequest r;
    r.width = width;
    r.height = height;
    r.shading = Shading::ray;
    r.background = *scene.background;
    r.maxDepth = scene.maxDepth;
    r.minWeight = float(scene.minWeight);
    r.planes = kEveryPlane & ~uint32_t(kPlaneTriangle);
    return r;
}

void expectSameCounts(const RenderCounters& twin, const RenderCounters& device) {
    ASSERT_EQ(twin.rays.size(), device.rays.size());
    for (size_t i = 0; i < twin.rays.size(); ++i) {
        EXPECT_EQ(twin.rays[i].primary, device.rays[i].primary) << "depth " << i + 1;
        EXPECT_EQ(twin.rays[i].reflected, device.rays[i].reflected) << "depth " << i + 1;
        EXPECT_EQ(twin.rays[i].refracted, device.rays[i].refracted) << "depth " << i + 1;
        EXPECT_EQ(twin.rays[i].shadowRays, device.rays[i].shadowRays) << "depth " << i + 1;
    }
    EXPECT_EQ(twin.undecidedRays, device.undecidedRays);
}

TEST_P(TraceTwin, LeavesTheSameBytesAndCounts) {
    const Scene scene = GetParam().build();
    const RenderRequest request = requestOf(scene, GetParam().width, GetParam().height);
    const RenderResult twin = renderCpu(scene, request), onDevice = renderGpu(device(), scene, request);
    expectSameFrame(twin.frame, onDevice.frame);
    expectSameCounts(twin.counters, onDevice.counters);
}

TEST_P(TraceTwin, TheListGivesTheBytesOfThePath) {
    const Scene scene = GetParam().build();
    RenderRequest request = requestOf(scene, GetParam().width, GetParam().height);
    const RenderResult path = renderGpu(device(), scene, request);
    for (const uint32_t limit : {1u, 2u, 100u}) {
        request.knobs.rayLimit = limit;
        const RenderResult list = renderGpu(device(), scene, request);
        SCOPED_TRACE(fmt::format("{} rays a dispatch", limit));
        expectSameFrame(path.frame, list.frame);
        expectSameCounts(path.counters, list.counters);
    }
}

TEST_P(TraceTwin, SamplesBandsAndShallowDepthsToo) {
    const Scene scene = GetParam().build();
    RenderRequest request = requestOf(scene, GetParam().width, GetParam().height);
    for (const uint32_t samples : {1u, 4u}) {
        for (const uint32_t depth : {1u, 2u}) {
            request.samples = samples;
            request.maxDepth = depth;
            request.knobs.bandRows = depth == 1 ? 5 : 0;
            request.minWeight = depth == 2 ? 0.25f : 0.0f;
            request.transparent = depth == 2;
            SCOPED_TRACE(fmt::format("{} samples, depth {}", samples, depth));
            const RenderResult twin = renderCpu(scene, request), onDevice = renderGpu(device(), scene, request);
            expectSameFrame(twin.frame, onDevice.frame);
            expectSameCounts(twin.counters, onDevice.counters);
        }
    }
}

// Both forms of division and root, and not a word past the end of what a dispatch owns.
TEST_P(TraceTwin, BothFormsOfDivisionLeaveTheSameBytes) {
    const Scene scene = GetParam().build();
    const RenderRequest request = requestOf(scene, GetParam().width, GetParam().height);
    const Prepared p = prepare(scene, request);
    const TraceScene traced = traceSceneOf(scene, p);
    TraceChoices choices = traceChoicesOf(scene, request, p, traced);
    gpu::TracePush push = tracePushOf(p, request, traced);
    const uint32_t samples = push.width * GetParam().height;
    std::vector<uint32_t> distance(samples), object(samples), rgba(samples);
    std::vector<float> linear(3 * samples), normal(3 * samples);
    std::vector<uint64_t> counts(gpu::kCounters);
    push.itemCount = samples;
    push.rowWords = push.width;
    push.planeWords = samples;
    traceCpu(push, traced, choices, {distance, object, linear, normal}, counts, 1);
    choices.planes = gpu::kTracePlaneDistance | gpu::kTracePlaneObject | gpu::kTracePlaneLinear | gpu::kTracePlaneNormal;
    push.rayLimit = choices.list ? 2000 : push.maxDepth;
    for (const Specialization& exact : exactForms(device())) {
        TraceBuffers b;
        const auto atLeastOne = [&](auto from) {
            if (from.empty()) from.emplace_back();
            return bufferOf(device(), from);
        };
        b.spheres = atLeastOne(traced.spheres);
        b.powers = atLeastOne(traced.powers);
        b.planes = atLeastOne(traced.planes);
        b.surfaces = atLeastOne(traced.surfaces);
        b.materials = atLeastOne(traced.materials);
        b.lights = atLeastOne(traced.lights);
        b.corners = atLeastOne(traced.corners);
        b.triangles = atLeastOne(traced.triangles);
        b.nodes = atLeastOne(traced.nodes);
        b.leaves = atLeastOne(traced.leaves);
        b.encodeTable = bufferOf(device(), srgbBucketTable());
        b.pixels = bufferOf(device(), std::vector<uint32_t>(1));
        const auto outputOf = [&](uint64_t words) {
            Buffer<uint32_t> buffer(device(), words + kSentinels, "output");
            buffer.fill(kSentinel);
            return buffer;
        };
        b.colours = outputOf(samples);
        b.planeWords = outputOf(8ull * samples);
        b.counters = outputOf(gpu::kCounters);
        for (uint32_t i = 0; i < gpu::kCounters; ++i) b.counters.span()[i] = 0;
        b.waiting = outputOf(uint64_t(samples) * gpu::kWaitingWords * push.maxDepth);
        b.states = outputOf(uint64_t(samples) * gpu::kStateWords);
        Recorder recorder(device());
        recordTrace(recorder, push, traced, choices, exact, b);
        recorder.run(kWatchdogMs);
        const std::span<const uint32_t> words = b.planeWords.span();
        expectSame<uint32_t>("distance", distance, words.subspan(0, samples));
        expectSame<uint32_t>("object", object, words.subspan(samples, samples));
        for (uint32_t i = 0; i < 3; ++i) {
            std::vector<float> wantLinear, gotLinear, wantNormal, gotNormal;
            for (uint32_t k = 0; k < samples; ++k) {
                wantLinear.push_back(linear[3 * k + i]);
                gotLinear.push_back(gpu::realOf(int(words[(2 + i) * samples + k])));
                wantNormal.push_back(normal[3 * k + i]);
                gotNormal.push_back(gpu::realOf(int(words[(5 + i) * samples + k])));
            }
            expectSame<float>("linear", wantLinear, gotLinear);
            expectSame<float>("normal", wantNormal, gotNormal);
        }
        for (uint32_t i = 0; i < gpu::kCountUnfinished; ++i) EXPECT_EQ(counts[i], b.counters.span()[i]) << "counter " << i;
        EXPECT_EQ(b.counters.span()[gpu::kCountUnfinished], 0u);
        expectSentinels("colours", b.colours, samples);
        expectSentinels("planes", b.planeWords, 8ull * samples);
        expectSentinels("counters", b.counters, gpu::kCounters);
        expectSentinels("waiting", b.waiting, uint64_t(samples) * gpu::kWaitingWords * push.maxDepth);
        expectSentinels("states", b.states, uint64_t(samples) * gpu::kStateWords);
    }
}

INSTANTIATE_TEST_SUITE_P(Rows, TraceTwin,
                         ::testing::Values(Row{"mirrors", mirrors, 1, 1}, Row{"mirrors", mirrors, 19, 1}, Row{"mirrors", mirrors, 131, 67},
                                           Row{"glass", glass, 1, 19}, Row{"glass", glass, 67, 35}, Row{"inGlass", inGlass, 67, 35},
                                           Row{"farAway", farAway, 67, 35}, Row{"closeOutside", closeOutside, 67, 35},
                                           Row{"closeInside", closeInside, 67, 35}, Row{"level", level, 17, 9},
                                           Row{"meshesAmongMirrors", meshesAmongMirrors, 67, 35}, Row{"meshesAlone", meshesAlone, 131, 67}),
                         [](const auto& info) { return fmt::format("{}_{}x{}", info.param.name, info.param.width, info.param.height); });

// Sampling choices: each on a scene where it shows, by bands and by lists too.
struct SamplingRow {
    const char* name;
    Scene (*build)();
    void (*set)(RenderRequest&);
};
std::ostream& operator<<(std::ostream& out, const SamplingRow& r) { return out << r.name; }

class SamplingTwin : public OnDevice<::testing::TestWithParam<SamplingRow>> {};

TEST_P(SamplingTwin, LeavesTheSameBytesAndCounts) {
    const Scene scene = GetParam().build();
    RenderRequest request = requestOf(scene, 67, 35);
    request.rays.seed = 77;
    GetParam().set(request);
    const RenderResult twin = renderCpu(scene, request), onDevice = renderGpu(device(), scene, request);
    expectSameFrame(twin.frame, onDevice.frame);
    expectSameCounts(twin.counters, onDevice.counters);
    EXPECT_EQ(twin.counters.refinedPixels, onDevice.counters.refinedPixels);
    request.knobs.bandRows = 4;
    const RenderResult bands = renderGpu(device(), scene, request);
    expectSameFrame(twin.frame, bands.frame);
    expectSameCounts(twin.counters, bands.counters);
    if (request.rays.cutLevels) return;
    request.knobs.rayLimit = 1;
    const RenderResult list = renderGpu(device(), scene, request);
    expectSameFrame(twin.frame, list.frame);
    expectSameCounts(twin.counters, list.counters);
}

void jitterAll(RenderRequest& r) {
    r.samples = 4;
    r.rays.sampling = RayChoices::Sampling::centre;
    r.rays.jitterReflect = 0.1f;
    r.rays.jitterRefract = 0.05f;
    r.rays.jitterShadow = 0.2f;
}
INSTANTIATE_TEST_SUITE_P(
    Rows, SamplingTwin,
    ::testing::Values(SamplingRow{"random_on_glass", glass,
                                  [](RenderRequest& r) { r.samples = 4, r.rays.sampling = RayChoices::Sampling::random; }},
                      SamplingRow{"random_one_ray", mirrors, [](RenderRequest& r) { r.rays.sampling = RayChoices::Sampling::random; }},
                      SamplingRow{"jitter_on_glass", glass, jitterAll}, SamplingRow{"jitter_on_mirrors", mirrors, jitterAll},
                      SamplingRow{"jitter_on_meshes", meshesAmongMirrors, jitterAll},
                      SamplingRow{"corners_of_glass", glass, [](RenderRequest& r) { r.rays.sampling = RayChoices::Sampling::corners; }},
                      SamplingRow{"corners_of_mirrors", mirrors,
                                  [](RenderRequest& r) { r.rays.sampling = RayChoices::Sampling::corners, r.transparent = true; }},
                      SamplingRow{"adaptive_on_glass", glass, [](RenderRequest& r) { r.rays.sampling = RayChoices::Sampling::adaptive; }},
                      SamplingRow{"adaptive_on_mirrors", mirrors,
                                  [](RenderRequest& r) {
                                      r.rays.sampling = RayChoices::Sampling::adaptive, r.transparent = true, r.rays.jitterShadow = 0.1f;
                                  }},
                      SamplingRow{"notes_on_mirrors", mirrors, [](RenderRequest& r) { r.rays.sampling = RayChoices::Sampling::notes; }},
                      SamplingRow{"cut_levels", mirrors, [](RenderRequest& r) { r.rays.cutLevels = true, r.encoding = Encoding::linear; }}),
    [](const auto& info) { return std::string(info.param.name); });

using TraceDispatches = DeviceTest;

// With many lights the first dispatches have few rows; later ones grow, to rows in tiles.
TEST_F(TraceDispatches, LeaveTheSameBytesWhereverTheyEnd) {
    Scene scene = meshesAlone();
    scene.maxDepth = 1;
    for (Material& m : scene.materials) m.transmit = 0;
    while (scene.lights.size() < 40) {
        scene.lights.push_back(scene.lights[scene.lights.size() % 2]);
        scene.lights.back().intensity *= 0.05f;
        scene.lights.back().direction.x += 0.03 * double(scene.lights.size());
    }
    for (const uint32_t width : {301u, 512u}) {
        const RenderRequest request = requestOf(scene, width, 35);
        const RenderResult twin = renderCpu(scene, request), onDevice = renderGpu(device(), scene, request);
        SCOPED_TRACE(width);
        expectSameFrame(twin.frame, onDevice.frame);
        expectSameCounts(twin.counters, onDevice.counters);
    }
}

// The middle of the picture lies inside a tile, whose rays point into four octants. Boxes that excluded nothing across would open all of the tree, which
// has more leaves than a walk may take steps.
TEST_F(TraceDispatches, ATileAroundTheAxisOpensNoMoreThanItSees) {
    constexpr uint32_t kQuads = 150;
    Scene scene = rayScene();
    scene.camera->eye = {0, 0, 6};
    scene.maxDepth = 1;
    TriangleMesh mesh;
    mesh.faceMaterial = {0};
    for (uint32_t j = 0; j <= kQuads; ++j)
        for (uint32_t i = 0; i <= kQuads; ++i) {
            mesh.positions.emplace_back(6.0f * float(i) / kQuads - 3.0f, 6.0f * float(j) / kQuads - 3.0f, 0.05f * float((i + j) % 5));
            mesh.normals.emplace_back(0, 0, 1);
        }
    for (uint32_t j = 0; j < kQuads; ++j)
        for (uint32_t i = 0; i < kQuads; ++i) {
            const uint32_t a = j * (kQuads + 1) + i, b = a + kQuads + 1;
            mesh.triangles.push_back({{a, a + 1, b + 1}, 0});
            mesh.triangles.push_back({{a, b + 1, b}, 0});
        }
    mesh.vertexMaterial.resize(mesh.positions.size());
    addObject(scene, mesh);
    for (const glm::uvec2 size : {glm::uvec2(12, 6), glm::uvec2(6, 10), glm::uvec2(22, 34)})
        for (const float reflect : {0.0f, 0.2f}) {  // two samples an invocation, and one
            scene.materials[0].reflect = reflect;
            scene.maxDepth = reflect > 0 ? 2 : 1;
            const RenderRequest request = requestOf(scene, size.x, size.y);
            SCOPED_TRACE(fmt::format("{}x{}, reflect {}", size.x, size.y, reflect));
            expectSameFrame(renderCpu(scene, request).frame, renderGpu(device(), scene, request).frame);
        }
}

using TraceCounts = DeviceTest;

// Notes 18.1 and 18.4.1: one ray a level with mirrors alone, 2^depth - 1 with both children.
TEST_F(TraceCounts, AHallOfMirrorsIsLinearInDepthAndBothChildrenAreExponential) {
    for (const bool both : {false, true}) {
        Scene s = rayScene();
        // Panes on both sides of the eye; index 1 and straight looks: the refracted ray leaves through the other side of its pane.
        const uint32_t m = addRayMaterial(s, glm::vec3(0.2f), both ? 0.4f : 0.9f, both ? 0.4f : 0.0f, 1.0f);
        const int panes = both ? 40 : 1;
        for (int i = 0; i < panes; ++i)
            for (const double side : {-1.0, 1.0}) {
                PlaneShape p;
                p.point = {0, 0, side * (20 + i)};
                p.normal = {0, 0, -side};
                p.v = {0, side, 0};
                p.material = m;
                s.planes.push_back(p);
            }
        s.camera->eye = {0, 0, 0};
        s.camera->fovYDegrees = 0.01;
        for (uint32_t depth = 1; depth <= 8; ++depth) {
            RenderRequest request = requestOf(s, 3, 2);
            request.maxDepth = depth;
            const RenderResult device = renderGpu(this->device(), s, request);
            uint64_t rays = 0;
            for (const auto& r : device.counters.rays) rays += r.primary + r.reflected + r.refracted;
            EXPECT_EQ(rays, 6 * (both ? (uint64_t(1) << depth) - 1 : depth)) << "depth " << depth;
        }
    }
}

}  // namespace
}  // namespace plumb::test
