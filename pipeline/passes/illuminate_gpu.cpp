// SPDX-License-Identifier: MIT
#include "pipeline/passes/illuminate.h"

#include <spirv/illuminate.h>
#include <spirv/illuminate_native.h>

#include <algorithm>

namespace plumb {

namespace {

// Most points times lights of one dispatch: about 16 ns each on two cores, so below 100 ms.
constexpr uint32_t kLightedPointsPerDispatch = uint32_t(1) << 22;

}  // namespace

void recordIlluminate(Recorder& recorder, const gpu::IlluminatePush& push, const gpu::ShadeParts& parts, const Specialization& exact,
                      const Buffer<glm::vec4>& positions, const Buffer<glm::vec4>& normals, const Buffer<uint32_t>& pointMaterials,
                      const Buffer<gpu::ObjectRecord>& objects, const Buffer<gpu::MaterialRecord>& materials,
                      const Buffer<gpu::LightRecord>& lights, const Buffer<glm::vec4>& colours) {
    Specialization constants = exact;
    constants["kDiffuse"] = parts.diffuse;
    constants["kSpecular"] = parts.specular;
    constants["kPointLights"] = parts.point;
    constants["kPower"] = parts.power;
    constants["kDistantViewer"] = push.toward != glm::vec3(0);
    const bool native = parts.power == gpu::kPowerNative;
    for (uint32_t light = 0; light == 0 || light < push.lightCount; light += gpu::kLightsPerWindow) {
        gpu::IlluminatePush part = push;
        part.firstLight = push.firstLight + light;
        part.lightCount = std::min(gpu::kLightsPerWindow, push.lightCount - light);
        const uint32_t points = std::max(256u, kLightedPointsPerDispatch / std::max(1u, part.lightCount));
        for (uint32_t first = 0; first < push.pointCount; first += points) {
            part.firstPoint = push.firstPoint + first;
            part.pointCount = std::min(points, push.pointCount - first);
            recorder.dispatch(
                "illuminate", native ? spirv::illuminate_native : spirv::illuminate, (uint64_t(part.pointCount) + 3) / 4, part,
                {texels("positions", positions, View::texelF32x4), texels("normals", normals, View::texelF32x4),
                 texels("pointMaterials", pointMaterials, View::texelU32), storage("Objects", objects),
                 texels("materials", materials, View::texelF32x4), texels("lights", lights, View::texelF32x4), storage("Colours", colours)},
                constants);
        }
    }
}

}  // namespace plumb
