// SPDX-License-Identifier: MIT
#include "pipeline/passes/bin.h"

#include <spirv/bin.h>

namespace plumb {

void recordBin(Recorder& recorder, gpu::BinPush push, const BinCounts& counts, const Specialization& exact, const BinBuffers& b) {
    const auto record = [&](const char* label, uint32_t items, const Bound& of, const Buffer<uint32_t>& marks, bool strips) {
        Specialization constants = exact;
        constants[2] = strips;
        constants[3] = !strips && counts.listed;
        constants[4] = strips && counts.wide;
        push.itemCount = items;
        recorder.dispatch(label, spirv::bin, items, push,
                          {texels(b.draws, View::texelU32x4), texels(b.screen, View::texelU32x4), of, storage(b.tiles), storage(b.entries),
                           storage(marks)},
                          constants);
    };
    if (counts.walked) record("bin", counts.walked, texels(b.listed, View::texelU32x2), b.walkMarks, false);
    if (counts.strips) record("bin strips", counts.strips, texels(b.strips, View::texelU32x4), b.stripMarks, true);
}

}  // namespace plumb
