// SPDX-License-Identifier: MIT
#include "pipeline/passes/transform.h"

#include "host/binary64.h"
#include "host/error.h"

#include <spirv/transform.h>
#include <spirv/transform_block.h>
#include <spirv/transform_double.h>
#include <string>

namespace plumb {

namespace {

Specialization constantsOf(Normals writeNormals, const Specialization& exact) {
    Specialization constants = exact;
    constants["kWriteNormals"] = writeNormals != Normals::none;
    constants["kUnitNormals"] = writeNormals == Normals::unit;
    return constants;
}

}  // namespace

void recordTransform(Recorder& recorder, const gpu::TransformPush& push, Normals writeNormals, const Specialization& exact,
                     const Buffer<glm::vec4>& positions, const Buffer<glm::vec4>& normals, const Buffer<gpu::ObjectRecord>& objects,
                     const Buffer<gpu::ScreenVertex>& screen, const Buffer<glm::vec4>& attributes) {
    recorder.dispatch("transform", spirv::transform, push.vertexCount, push,
                      {texels("positions", positions, View::texelF32x4), texels("normals", normals, View::texelF32x4),
                       storage("Objects", objects), storage("Screen", screen), storage("Attributes", attributes)},
                      constantsOf(writeNormals, exact));
}

void recordLongTransform(Recorder& recorder, Device& device, const gpu::TransformPush& push, Normals writeNormals,
                         const Specialization& exact, const Buffer<glm::vec4>& positions, const Buffer<glm::vec4>& normals,
                         const Buffer<gpu::ObjectRecord>& objects, const Buffer<gpu::ScreenVertex>& screen,
                         const Buffer<glm::vec4>& attributes, const LongBuffers& longer) {
    const bool binary64 = longer.precision == Precision::fp64;
    if (binary64)
        if (const std::string lacks = lacksBinary64(device); !lacks.empty()) throw usageError("transform=fp64: " + lacks);
    recorder.dispatch(
        "transform", binary64 ? spirv::transform_double : spirv::transform_block, push.vertexCount, push,
        {texels("positions", positions, View::texelF32x4), texels("normals", normals, View::texelF32x4), storage("Objects", objects),
         storage("Screen", screen), storage("Attributes", attributes), storage("Longs", longer.records), storage("Clip", longer.clipSpace)},
        constantsOf(writeNormals, exact));
}

}  // namespace plumb
