// SPDX-License-Identifier: MIT
#include "pipeline/passes/bin.h"

#include <spirv/bin.h>

namespace plumb {

void recordBin(Recorder& recorder, gpu::BinPush push, const BinCounts& counts, const Specialization& exact, const BinBuffers& b) {
    const auto record = [&](const char* label, uint32_t count, const Binding& items, const Buffer<uint32_t>& overflow, bool strips) {
        Specialization constants = exact;
        constants["kStrips"] = strips;
        constants["kListed"] = !strips && counts.listed;
        constants["kWide"] = strips && counts.wide;
        push.itemCount = count;
        recorder.dispatch(label, spirv::bin, count, push,
                          {texels("draws", b.draws, View::texelU32x4), texels("screen", b.screen, View::texelU32x4), items,
                           storage("Tiles", b.tiles), storage("Entries", b.entries), storage("Overflow", overflow)},
                          constants);
    };
    record("bin", counts.walked, texels("items", b.listed, View::texelU32x2), b.walkOverflow, false);
    record("bin strips", counts.strips, texels("items", b.strips, View::texelU32x4), b.stripOverflow, true);
}

}  // namespace plumb
