// SPDX-License-Identifier: MIT
#include "tests/golden/lit.h"

#include "tests/twin/pass_frame.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace plumb::golden {

std::vector<glm::vec4> lit(const std::vector<LitPoint>& points, const std::vector<gpu::MaterialRecord>& materials,
                           const std::vector<gpu::LightRecord>& lights) {
    using namespace plumb::test;
    std::vector<glm::vec4> positions, normals;
    std::vector<uint32_t> material;
    for (const LitPoint& p : points) {
        positions.emplace_back(glm::vec3(-p.toViewer), 1.0f);  // relative to the eye
        normals.emplace_back(glm::vec3(p.normal), 0.0f);
        material.push_back(p.material);
    }
    gpu::ObjectRecord identity{};
    identity.world0 = identity.normal0 = {1, 0, 0, 0};
    identity.world1 = identity.normal1 = {0, 1, 0, 0};
    identity.world2 = identity.normal2 = {0, 0, 1, 0};
    const std::vector<gpu::ObjectRecord> objects = {identity};
    bool point = false;
    for (const gpu::LightRecord& l : lights) point |= l.kind != 0;
    const gpu::ShadeParts parts{true, true, point};
    const gpu::IlluminatePush push{0, 0, uint32_t(points.size()), 0, 0, uint32_t(lights.size())};
    std::vector<glm::vec4> want(points.size());
    illuminateCpu(push, parts, positions, normals, material, objects, materials, lights, want, 1);
    if (!DeviceEnvironment::device()) {
        ADD_FAILURE() << "no device";
        return want;
    }
    Device& device = *DeviceEnvironment::device();
    for (const Specialization& exact : exactForms(device)) {
        Recorder recorder(device);
        auto p = bufferOf(device, positions), n = bufferOf(device, normals);
        auto m = bufferOf(device, material);
        auto o = bufferOf(device, objects);
        auto k = bufferOf(device, materials);
        auto l = bufferOf(device, lights);
        Buffer<glm::vec4> got(device, points.size(), "colours");
        recordIlluminate(recorder, push, parts, exact, p, n, m, o, k, l, got);
        recorder.run(kWatchdogMs);
        expectSame<float>("illuminate", std::span<const float>(&want[0].x, want.size() * 4),
                          std::span<const float>(&got.span()[0].x, want.size() * 4));
    }
    expectNoValidationMessages(device);
    return want;
}

}  // namespace plumb::golden
