// SPDX-License-Identifier: MIT
// A picture of traced rays: records from the scene, then the trace pass on either side in bands of rows.
#pragma once

#include "pipeline/passes/trace.h"
#include "pipeline/render/prepare.h"

#include <cstdint>
#include <memory>
#include <span>

namespace plumb {

// Records of what rays meet, and what the kernel may leave out. Throws Error(input) for what is beyond the stated limits.
TraceScene traceSceneOf(const Scene& scene, const Prepared& prepared);
TraceChoices traceChoicesOf(const Scene& scene, const RenderRequest& request, const Prepared& prepared, const TraceScene& traced);

// Rays and records of a frame; which samples, and the pitch of the buffers, are the caller's.
gpu::TracePush tracePushOf(const Prepared& prepared, const RenderRequest& request, const TraceScene& traced);

// Loop iterations that one ray costs on the device at most, feelers included.
uint64_t stepsOfRay(const TraceScene& traced);

void traceFrameCpu(const Prepared& prepared, const Scene& scene, const RenderRequest& request, RenderResult& result);
// A picture that stays on the device, drawn again and again: nothing is uploaded after the first.
class ResidentTrace {
public:
    ResidentTrace(Device& device, const Scene& scene, const RenderRequest& request);
    ~ResidentTrace();
    ResidentTrace(const ResidentTrace&) = delete;
    ResidentTrace& operator=(const ResidentTrace&) = delete;
    bool draw();  // false, and nothing is drawn: the picture takes samples that are resolved, or several bands
    std::span<const uint32_t> colours() const;  // alpha 0 where nothing is hit
    uint32_t pitch() const;
    RenderCounters counters() const;  // of the last draw()
    Recorder& recorder();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

void traceFrameGpu(Device& device, const Prepared& prepared, const Scene& scene, const RenderRequest& request, RenderResult& result);

}  // namespace plumb
