// SPDX-License-Identifier: MIT
#include "pipeline/passes/resolve.h"

#include <spirv/resolve.h>
#include <spirv/resolve_native.h>

namespace plumb {

void recordResolve(Recorder& recorder, const gpu::ResolvePush& push, uint32_t encoding, bool linearOut, const Specialization& exact,
                   const RawBuffer& samplePlanes, const Buffer<uint32_t>& encodeTable, const Buffer<glm::uvec4>& colours,
                   const Buffer<glm::vec4>& linear) {
    Specialization constants = exact;
    constants["kEncoding"] = encoding;
    constants["kLinearOut"] = linearOut;
    recorder.dispatch("resolve", encoding == gpu::kEncodeNative ? spirv::resolve_native : spirv::resolve, push.pixelQuads, push,
                      {texels("samplePlanes", samplePlanes, View::texelU32), texels("encodeTable", encodeTable, View::texelU32),
                       storage("Colours", colours), storage("Linear", linear)},
                      constants);
}

}  // namespace plumb
