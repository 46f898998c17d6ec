// SPDX-License-Identifier: MIT
#include "pipeline/passes/spheres.h"

#include "host/error.h"

#include <fmt/core.h>
#include <spirv/spheres.h>
#include <spirv/spheres_native.h>
#include <algorithm>
#include <utility>

namespace plumb {

namespace {

// Most spheres tried and lights added by one dispatch: a few ns each on two cores, so that no dispatch runs into the watchdog.
constexpr uint64_t kWorkPerDispatch = uint64_t(1) << 25;

template <class T>
Buffer<T> uploaded(Device& device, std::span<const T> from, const char* name) {
    Buffer<T> buffer(device, std::max<size_t>(1, from.size()), name);
    buffer.fill(0);
    buffer.upload(from);
    return buffer;
}

}  // namespace

SphereCanvas spheresGpu(Device& device, Recorder& recorder, const SphereList& list, const SphereLight& light, const Specialization& exact,
                        double watchdogMs) {
    const uint64_t pixels = uint64_t(list.width) * uint64_t(list.height), range = device.limits().storageRangeBytes;
    const std::pair<const char*, uint64_t> needs[] = {{"pixels", pixels * sizeof(glm::vec4)},
                                                      {"spheres", list.discs.size() * sizeof(gpu::SphereDisc)},
                                                      {"spheres of rows", list.rowDiscs.size() * sizeof(uint32_t)}};
    for (const auto& [what, bytes] : needs)
        if (bytes > range)
            throw renderError(fmt::format("--fill notes: {} of {} bytes exceed a binding of the device ({} bytes); the twin draws it", what,
                                          bytes, range));
    Specialization constants = exact;
    constants["kDiffuse"] = light.parts.diffuse;
    constants["kSpecular"] = light.parts.specular;
    constants["kPointLights"] = light.parts.point;
    constants["kPower"] = light.parts.power;
    const auto discs = uploaded<gpu::SphereDisc>(device, list.discs, "spheres");
    const auto rowFirst = uploaded<uint32_t>(device, list.rowFirst, "rows of spheres");
    const auto rowDiscs = uploaded<uint32_t>(device, list.rowDiscs, "spheres of rows");
    const auto materials = uploaded<gpu::MaterialRecord>(device, light.materials, "materials");
    const auto lights = uploaded<gpu::LightRecord>(device, light.lights, "lights");
    Buffer<float> depth(device, pixels, "sphere depths");
    Buffer<uint32_t> owner(device, pixels, "sphere owners");
    Buffer<glm::vec4> colour(device, pixels, "sphere colours");
    gpu::SpheresPush push{};
    push.width = uint32_t(list.width);
    push.lightCount = uint32_t(light.lights.size());
    push.wholeHeights = light.wholeHeights;
    push.unit = light.unit;
    const auto workOf = [&](uint32_t row) {
        return uint64_t(list.width) * (1 + light.lights.size() + list.rowFirst[row + 1] - list.rowFirst[row]);
    };
    const bool native = light.parts.power == gpu::kPowerNative;
    while (push.firstRow < uint32_t(list.height)) {
        uint64_t work = workOf(push.firstRow);
        push.rowCount = 1;
        while (push.firstRow + push.rowCount < uint32_t(list.height) && work + workOf(push.firstRow + push.rowCount) <= kWorkPerDispatch)
            work += workOf(push.firstRow + push.rowCount++);
        recorder.dispatch("spheres", native ? spirv::spheres_native : spirv::spheres, uint64_t(push.width) * push.rowCount, push,
                          {storage("Discs", discs), storage("RowFirst", rowFirst), storage("RowDiscs", rowDiscs),
                           texels("materials", materials, View::texelF32x4), texels("lights", lights, View::texelF32x4),
                           storage("Depths", depth), storage("Owners", owner), storage("Colours", colour)},
                          constants);
        push.firstRow += push.rowCount;
    }
    recorder.run(watchdogMs);
    SphereCanvas canvas;
    canvas.depth.assign(depth.span().begin(), depth.span().end());
    canvas.owner.assign(owner.span().begin(), owner.span().end());
    canvas.colour.assign(colour.span().begin(), colour.span().end());
    return canvas;
}

}  // namespace plumb
