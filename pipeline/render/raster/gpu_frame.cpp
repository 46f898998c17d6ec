// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/gpu_frame.h"

#include <cstdint>

namespace plumb {

GpuFrame::GpuFrame(Device& device, const Prepared& prepared, double watchdogMs)
    : prepared_(prepared),
      watchdogMs_(watchdogMs),
      budget_(device.limits(), device.memoryBudgetBytes()),
      recorder_(device),
      geometry_(device, recorder_, prepared, budget_, watchdogMs),
      tiles_(device, recorder_, budget_, watchdogMs),
      canvas_(device, recorder_, prepared, watchdogMs) {
    recorder_.allow(prepared.plan.labels(RunsOn::device));
}

void GpuFrame::setupForBin() {
    geometry_.assignSlots();
    geometry_.setUp(tiles_.forSetup(geometry_.slots().drawCount, geometry_.chunk().frame));
}

void GpuFrame::setup() {
    setupForBin();
    recorder_.run(watchdogMs_);
}

void GpuFrame::beginBand(const gpu::FrameBox& band, uint32_t planes) {
    tiles_.begin(band);
    canvas_.begin(tiles_, planes);
}

}  // namespace plumb
