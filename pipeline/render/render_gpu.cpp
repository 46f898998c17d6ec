// SPDX-License-Identifier: MIT
#include "pipeline/render/device_render.h"
#include "pipeline/scene/plain_floats.h"

namespace plumb {

RenderResult renderGpu(Device& device, const Scene& scene, const RenderRequest& request) {
    const PlainFloats plain;
    return DeviceRender(device, scene, request).draw();
}

}  // namespace plumb
