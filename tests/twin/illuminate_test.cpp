// SPDX-License-Identifier: MIT
#include "pipeline/passes/illuminate.h"

#include "tests/twin/pass_frame.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <ostream>
#include <span>
#include <vector>

namespace plumb::test {
namespace {

struct Row {
    const char* name;
    uint32_t first, count, lights;
    bool diffuse, specular, point;
    uint32_t power = gpu::kPowerExact;
    bool distant = false;
};
std::ostream& operator<<(std::ostream& out, const Row& r) { return out << r.name; }

class IlluminateTwin : public OnDevice<::testing::TestWithParam<Row>> {};

std::vector<gpu::MaterialRecord> materialsOfEveryKind() {
    std::vector<gpu::MaterialRecord> m;
    for (float n : {0.0f, 0.5f, 1.0f, 32.0f, 1000.0f, 1e6f})
        m.push_back({{0.01f, 0.02f, 0.03f}, n, {0.7f, 0.5f, 0.3f}, n == 0 ? 1.0f : 0.0f, {0.4f, 0.6f, 0.8f}, 0});
    return m;
}

std::vector<gpu::LightRecord> lightsOfEveryKind(uint32_t count) {
    Random r(37);
    std::vector<gpu::LightRecord> lights;
    for (uint32_t i = 0; i < count; ++i) {
        const bool point = i % 4 != 0;
        const glm::vec3 d = r.direction();
        lights.push_back({point ? d * 5.0f : d, point ? 1.0f : 0.0f, {0.5f + float(i), 0.4f, 0.3f}, float(point ? (i - 1) % 4 : 0)});
    }
    return lights;
}

TEST_P(IlluminateTwin, LeavesTheSameBytes) {
    const Row& row = GetParam();
    const uint32_t total = row.first + row.count;
    const SceneCase c{"soupSmall", soupSmall, 131, 67};
    const std::vector<gpu::ObjectRecord> objects = {{}, prepare(c.scene(), requestOf(c)).list.objects[0]};
    const std::vector<gpu::MaterialRecord> materials = materialsOfEveryKind();
    std::vector<gpu::LightRecord> lights = lightsOfEveryKind(row.lights);
    Random r(41);
    std::vector<glm::vec4> positions, normals;
    std::vector<uint32_t> material;
    for (uint32_t i = 0; i < total; ++i) {
        const glm::vec3 d = r.direction();
        positions.emplace_back(d * float(r(0.01, 40)), 1.0f);
        // Every third normal looks straight at the eye (highlights), every seventh away from it.
        normals.emplace_back(i % 3 == 0 ? -d : i % 7 == 0 ? d : r.direction(), 0.0f);
        material.push_back(r.below(uint32_t(materials.size())));
    }
    // Lights exactly at a point, one of each attenuation where there are so many.
    uint32_t at = 2;
    for (gpu::LightRecord& l : lights)
        if (l.kind != 0 && at < std::min(total, 6u)) {
            const glm::vec3 p(positions[at++]);
            const gpu::ObjectRecord& o = objects[1];
            l.position = {gpu::rowTimesPoint(o.world0, p), gpu::rowTimesPoint(o.world1, p), gpu::rowTimesPoint(o.world2, p)};
        }
    const gpu::ShadeParts parts{row.diffuse, row.specular, row.point, row.power};
    const gpu::IlluminatePush push{
        0, row.first, row.count, 1, 0, uint32_t(lights.size()), row.distant ? glm::vec3(0.6f, 0, 0.8f) : glm::vec3(0)};
    std::vector<glm::vec4> want(total);
    illuminateCpu(push, parts, positions, normals, material, objects, materials, lights, want, 1);
    for (const Specialization& exact : exactForms(device())) {
        Recorder recorder(device());
        auto p = bufferOf(device(), positions), n = bufferOf(device(), normals);
        auto m = bufferOf(device(), material);
        auto o = bufferOf(device(), objects);
        auto k = bufferOf(device(), materials);
        auto l = bufferOf(device(), lights);
        Buffer<glm::vec4> got(device(), total + kSentinels, "colours");
        got.fill(kSentinel);
        recordIlluminate(recorder, push, parts, exact, p, n, m, o, k, l, got);
        recorder.run(kWatchdogMs);
        const auto floats = [&](std::span<const glm::vec4> v) {
            const std::span<const glm::vec4> s = v.subspan(row.first, row.count);
            return std::span<const float>(&s[0].x, s.size() * 4);
        };
        expectSame<float>("illuminate", floats(want), floats(got.span()),
                          [](size_t i) { return fmt::format("point {} channel {}", i / 4, i % 4); });
        expectSentinels("illuminate", got, total);
    }
    const bool anyLight = std::any_of(want.begin() + row.first, want.end(), [](const glm::vec4& v) { return v.x > 0.01f; });
    EXPECT_TRUE(anyLight || row.lights == 0 || row.count == 1 || !(row.diffuse || row.specular))
        << "no point is lit: this row shows nothing";
}

INSTANTIATE_TEST_SUITE_P(
    Rows, IlluminateTwin,
    ::testing::Values(Row{"one_point", 0, 1, 1, true, true, true}, Row{"no_light", 0, 19, 0, true, true, true},
                      Row{"nineteen", 0, 19, 1, true, true, true}, Row{"from_3", 3, 61, 2, true, true, true},
                      Row{"every_kind", 0, 4099, 9, true, true, true}, Row{"diffuse_only", 0, 257, 9, true, false, true},
                      Row{"specular_only", 0, 257, 9, false, true, true}, Row{"schlick", 0, 257, 9, true, true, true, gpu::kPowerSchlick},
                      Row{"distant_viewer", 0, 257, 9, true, true, true, gpu::kPowerExact, true},
                      Row{"neither", 0, 257, 9, false, false, true}, Row{"directional_only", 0, 257, 1, true, true, false},
                      Row{"forty_lights", 0, 131, 40, true, true, true},
                      Row{"two_windows", 3, 131, gpu::kLightsPerWindow + 1, true, true, true},
                      Row{"many_dispatches", 5, 4099, 2 * gpu::kLightsPerWindow, true, true, true}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace plumb::test
