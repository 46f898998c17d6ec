// SPDX-License-Identifier: MIT
#include "pipeline/passes/bin.h"

#include <spirv/bin.h>

namespace plumb {

void recordBin(Recorder& recorder, BinStep step, gpu::BinPush push, uint32_t drawCount, uint32_t largeCount,
               const Specialization& exact, const Buffer<gpu::DrawTriangle>& draws, const Buffer<gpu::ScreenVertex>& screen,
               const Buffer<uint32_t>& large, const Buffer<uint32_t>& tiles, const Buffer<uint32_t>& entries) {
    Specialization constants = exact;
    constants[3] = step == BinStep::list;
    const char* label = step == BinStep::list ? "bin list" : "bin count";
    if (drawCount) {
        constants[2] = false;
        push.itemCount = drawCount;
        recorder.dispatch(label, spirv::bin, push.itemCount, push,
                          {texels(draws, View::texelU32x4), texels(screen, View::texelU32x4), texels(large, View::texelU32),
                           storage(tiles), storage(entries)},
                          constants);
    }
    if (largeCount) {
        constants[2] = true;
        if (uint64_t(largeCount) * push.rowsPerLarge > 0xffffffffu) throw renderError("a chunk has too many large triangles");
        push.itemCount = largeCount * push.rowsPerLarge;
        recorder.dispatch(label, spirv::bin, push.itemCount, push,
                          {texels(draws, View::texelU32x4), texels(screen, View::texelU32x4), texels(large, View::texelU32),
                           storage(tiles), storage(entries)},
                          constants);
    }
}

}  // namespace plumb
