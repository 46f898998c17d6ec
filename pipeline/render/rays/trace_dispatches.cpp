// SPDX-License-Identifier: MIT
#include "pipeline/render/rays/trace_dispatches.h"

#include "host/error.h"
#include "pipeline/passes/encode.h"

#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace plumb {

namespace {

// lavapipe ends loops after 65,535 iterations of a subgroup, without a word.
constexpr uint64_t kLoopLimit = 60000;
// A dispatch cannot be cancelled, so it is to end within a tenth of a second. Object tests of the first one, at some 4 ns each on two cores; then the
// number of samples follows the time that the last dispatch took. Where a picture is cut changes no bit of it.
constexpr uint64_t kFirstWork = uint64_t(1) << 22;
constexpr double kLongMs = 60, kShortMs = 25;
constexpr uint64_t kUsualRays = 3;  // of a sample, when that is estimated
constexpr uint64_t kUsualNodes = 100;
constexpr uint64_t kLeastSamples = 256, kMostSamples = uint64_t(1) << 22;
constexpr uint32_t kListedRaysPerDispatch = 32;
constexpr uint64_t kWaitingBytes = uint64_t(64) << 20;

}  // namespace

TraceDispatches::TraceDispatches(Device& device, Recorder& recorder, const Prepared& p, const Scene& scene, const RenderRequest& request)
    : device_(device),
      recorder_(recorder),
      request_(request),
      traced_(traceSceneOf(scene, p)),
      choices_(traceChoicesOf(scene, request, p, traced_)),
      push_(tracePushOf(p, request, traced_)),
      counters_(gpu::kCounters),
      mostSamples_(kMostSamples) {
    choices_.lanes = device.limits().subgroupShuffle ? device.limits().subgroupSize : 0;
    chooseForm(scene);
}

// Whether a sample keeps its rays in a list, how many it follows in a dispatch, and the samples of the first dispatch.
void TraceDispatches::chooseForm(const Scene& scene) {
    const uint64_t steps = stepsOfRay(traced_);
    if (steps > kLoopLimit)
        throw inputError(scene.path, fmt::format("{} spheres and planes with {} lights need {} loop steps a ray; a device takes {}",
                                                 traced_.surfaces.size(), traced_.lights.size(), steps, kLoopLimit));
    choices_.list |= steps * push_.maxDepth > kLoopLimit;
    if (choices_.list && choices_.cutLevels)
        throw inputError(scene.path, fmt::format("--levels cut keeps a whole path at once: {} rays of {} loop "
                                                 "steps are more than the {} of a device",
                                                 push_.maxDepth, steps, kLoopLimit));
    if (choices_.list) {
        push_.rayLimit = uint32_t(std::clamp<uint64_t>(kLoopLimit / steps, 1, kListedRaysPerDispatch));
        if (request_.knobs.rayLimit) push_.rayLimit = std::min(push_.rayLimit, request_.knobs.rayLimit);
    }
    // A ray opens some hundred nodes of a tree, a node costs as much as an object.
    const uint64_t work = steps + (traced_.nodes.empty() ? 0 : kUsualNodes * (1 + traced_.lights.size()));
    if (choices_.list) mostSamples_ = listedSamples();
    samples_ = std::clamp<uint64_t>(kFirstWork / (work * std::min<uint64_t>(push_.maxDepth, kUsualRays)), kLeastSamples, mostSamples_);
}

void TraceDispatches::upload() {
    put(buffers_.spheres, traced_.spheres, "spheres");
    put(buffers_.powers, traced_.powers, "powers of the eye");
    put(buffers_.planes, traced_.planes, "planes of the scene");
    put(buffers_.surfaces, traced_.surfaces, "surfaces");
    put(buffers_.materials, traced_.materials, "materials");
    put(buffers_.lights, traced_.lights, "lights");
    put(buffers_.corners, traced_.corners, "corners");
    put(buffers_.triangles, traced_.triangles, "triangles");
    put(buffers_.nodes, traced_.nodes, "tree");
    put(buffers_.leaves, traced_.leaves, "leaves of the tree");
    put(buffers_.encodeTable, srgbBucketTable(), "encode table");
    put(buffers_.pixels, std::vector<uint32_t>(1), "pixels to refine");
    buffers_.counters.reserve(device_, gpu::kCounters, "ray counters");
    buffers_.counters.fill(0);
    if (choices_.list) return reserveList();
    buffers_.waiting.reserve(device_, 1, "waiting rays");
    buffers_.states.reserve(device_, 1, "states of samples");
}

// Samples [begin, end) of a frame of `all`, until none has a ray waiting.
void TraceDispatches::trace(gpu::TracePush& push, TraceChoices choices, uint64_t begin, uint64_t end, double all) {
    for (uint64_t at = begin, count = 0; at < end; at += count) {
        // Whole rows in tiles, where a dispatch has eight of them: the rays of a subgroup then stay close together. What is less ends with a
        // row where it can, so that tiles may follow.
        const uint64_t row = push.width, into = at % row;
        choices.tiles = !choices.list && choices.pixels.empty() && into == 0 && samples_ >= 8 * row;
        count = samples_ >= row ? samples_ / row * row - into : std::min(samples_, row - into);
        if (choices.tiles) count = samples_ / (8 * row) * (8 * row);
        count = std::min(count, end - at);
        push.firstItem = uint32_t(at);
        push.itemCount = uint32_t(count);
        push.tileRows = uint32_t(count / push.width);
        const uint32_t tileRows = 2 * samplesOfInvocation(push, traced_, choices);
        if (choices.tiles) push.itemCount = (push.width + 3) / 4 * ((push.tileRows + tileRows - 1) / tileRows) * 8;
        push.first = 1;
        reportTrace(request_, double(at) / all);
        const std::vector<uint64_t> counted = counters_;
        try {
            adapt(untilDone(push, choices), count);
        } catch (const LoopBudgetError&) {
            if (!shorten(push, choices)) throw;
            counters_ = counted;
            buffers_.counters.fill(0);
            count = 0;
        }
    }
}

// From the eye until no sample has a ray waiting. Milliseconds of the longest dispatch.
double TraceDispatches::untilDone(gpu::TracePush& push, const TraceChoices& choices) {
    double longestMs = 0;
    for (uint32_t unfinished = 1; unfinished != 0; push.first = 0) {
        recordTrace(recorder_, push, traced_, choices, {}, buffers_);
        const auto start = std::chrono::steady_clock::now();
        recorder_.run(request_.watchdogMs);
        longestMs = std::max(longestMs, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
        const std::span<uint32_t> words = buffers_.counters.span();
        unfinished = words[gpu::kCountUnfinished];
        for (size_t i = 0; i < counters_.size(); ++i) counters_[i] += words[i];
        buffers_.counters.fill(0);
    }
    return longestMs;
}

// How many steps the walks of a path take together is not known before. Lowers the number of rays that a sample follows in a dispatch; the
// others wait in its list. False where it follows one already, or keeps whole paths.
bool TraceDispatches::shorten(gpu::TracePush& push, TraceChoices& choices) {
    if (choices.cutLevels || (choices.list && push.rayLimit == 1)) return false;
    push_.rayLimit = push.rayLimit = std::max(1u, std::min(push.rayLimit, kListedRaysPerDispatch) / 2);
    choices_.list = choices.list = true;
    choices.tiles = false;
    reserveList();
    samples_ = std::min(samples_, mostSamples_);
    return true;
}

uint64_t TraceDispatches::listedSamples() const {
    return std::max<uint64_t>(kLeastSamples, kWaitingBytes / (4ull * gpu::kWaitingWords * push_.maxDepth));
}

void TraceDispatches::reserveList() {
    mostSamples_ = listedSamples();
    buffers_.waiting.reserve(device_, mostSamples_ * gpu::kWaitingWords * push_.maxDepth, "waiting rays");
    buffers_.states.reserve(device_, mostSamples_ * gpu::kStateWords, "states of samples");
}

// The first dispatch of a kernel has it compiled and says nothing about its samples.
void TraceDispatches::adapt(double longestMs, uint64_t count) {
    if (!warm_)
        warm_ = true;
    else if (longestMs > kLongMs)
        samples_ = std::max(kLeastSamples, samples_ / 2);
    else if (longestMs < kShortMs && count * 2 > samples_)
        samples_ = std::min(mostSamples_, samples_ * 2);
}

}  // namespace plumb
