// SPDX-License-Identifier: MIT
// A scene prepared for both sides: the twin's geometry, and a device frame that reads exactly that.
#pragma once

#include "pipeline/render/raster/hand_over.h"
#include "tests/support/compare.h"
#include "tests/support/device_fixture.h"
#include "tests/support/scenes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace plumb::test {

inline constexpr double kWatchdogMs = 60000;
inline constexpr uint32_t kPassPlanes = gpu::kFillPlaneZ | gpu::kFillPlaneTriangle | gpu::kFillPlaneLinear;

// The two forms of division and root of shaders/shared/exact.h: as the self-test chose, and emulated.
inline std::vector<Specialization> exactForms(const Device& device) {
    return {{{"kNativeDivide", device.selfTest().nativeDivideIsExact}, {"kNativeRoot", device.selfTest().nativeRootIsExact}},
            {{"kNativeDivide", false}, {"kNativeRoot", false}}};
}

template <class T>
Buffer<T> bufferOf(Device& device, const std::vector<T>& from) {
    Buffer<T> b(device, std::max<size_t>(1, from.size()), "test");
    b.upload(from);
    return b;
}

// Elements past the end of an output that must come back as they were.
inline constexpr uint32_t kSentinel = 0xdeadbeefu;
inline constexpr size_t kSentinels = 16;
template <class T>
void expectSentinels(const std::string& pass, const Buffer<T>& buffer, size_t used) {
    const auto* words = static_cast<const uint32_t*>(buffer.data());
    for (size_t i = used * sizeof(T) / 4; i < buffer.count() * sizeof(T) / 4; ++i)
        ASSERT_EQ(words[i], kSentinel) << pass << ": word " << i << ", past the " << used << " elements of the output, was written";
}

struct PassFrame {
    Prepared p;
    TwinGeometry twin;
    GpuFrame frame;

    PassFrame(Device& device, const Scene& scene, const RenderRequest& request)
        : p(prepare(scene, request)), twin(twinGeometry(p.list, p.choices, false, 1)), frame(device, p, kWatchdogMs) {}

    // Device geometry up to and with clip, each step on the twin's input.
    void setup() {
        frame.upload(p.list);
        frame.transformAndCull(false);
        handOverCulled(twin, p.list, frame);
        frame.setup();
    }
    // The device reads the twin's draw list and clipped corners too.
    void takeTwin() {
        setup();
        handOverSetUp(twin, frame);
    }
    gpu::FrameBox band(int firstRow, int rows) const {
        gpu::FrameBox b = p.list.frame;
        b.firstRow = firstRow;
        b.rows = std::min(rows, b.height - firstRow);
        return b;
    }
};

inline RenderRequest requestOf(const SceneCase& c, Shading shading = Shading::phong) {
    RenderRequest r;
    r.width = c.width;
    r.height = c.height;
    r.shading = shading;
    return r;
}

class SceneRows : public OnDevice<::testing::TestWithParam<SceneCase>> {};

}  // namespace plumb::test
