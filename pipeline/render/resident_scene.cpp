// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/device_render.h"
#include "pipeline/render/rays/trace_frame.h"
#include "pipeline/scene/plain_floats.h"

#include <memory>
#include <utility>
#include <vector>

namespace plumb {

struct ResidentScene::Impl {
    Device& device;
    Scene scene;  // for pictures that are not drawn in place
    RenderRequest request;
    std::unique_ptr<DeviceRender> render;  // or, of rays:
    std::unique_ptr<ResidentTrace> trace;
    RenderResult whole;
    std::vector<PassTime> times;
    bool inPlace = true;

    Impl(Device& d, const Scene& s, const RenderRequest& r) : device(d), scene(s), request(r) {
        request.planes = kPlaneColour;
        request.transparent = true;  // alpha is coverage
        request.repeated = true;
        const PlainFloats plain;
        if (request.shading == Shading::ray)
            trace = std::make_unique<ResidentTrace>(device, scene, request);
        else
            render = std::make_unique<DeviceRender>(device, scene, request);
    }
};

ResidentScene::ResidentScene(Device& device, const Scene& scene, const RenderRequest& request)
    : impl_(std::make_unique<Impl>(device, scene, request)) {}
ResidentScene::~ResidentScene() = default;

ResidentScene::Picture ResidentScene::draw() {
    Impl& v = *impl_;
    if (v.inPlace) v.inPlace = v.trace ? v.trace->draw() : v.render->drawInPlace();
    if (v.inPlace && v.trace) return {v.trace->colours().data(), v.request.width, v.request.height, v.trace->pitch()};
    if (v.inPlace) {
        const GpuFrame& frame = v.render->frame();
        return {frame.colourWords().data(), v.request.width, v.request.height, frame.rowPixels()};
    }
    v.render.reset();  // their buffers make room
    v.trace.reset();
    v.whole = renderGpu(v.device, v.scene, v.request);
    v.times.insert(v.times.end(), v.whole.times.begin(), v.whole.times.end());
    return {v.whole.frame.rgba.data(), v.request.width, v.request.height, v.request.width};
}

bool ResidentScene::resident() const { return impl_->inPlace; }
RenderCounters ResidentScene::counters() const {
    if (!impl_->inPlace) return impl_->whole.counters;
    return impl_->trace ? impl_->trace->counters() : impl_->render->counters();
}
namespace {
Recorder& recorderOf(DeviceRender* render, ResidentTrace* trace) { return trace ? trace->recorder() : render->frame().recorder(); }
}  // namespace
std::vector<PassTime> ResidentScene::timePasses() {
    takeTimes();
    if (impl_->inPlace) recorderOf(impl_->render.get(), impl_->trace.get()).timeApart(impl_->request.watchdogMs);
    draw();
    if (impl_->inPlace) recorderOf(impl_->render.get(), impl_->trace.get()).timeApart(0);
    return takeTimes();
}
std::vector<PassTime> ResidentScene::takeTimes() {
    return impl_->inPlace ? recorderOf(impl_->render.get(), impl_->trace.get()).takeTimes() : std::exchange(impl_->times, {});
}

}  // namespace plumb
