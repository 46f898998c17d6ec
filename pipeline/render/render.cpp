// SPDX-License-Identifier: MIT
// Draws a scene once, by whichever technique draws the request, on either side.
#include "pipeline/render/render.h"

#include "pipeline/render/stopwatch.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/plain_floats.h"

#include <utility>

namespace plumb {

PreparedPicture::PreparedPicture(const Scene& scene, const RenderRequest& request, Prepared prepared)
    : scene_(scene), request_(request), p_(std::move(prepared)) {}

RenderResult PreparedPicture::draw(Device* device) {
    RenderResult result;
    result.plan = p_.plan;
    result.counters = p_.counters;
    PlaneWriter writer(p_, request_, result.frame);
    draw(device, writer, result);
    result.counters.transformed = p_.list.positions.size();
    result.counters.lightsAdded = result.counters.illuminations * p_.list.lights.size();
    result.plan.close(result.times);
    return result;
}

RenderResult render(Device* device, const Scene& scene, const RenderRequest& request) {
    const PlainFloats plain;
    const Stopwatch total(nullptr, "");
    RenderResult result = pictureOf(scene, request, device ? RunsOn::device : RunsOn::twin)->draw(device);
    result.totalMs = total.elapsedMs();
    return result;
}

RenderResult renderCpu(const Scene& scene, const RenderRequest& request) { return render(nullptr, scene, request); }

}  // namespace plumb
