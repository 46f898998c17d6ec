// SPDX-License-Identifier: MIT
// Other tracers for comparison with the device's rays.
#pragma once

#include "pipeline/passes/trace.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace plumb::peers {

// The pass as one would write it for a processor: the textbook's quadratic, powf, no counters, no list, no bounds; rows on `threads`
// threads. Spheres, boards, reflection, shadow rays to opaque blockers, linear encoding; RGBA, alpha 255 where something is hit.
void traceNative(const gpu::TracePush& push, const TraceScene& scene, uint32_t height, std::span<uint32_t> rgba, uint32_t threads);

// Mesh in Embree's own BVH.
class EmbreeScene {
public:
    EmbreeScene(const TraceScene& scene, bool robust);
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;
    // Traces each primary ray by rtcIntersect1: the triangle's number, gpu::kNoObject for none.
    void primaryRays(const gpu::TracePush& push, uint32_t height, std::span<uint32_t> triangle, uint32_t threads) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};
// Embree can be used when `why` stays empty: the build found Embree 3.
bool hasEmbree(std::string& why);

}  // namespace plumb::peers
