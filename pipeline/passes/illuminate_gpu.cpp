// SPDX-License-Identifier: MIT
#include "pipeline/passes/illuminate.h"

#include <spirv/illuminate.h>

namespace plumb {

void recordIlluminate(Recorder& recorder, const gpu::IlluminatePush& push, const gpu::ShadeParts& parts,
                      const Specialization& exact, const Buffer<glm::vec4>& positions, const Buffer<glm::vec4>& normals,
                      const Buffer<uint32_t>& pointMaterials, const Buffer<gpu::ObjectRecord>& objects,
                      const Buffer<gpu::MaterialRecord>& materials, const Buffer<gpu::LightRecord>& lights,
                      const Buffer<glm::vec4>& colours) {
    Specialization constants = exact;
    constants[2] = parts.diffuse;
    constants[3] = parts.specular;
    constants[4] = parts.point;
    constants[5] = parts.power;
    recorder.dispatch("illuminate", spirv::illuminate, (uint64_t(push.pointCount) + 3) / 4, push,
                      {texels(positions, View::texelF32x4), texels(normals, View::texelF32x4),
                       texels(pointMaterials, View::texelU32), storage(objects), texels(materials, View::texelF32x4),
                       texels(lights, View::texelF32x4), storage(colours)},
                      constants);
}

}  // namespace plumb
