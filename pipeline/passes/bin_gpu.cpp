// SPDX-License-Identifier: MIT
#include "pipeline/passes/bin.h"

#include <algorithm>
#include <spirv/bin.h>
#include <spirv/slots.h>

namespace plumb {

namespace {

void recordWalk(Recorder& recorder, const char* label, const gpu::BinPush& push, const Specialization& constants, const BinBuffers& b,
                const Buffer<uint32_t>& indices) {
    recorder.dispatch(label, spirv::bin, push.itemCount, push,
                      {texels(b.draws, View::texelU32x4), texels(b.screen, View::texelU32x4), texels(indices, View::texelU32),
                       storage(b.tiles), storage(b.entries)},
                      constants);
}

}  // namespace

void recordBin(Recorder& recorder, BinStep step, gpu::BinPush push, const BinCounts& counts, const Specialization& exact,
               const BinBuffers& b) {
    Specialization constants = exact;
    constants[3] = step == BinStep::list;
    const char* label = step == BinStep::list ? "bin list" : "bin count";
    if (counts.counted && counts.drawn && step == BinStep::list) {
        push.itemCount = counts.drawn;
        recorder.dispatch(label, spirv::slots, push.itemCount, push,
                          {texels(b.slots, View::texelU32x4), texels(b.tiles, View::texelU32), storage(b.entries)}, exact);
    }
    const uint32_t walked = counts.counted ? counts.medium : counts.drawn;
    if (walked) {
        constants[2] = false;
        constants[4] = counts.counted;
        push.itemCount = walked;
        recordWalk(recorder, label, push, constants, b, b.medium);
    }
    constants[2] = true;
    constants[4] = false;
    const uint32_t rows[] = {std::min(kLowRows, push.tilesY), push.tilesY};
    const uint32_t ends[] = {counts.low, counts.large};
    push.firstLarge = 0;
    for (int i = 0; i < 2; ++i) {
        const uint64_t items = uint64_t(ends[i] - push.firstLarge) * rows[i];
        if (items == 0) continue;
        if (items > 0xffffffffu) throw renderError("a chunk has too many large triangles");
        push.rowsPerLarge = rows[i];
        push.itemCount = uint32_t(items);
        recordWalk(recorder, label, push, constants, b, b.large);
        push.firstLarge = ends[i];
    }
}

}  // namespace plumb
