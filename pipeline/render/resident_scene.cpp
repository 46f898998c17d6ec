// SPDX-License-Identifier: MIT
#include "pipeline/render/device_render.h"
#include "pipeline/scene/plain_floats.h"

#include <utility>

namespace plumb {

struct ResidentScene::Impl {
    Device& device;
    Scene scene;                          // for pictures that are not drawn in place
    RenderRequest request;
    std::unique_ptr<DeviceRender> render;
    RenderResult whole;
    std::vector<PassTime> times;
    bool inPlace = true;

    Impl(Device& d, const Scene& s, const RenderRequest& r) : device(d), scene(s), request(r) {
        request.planes = kPlaneColour;
        request.transparent = true;       // alpha is coverage
        const PlainFloats plain;
        render = std::make_unique<DeviceRender>(device, scene, request);
    }
};

ResidentScene::ResidentScene(Device& device, const Scene& scene, const RenderRequest& request)
    : impl_(std::make_unique<Impl>(device, scene, request)) {}
ResidentScene::~ResidentScene() = default;

ResidentScene::Picture ResidentScene::draw() {
    Impl& v = *impl_;
    if (v.inPlace) v.inPlace = v.render->drawInPlace();
    if (v.inPlace) {
        const GpuFrame& frame = v.render->frame();
        return {frame.colourWords().data(), v.request.width, v.request.height, frame.rowPixels()};
    }
    v.render.reset();                     // its buffers make room
    v.whole = renderGpu(v.device, v.scene, v.request);
    v.times.insert(v.times.end(), v.whole.times.begin(), v.whole.times.end());
    return {v.whole.frame.rgba.data(), v.request.width, v.request.height, v.request.width};
}

bool ResidentScene::resident() const { return impl_->inPlace; }
RenderCounters ResidentScene::counters() const { return impl_->inPlace ? impl_->render->counters() : impl_->whole.counters; }
std::vector<PassTime> ResidentScene::timePasses() {
    takeTimes();
    if (impl_->inPlace) impl_->render->frame().recorder().timeApart(impl_->request.watchdogMs);
    draw();
    if (impl_->inPlace) impl_->render->frame().recorder().timeApart(0);
    return takeTimes();
}
std::vector<PassTime> ResidentScene::takeTimes() {
    return impl_->inPlace ? impl_->render->frame().recorder().takeTimes() : std::exchange(impl_->times, {});
}

}  // namespace plumb
