// SPDX-License-Identifier: MIT
// Makes a scene that the sides draw differently smaller, as long as they still differ in the same pass.
#pragma once

#include "host/device.h"
#include "pipeline/render/render.h"

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

namespace plumb::suite {

// Pass in which the sides first differ; "failed: PASS" where the device fails; empty where they are equal. Throws what verifyRender()
// throws for a picture that cannot be drawn at all.
std::string differingPass(Device& device, const Scene& scene, const RenderRequest& request);

// A picture, and what it took to make it small.
struct Reduced {
    Scene scene;
    RenderRequest request;
    uint64_t triangles = 0, trianglesBefore = 0;  // of all objects
    uint32_t tried = 0;                           // pictures drawn on both sides
};
// Leaves out objects, shapes, lights and triangles, and takes a smaller picture of one sample, while `pass` stays the pass that differs. Ends
// after `limit`, or where nothing more can be left out. `onProgress` gets shares from 0 to 1, and may throw.
Reduced reduce(Device& device, const Scene& scene, const RenderRequest& request, const std::string& pass, std::chrono::milliseconds limit,
               const std::function<void(double)>& onProgress);

}  // namespace plumb::suite
