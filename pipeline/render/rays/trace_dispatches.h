// SPDX-License-Identifier: MIT
// The trace pass in short dispatches. It chooses how many samples each takes, and goes on with rays that are still waiting.
#pragma once

#include "pipeline/render/rays/trace_samples.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace plumb {

class TraceDispatches {
public:
    // Throws Error(input) for a scene of which a ray has more loop steps than a device takes.
    TraceDispatches(Device& device, Recorder& recorder, const Prepared& prepared, const Scene& scene, const RenderRequest& request);

    void upload();
    bool uploaded() const { return bool(buffers_.spheres); }
    // Traces the samples [begin, end) of a frame of `all` samples, until none has a ray waiting.
    void trace(gpu::TracePush& push, TraceChoices choices, uint64_t begin, uint64_t end, double all);

    template <class T>
    void put(Buffer<T>& buffer, const std::vector<T>& from, const char* name) {
        buffer.reserve(device_, std::max<size_t>(from.size(), 1), name);
        buffer.fill(0);
        buffer.upload(from);
    }

    // Push constants and choices of the picture. The caller sets planes, rows and pitch.
    gpu::TracePush& push() { return push_; }
    TraceChoices& choices() { return choices_; }
    TraceBuffers& buffers() { return buffers_; }
    const TraceScene& scene() const { return traced_; }
    std::vector<uint64_t>& counters() { return counters_; }  // gpu::kCounters words, summed over all dispatches

private:
    void chooseForm(const Scene& scene);
    double untilDone(gpu::TracePush& push, const TraceChoices& choices);
    bool shorten(gpu::TracePush& push, TraceChoices& choices);
    uint64_t listedSamples() const;
    void reserveList();
    void adapt(double longestMs, uint64_t count);

    Device& device_;
    Recorder& recorder_;
    const RenderRequest& request_;
    const TraceScene traced_;
    TraceChoices choices_;
    gpu::TracePush push_;
    TraceBuffers buffers_;
    std::vector<uint64_t> counters_;
    uint64_t samples_ = 0, mostSamples_;  // samples of a dispatch
    bool warm_ = false;                   // true: the kernel has been compiled
};

}  // namespace plumb
