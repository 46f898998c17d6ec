// SPDX-License-Identifier: MIT
#include "pipeline/render/render.h"

#include "host/error.h"
#include "pipeline/render/technique.h"
#include "pipeline/scene/check_scene.h"
#include "pipeline/scene/plain_floats.h"

#include <fmt/core.h>
#include <cstddef>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace plumb {

struct ResidentScene::Impl {
    Device& device;
    Scene scene;  // its camera and its objects' matrices are those of the last draw
    RenderRequest request;
    bool fits = true;                           // false: every draw is a whole one
    bool uploaded = false;                      // the last draw prepared and uploaded the scene anew
    std::unique_ptr<PreparedPicture> picture;   // none: to be prepared, or it does not fit
    std::unique_ptr<ResidentPicture> resident;  // of the picture; none without one
    Frame frame;                                // with planes beside colour
    RenderResult whole;
    std::vector<PassTime> times;

    Impl(Device& d, const Scene& s, const RenderRequest& r) : device(d), scene(s), request(r) {
        if (colourAlone()) request.transparent = true;  // alpha is coverage
        request.repeated = true;
        const PlainFloats plain;
        prepare();
    }

    bool colourAlone() const { return (request.planes | kPlaneColour) == kPlaneColour; }

    void prepare() {
        resident.reset();  // its picture outlives it
        picture = pictureOf(scene, request, RunsOn::device);
        resident = picture->stay(device);
        if (resident) return;
        fits = false;
        picture.reset();
    }

    // Makes the picture that stays one of the scene as it is now. `moved`: it was one of another pose.
    void bringUpToDate(bool moved, bool objects) {
        if (!fits || (picture && !moved)) return;
        if (moved && picture && picture->place()) return resident->moved(objects);
        prepare();
        uploaded = true;
    }

    Picture drawn() {
        const bool alone = colourAlone();
        if (fits && (alone ? resident->draw() : resident->drawPlanes(frame)))
            return alone ? resident->pixels() : Picture{frame.rgba.data(), request.width, request.height, request.width, &frame};
        fits = false;
        resident.reset();  // its buffers make room
        picture.reset();
        whole = renderGpu(device, scene, request);
        times.insert(times.end(), whole.times.begin(), whole.times.end());
        return {whole.frame.rgba.data(), request.width, request.height, request.width, alone ? nullptr : &whole.frame};
    }

    // After an exception the scene stands as before, and is prepared anew by the next draw.
    Picture draw(const Pose& pose) {
        const PlainFloats plain;
        const bool objects = !pose.worldFromObject.empty(), moved = pose.camera || objects;
        if (objects && pose.worldFromObject.size() != scene.objects.size())
            throw usageError(
                fmt::format("a pose has {} matrices, and the scene has {} objects", pose.worldFromObject.size(), scene.objects.size()));
        std::optional<Camera> camera = pose.camera ? pose.camera : scene.camera;
        std::vector<glm::dmat4> matrices(pose.worldFromObject.begin(), pose.worldFromObject.end());
        const auto exchange = [&] {
            std::swap(scene.camera, camera);
            for (size_t i = 0; i < matrices.size(); ++i) std::swap(scene.objects[i].worldFromObject, matrices[i]);
        };
        exchange();
        uploaded = false;
        try {
            if (moved) checkScene(scene);
            bringUpToDate(moved, objects);
            return drawn();
        } catch (...) {
            exchange();
            resident.reset();
            picture.reset();
            throw;
        }
    }
};

ResidentScene::ResidentScene(Device& device, const Scene& scene, const RenderRequest& request)
    : impl_(std::make_unique<Impl>(device, scene, request)) {}
ResidentScene::~ResidentScene() = default;

ResidentScene::Picture ResidentScene::draw(const Pose& pose) { return impl_->draw(pose); }

bool ResidentScene::resident() const { return impl_->resident != nullptr && !impl_->uploaded; }
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
