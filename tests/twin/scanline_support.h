// SPDX-License-Identifier: MIT
// A list of polygons painted by the twin and on the device: equal bytes, or failures by name.
#pragma once

#include "pipeline/passes/scanline.h"
#include "tests/twin/pass_frame.h"

#include <fmt/format.h>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace plumb::test {

inline ScanCanvas sameOnBothSides(const ScanList& list, std::vector<gpu::ScanSpan>* lines) {
    const std::vector<gpu::ScanSpan> wantSpans = scanSpansCpu(list);
    std::vector<gpu::ScanSpan> gotSpans;
    ScanCanvas want = scanlineCpu(list);
    EXPECT_EQ(wantSpans.size(), list.spans);
    if (lines) *lines = wantSpans;
    if (!DeviceEnvironment::device()) {
        ADD_FAILURE() << "no device";
        return want;
    }
    Device& device = *DeviceEnvironment::device();
    for (const Specialization& exact : exactForms(device)) {
        Recorder recorder(device);
        const ScanCanvas got = scanlineGpu(device, recorder, list, exact, kWatchdogMs, &gotSpans);
        expectSame<gpu::ScanSpan>("scanline: line", wantSpans, gotSpans);
        const auto place = [&](size_t i) { return fmt::format("pixel ({}, {})", i % size_t(list.width), i / size_t(list.width)); };
        expectSame<float>("scanpaint: Z", want.z, got.z, place);
        expectSame<uint32_t>("scanpaint: polygon", want.owner, got.owner, place);
        expectSame<float>("scanpaint: attributes", std::span<const float>(&want.attributes[0].x, 3 * want.attributes.size()),
                          std::span<const float>(&got.attributes[0].x, 3 * got.attributes.size()));
    }
    expectNoValidationMessages(device);
    return want;
}

}  // namespace plumb::test
