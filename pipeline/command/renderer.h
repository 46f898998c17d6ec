// SPDX-License-Identifier: MIT
// Renderer: a device, or the CPU twin, and the reason for the choice. No device is swapped silently.
#pragma once

#include "pipeline/command/command.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace plumb {

DeviceRequest deviceRequestOf(const Options&);

class Renderer {
public:
    // Throws Error(device) when the required device is not there or fails its self-test. Says nothing by itself.
    explicit Renderer(const Options&);

    // Draws. A device that fails is opened afresh once, then the twin draws, unless a device is required. Each such step is a sentence of
    // fallbacks().
    RenderResult render(const Scene&, const RenderRequest&);

    Device* device() { return device_ ? &*device_ : nullptr; }  // none: the twin draws
    const DeviceChoice& choice() const { return choice_; }
    const std::vector<std::string>& fallbacks() const { return fallbacks_; }
    double openMs() const { return openMs_; }
    uint64_t devicePeakBytes() const { return device_ ? device_->memoryPeakBytes() : 0; }
    std::string name() const;  // name of what draws now
    Json json() const;         // "device" of a report

    // Throws Error(failed) when validation was on (PLUMB_VALIDATION=1) and complained.
    void checkValidation() const;

private:
    void open();
    bool mayFallBack() const { return requireDevice_.empty() || requireDevice_ == "auto"; }

    DeviceRequest request_;
    std::string requireDevice_;
    DeviceChoice choice_;
    std::optional<Device> device_;
    std::vector<std::string> fallbacks_;
    double openMs_ = 0;
};

}  // namespace plumb
