// SPDX-License-Identifier: MIT
#include "pipeline/render/render.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/plain_floats.h"

#include <memory>
#include <utility>
#include <vector>

namespace plumb {

struct ResidentScene::Impl {
    Device& device;
    const Scene scene;
    RenderRequest request;
    std::unique_ptr<PreparedPicture> picture;
    std::unique_ptr<ResidentPicture> resident;  // none: every draw is a whole one
    RenderResult whole;
    std::vector<PassTime> times;

    Impl(Device& d, const Scene& s, const RenderRequest& r) : device(d), scene(s), request(r) {
        request.planes = kPlaneColour;
        request.transparent = true;  // alpha is coverage
        request.repeated = true;
        const PlainFloats plain;
        picture = pictureOf(scene, request, RunsOn::device);
        resident = picture->stay(device);
    }
};

ResidentScene::ResidentScene(Device& device, const Scene& scene, const RenderRequest& request)
    : impl_(std::make_unique<Impl>(device, scene, request)) {}
ResidentScene::~ResidentScene() = default;

ResidentScene::Picture ResidentScene::draw() {
    Impl& v = *impl_;
    if (v.resident && v.resident->draw()) return v.resident->pixels();
    v.resident.reset();  // its buffers make room
    v.picture.reset();
    v.whole = renderGpu(v.device, v.scene, v.request);
    v.times.insert(v.times.end(), v.whole.times.begin(), v.whole.times.end());
    return {v.whole.frame.rgba.data(), v.request.width, v.request.height, v.request.width};
}

bool ResidentScene::resident() const { return impl_->resident != nullptr; }
RenderCounters ResidentScene::counters() const { return impl_->resident ? impl_->resident->counters() : impl_->whole.counters; }
std::vector<PassTime> ResidentScene::timePasses() {
    takeTimes();
    if (impl_->resident) impl_->resident->recorder().timeApart(impl_->request.watchdogMs);
    draw();
    if (impl_->resident) impl_->resident->recorder().timeApart(0);
    return takeTimes();
}
std::vector<PassTime> ResidentScene::takeTimes() {
    return impl_->resident ? impl_->resident->recorder().takeTimes() : std::exchange(impl_->times, {});
}

}  // namespace plumb
