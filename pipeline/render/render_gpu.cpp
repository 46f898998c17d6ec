// SPDX-License-Identifier: MIT
#include "pipeline/render/notes/notes.h"
#include "pipeline/render/notes/spheres_frame.h"
#include "pipeline/render/raster/device_render.h"
#include "pipeline/render/rays/trace_frame.h"
#include "pipeline/render/stopwatch.h"
#include "pipeline/scene/plain_floats.h"

namespace plumb {

RenderResult renderGpu(Device& device, const Scene& scene, const RenderRequest& request) {
    const PlainFloats plain;
    const bool rays = request.shading == Shading::ray, notes = request.fill == Fill::notes && request.shading != Shading::wire;
    if (!rays && !notes) return DeviceRender(device, scene, request).draw();
    const Stopwatch total(nullptr, "");
    const Prepared p = prepare(scene, request);
    RenderResult result;
    result.plan = p.plan;
    result.counters = p.counters;
    if (rays)
        traceFrameGpu(device, p, scene, request, result);
    else if (drawsSpheres(scene, request))
        drawSpheresGpu(device, scene, p, request, result);
    else
        drawNotesGpu(device, scene, p, request, result);
    result.plan.close(result.times);
    result.totalMs = total.elapsedMs();
    return result;
}

}  // namespace plumb
