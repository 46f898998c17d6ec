// SPDX-License-Identifier: MIT
#include "pipeline/library/renderer.h"

#include "host/error.h"
#include "pipeline/scene/check_scene.h"

#include <fmt/core.h>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

Renderer::Renderer(const DeviceRequest& request) : request_(request) {
    const auto start = std::chrono::steady_clock::now();
    choice_ = Device::choose(request_);
    if (!choice_.twin) open();
    openMs_ = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

void Renderer::open() {
    std::string failure;
    try {
        device_.emplace(Device::open(choice_, request_));
        failure = device_->selfTest().failure;
    } catch (const Error& error) {
        if (error.exit() != Exit::device) throw;
        failure = error.what();
    }
    if (failure.empty()) return;
    device_.reset();
    if (!mayFallBack()) throw deviceError(fmt::format("'{}' cannot draw: {}", choice_.info.name, failure));
    fallbacks_.push_back(fmt::format("'{}' cannot draw, the CPU twin draws: {}", choice_.info.name, failure));
}

RenderResult Renderer::drawn(const Scene& scene, const RenderRequest& request) {
    for (int attempt = 0; device_; ++attempt) {
        try {
            return renderGpu(*device_, scene, request);
        } catch (const Error& error) {
            if (error.exit() != Exit::failed && error.exit() != Exit::device) throw;
            if (request.onProgress && !request.onProgress(0)) throw Error(Exit::interrupted, "interrupted");
            if (attempt == 0) {
                fallbacks_.push_back(fmt::format("'{}' failed and is opened afresh: {}", choice_.info.name, error.what()));
                device_.reset();
                open();
                continue;
            }
            device_.reset();
            if (!mayFallBack()) throw;
            fallbacks_.push_back(fmt::format("'{}' failed again, the CPU twin draws: {}", choice_.info.name, error.what()));
        }
    }
    return renderCpu(scene, request);
}

Picture Renderer::render(const Scene& scene, const RenderRequest& request) {
    checkScene(scene);
    Picture picture{drawn(scene, request)};
    picture.drawnBy = name();
    picture.reason = reason();
    picture.planes = request.planes | kPlaneColour;
    picture.encoding = request.encoding;
    picture.transparent = request.transparent;
    return picture;
}

std::string Renderer::name() const { return device_ ? choice_.info.name : "CPU twin"; }

std::string Renderer::reason() const { return fallbacks_.empty() ? choice_.reason : fallbacks_.back(); }

void Renderer::checkValidation() const {
    if (!device_ || !device_->validationActive()) return;
    const std::vector<std::string> messages = device_->validationMessages();
    if (!messages.empty())
        throw renderError(fmt::format("the validation layers complain {} times; first: {}", messages.size(), messages.front()));
}

}  // namespace plumb
