// SPDX-License-Identifier: MIT
#include "pipeline/render/device_render.h"
#include "pipeline/render/notes.h"
#include "pipeline/render/stopwatch.h"
#include "pipeline/scene/plain_floats.h"

namespace plumb {

RenderResult renderGpu(Device& device, const Scene& scene, const RenderRequest& request) {
    const PlainFloats plain;
    if (request.fill != Fill::notes || request.shading == Shading::wire) return DeviceRender(device, scene, request).draw();
    const Stopwatch total(nullptr, "");
    const Prepared p = prepare(scene, request);
    RenderResult result;
    result.plan = p.plan;
    result.counters = p.counters;
    drawNotesGpu(device, scene, p, request, result);
    result.totalMs = total.elapsedMs();
    return result;
}

}  // namespace plumb
