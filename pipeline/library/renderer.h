// SPDX-License-Identifier: MIT
// Renderer: a device, or the CPU twin, and the reason for the choice. No device is swapped silently.
#pragma once

#include "host/device.h"
#include "pipeline/library/picture.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace plumb {

// One thread uses a Renderer at a time. Several renderers may be used by several threads.
class Renderer {
public:
    // Chooses by the words of the request, and opens. Without a device that can draw, the twin draws, unless one is required. Throws
    // Error(device) when a required device is not there or fails its self-test. Prints nothing.
    explicit Renderer(const DeviceRequest& = {});

    // Draws. A device that fails is opened afresh once, then the twin draws, unless a device is required. Each such step is a sentence of
    // fallbacks(). Throws Error(input) or Error(usage), one sentence, for a scene or a request that cannot be drawn; Error(interrupted) when
    // onProgress says so; Error(failed) when nothing could draw.
    Picture render(const Scene&, const RenderRequest& = {});

    Device* device() { return device_ ? &*device_ : nullptr; }  // null: the twin draws; valid until the next render()
    const Device* device() const { return device_ ? &*device_ : nullptr; }
    const DeviceChoice& choice() const { return choice_; }
    const std::vector<std::string>& fallbacks() const { return fallbacks_; }
    double openMs() const { return openMs_; }
    uint64_t devicePeakBytes() const { return device_ ? device_->memoryPeakBytes() : 0; }
    std::string name() const;    // name of what draws now: of the device, or "CPU twin"
    std::string reason() const;  // one sentence: why that draws

    // Throws Error(failed) when validation was on (PLUMB_VALIDATION=1) and complained.
    void checkValidation() const;

private:
    void open();
    bool mayFallBack() const { return request_.require.empty() || request_.require == "auto"; }
    RenderResult drawn(const Scene&, const RenderRequest&);

    DeviceRequest request_;
    DeviceChoice choice_;
    std::optional<Device> device_;
    std::vector<std::string> fallbacks_;
    double openMs_ = 0;
};

}  // namespace plumb
