// SPDX-License-Identifier: MIT
#include "pipeline/command/renderer.h"

#include "pipeline/command/interrupt.h"

#include <fmt/core.h>
#include <chrono>
#include <string>
#include <vector>

namespace plumb {

DeviceRequest deviceRequestOf(const Options& options) {
    DeviceRequest request;
    request.prefer = options.device;
    request.require = options.requireDevice;
    request.memoryBudgetBytes = options.memoryBytes;
    return request;
}

Renderer::Renderer(const Options& options) : request_(deviceRequestOf(options)), requireDevice_(options.requireDevice) {
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

RenderResult Renderer::render(const Scene& scene, const RenderRequest& request) {
    for (int attempt = 0; device_; ++attempt) {
        try {
            return renderGpu(*device_, scene, request);
        } catch (const Error& error) {
            if (error.exit() != Exit::failed && error.exit() != Exit::device) throw;
            stopIfInterrupted();
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

std::string Renderer::name() const { return device_ ? choice_.info.name : "CPU twin"; }

void Renderer::checkValidation() const {
    if (!device_ || !device_->validationActive()) return;
    const std::vector<std::string> messages = device_->validationMessages();
    if (!messages.empty())
        throw renderError(fmt::format("the validation layers complain {} times; first: {}", messages.size(), messages.front()));
}

Json Renderer::json() const {
    Json json;
    if (!device_) {
        json["name"] = "CPU twin";
        json["type"] = "twin";
    } else {
        const DeviceInfo& info = device_->info();
        const DeviceLimits& limits = device_->limits();
        const SelfTest& test = device_->selfTest();
        json["name"] = info.name;
        json["type"] = info.type;
        json["driver"] = info.driver;
        json["driverInfo"] = info.driverInfo;
        json["api"] = info.apiVersion;
        json["uuid"] = info.uuid;
        json["index"] = info.index;
        json["lavapipe"] = info.lavapipe;
        json["limits"] = {{"storageRangeBytes", limits.storageRangeBytes},
                          {"texelElements", limits.texelElements},
                          {"groupCount", limits.groupCount},
                          {"allocationBytes", limits.allocationBytes},
                          {"groupInvocations", limits.groupInvocations},
                          {"subgroupSize", limits.subgroupSize},
                          {"memoryBudgetBytes", device_->memoryBudgetBytes()}};
        json["selfTest"] = {{"passed", test.failure.empty()},
                            {"fromCache", test.fromCache},
                            {"time_ms", test.timeMs},
                            {"nativeDivideIsExact", test.nativeDivideIsExact},
                            {"nativeRootIsExact", test.nativeRootIsExact},
                            {"loopLimit", test.loopLimit}};
    }
    json["reason"] = choice_.reason;
    json["notChosen"] = choice_.notChosen;
    return json;
}

}  // namespace plumb
