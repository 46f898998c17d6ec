// SPDX-License-Identifier: MIT
// A picture of traced rays: records from the scene, then the trace pass on either side in bands of rows.
#pragma once

#include "pipeline/passes/trace.h"
#include "pipeline/render/prepare.h"
#include "pipeline/render/technique.h"

#include <cstdint>
#include <memory>
#include <span>

namespace plumb {

// Records of the scene for rays. Throws Error(input) for a scene beyond the stated limits. traceChoicesOf(): parts of the kernel that this
// scene needs.
TraceScene traceSceneOf(const Scene& scene, const Prepared& prepared);
TraceChoices traceChoicesOf(const Scene& scene, const RenderRequest& request, const Prepared& prepared, const TraceScene& traced);

// States in the plan where spheres ask for a form that is more accurate than the usual one: those that are far for their radius, or close to
// the eye. Throws Error(input) as traceSceneOf().
void stateSphereForms(const Scene& scene, Prepared& prepared);

// Push constants of a frame. The caller sets the samples and the pitch of the buffers.
gpu::TracePush tracePushOf(const Prepared& prepared, const RenderRequest& request, const TraceScene& traced);

// Loop iterations that one ray costs on the device at most, shadow rays included.
uint64_t stepsOfRay(const TraceScene& traced);

void traceFrameCpu(const Prepared& prepared, const Scene& scene, const RenderRequest& request, PlaneWriter& writer, RenderResult& result);
void traceFrameGpu(Device& device, const Prepared& prepared, const Scene& scene, const RenderRequest& request, PlaneWriter& writer,
                   RenderResult& result);
// A picture of one sample a pixel that stays on the device: nothing is uploaded after the first draw.
std::unique_ptr<ResidentPicture> residentTrace(Device& device, const Prepared& prepared, const Scene& scene, const RenderRequest& request);

}  // namespace plumb
