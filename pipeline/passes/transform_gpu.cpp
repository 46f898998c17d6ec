// SPDX-License-Identifier: MIT
#include "pipeline/passes/transform.h"

#include <spirv/transform.h>

namespace plumb {

void recordTransform(Recorder& recorder, const gpu::TransformPush& push, Normals writeNormals, const Specialization& exact,
                     const Buffer<glm::vec4>& positions, const Buffer<glm::vec4>& normals,
                     const Buffer<gpu::ObjectRecord>& objects, const Buffer<gpu::ScreenVertex>& screen,
                     const Buffer<glm::vec4>& carried) {
    Specialization constants = exact;
    constants[2] = writeNormals != Normals::none;
    constants[3] = writeNormals == Normals::unit;
    recorder.dispatch("transform", spirv::transform, push.vertexCount, push,
                      {texels(positions, View::texelF32x4), texels(normals, View::texelF32x4), storage(objects), storage(screen),
                       storage(carried)},
                      constants);
}

}  // namespace plumb
