// SPDX-License-Identifier: MIT
// The twin of a traced picture.
#include "pipeline/passes/parallel.h"
#include "pipeline/passes/resolve.h"
#include "pipeline/render/rays/trace_samples.h"
#include "pipeline/render/walk.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <utility>
#include <vector>

namespace plumb {

namespace {

constexpr uint64_t kTwinBandSamples = uint64_t(1) << 22;

// Samples of a band, and what is traced into them.
struct Samples {
    std::vector<uint32_t> distance, object;
    std::vector<float> linear, normal;

    // Room for `samples` of which the first `kept` are the last of what was there.
    void begin(size_t samples, size_t kept, bool normals) {
        const auto keep = [&](auto& values, size_t each) {
            std::move(values.end() - ptrdiff_t(kept * each), values.end(), values.begin());
            values.resize(samples * each);
        };
        keep(distance, 1);
        keep(object, 1);
        keep(linear, 3);
        if (normals) keep(normal, 3);
    }
    TraceOutput from(size_t first) {
        return {std::span(distance).subspan(first), std::span(object).subspan(first), std::span(linear).subspan(3 * first),
                normal.empty() ? std::span<float>() : std::span(normal).subspan(3 * first)};
    }
};

class TwinTrace {
public:
    TwinTrace(const Prepared& p, const Scene& scene, const RenderRequest& request, PlaneWriter& writer, RenderResult& result)
        : p_(p),
          request_(request),
          result_(result),
          grid_(sampleGridOf(p, request)),
          traced_(traceSceneOf(scene, p)),
          choices_(traceChoicesOf(scene, request, p, traced_)),
          push_(tracePushOf(p, request, traced_)),
          planes_(writer),
          seen_(p, scene, request, grid_),
          threads_(threadCount(request.threads)),
          counters_(gpu::kCounters) {}

    void draw() {
        uint32_t bandRows = uint32_t(std::max<uint64_t>(1, kTwinBandSamples / grid_.width / grid_.stride));
        if (request_.knobs.bandRows) bandRows = request_.knobs.bandRows;
        for (uint32_t first = 0; first < p_.height; first += bandRows) {
            reportTrace(request_, double(first) / p_.height);
            band(first, std::min(bandRows, p_.height - first));
            ++result_.counters.bands;
        }
        addRayCounts(counters_, push_.maxDepth, result_.counters);
        countParts(traced_, result_.counters);
    }

private:
    // Rows of pixels.
    void band(uint32_t firstRow, uint32_t rows) {
        const uint32_t sampleRows = grid_.rowsFor(rows), shared = firstRow ? grid_.overlap() : 0;
        const size_t kept = size_t(shared) * grid_.width;
        samples_.begin(size_t(sampleRows) * grid_.width, kept, request_.planes & kPlaneNormal);
        push_.firstItem = (firstRow * grid_.stride + shared) * grid_.width;
        push_.itemCount = (sampleRows - shared) * grid_.width;
        const StepBody steps[] = {{"trace", [&] { traceCpu(push_, traced_, choices_, samples_.from(kept), counters_, threads_); }},
                                  {"resolve", [&] { write(firstRow, rows); }},
                                  {"encode", [&] { write(firstRow, rows); }}};
        walk(p_.plan, result_.times, steps);
        if (request_.rays.sampling == RayChoices::Sampling::adaptive) refine(firstRow, rows);
    }

    void write(uint32_t firstRow, uint32_t rows) {
        const std::span<const int> drawn = asInts(samples_.distance);
        planes_.takeColours(firstRow, rows, {grid_, samples_.linear, drawn}, threads_);
        planes_.takeCoverage(rows, grid_, drawn);
        planes_.takeSeen(firstRow, rows, grid_, drawn, [&](uint32_t x, uint32_t y, size_t sample) {
            const float* n = samples_.normal.empty() ? nullptr : &samples_.normal[3 * sample];
            return seen_.at(x, y, samples_.distance[sample], samples_.object[sample], n ? glm::vec3(n[0], n[1], n[2]) : glm::vec3(0));
        });
    }

    static std::span<const int> asInts(const std::vector<uint32_t>& words) {
        return {reinterpret_cast<const int*>(words.data()), words.size()};
    }

    void refine(uint32_t firstRow, uint32_t rows) {
        const std::vector<uint32_t> pixels = pixelsWithDifferentCorners(
            p_.width, firstRow, rows, choices_.encoding,
            [&](uint32_t x, uint32_t y) {
                const float* c = &samples_.linear[3 * (size_t(y) * grid_.width + x)];
                return glm::vec3(c[0], c[1], c[2]);
            },
            [&](uint32_t x, uint32_t y) { return samples_.distance[size_t(y) * grid_.width + x] != 0; }, threads_);
        result_.counters.refinedPixels += pixels.size();
        if (pixels.empty()) return;
        const auto count = uint32_t(pixels.size());
        gpu::TracePush push = finePushOf(push_, count);
        push.firstItem = 0;
        push.itemCount = count * kFineSide * kFineSide;
        TraceChoices choices = choices_;
        choices.sampling = gpu::kSampleGrid;
        choices.side = kFineSide;
        choices.pixels = pixels;
        fine_.begin(push.itemCount, 0, false);
        {
            const Stopwatch watch(&result_.times, "trace");
            traceCpu(push, traced_, choices, fine_.from(0), counters_, threads_);
        }
        const Stopwatch watch(&result_.times, "resolve");
        resolved_.resize(3 * pixels.size());
        std::vector<uint32_t> rgba(pixels.size());
        resolveCpu(count, 1, kFineSide, request_.transparent, choices.encoding, fine_.linear, asInts(fine_.distance), resolved_, rgba,
                   threads_);
        for (size_t i = 0; i < pixels.size(); ++i)
            planes_.replaceColour(pixels[i] & 0xffffu, pixels[i] >> 16, rgba[i], &resolved_[3 * i], 1);
    }

    const Prepared& p_;
    const RenderRequest& request_;
    RenderResult& result_;
    const SampleGrid grid_;
    TraceScene traced_;
    TraceChoices choices_;
    gpu::TracePush push_;
    PlaneWriter& planes_;
    RaySeen seen_;
    const uint32_t threads_;
    std::vector<uint64_t> counters_;
    Samples samples_, fine_;
    std::vector<float> resolved_;
};

}  // namespace

gpu::TracePush tracePushOf(const Prepared& p, const RenderRequest& request, const TraceScene& traced) {
    gpu::TracePush push{};
    push.width = sampleGridOf(p, request).width;
    push.sphereCount = uint32_t(traced.spheres.size());
    push.planeCount = uint32_t(traced.planes.size());
    push.lightCount = uint32_t(traced.lights.size());
    push.childCount = uint32_t(traced.nodes.size() / 2);
    push.reach = traced.reach;
    push.maxDepth = std::clamp(request.maxDepth, 1u, gpu::kRayDepthLimit);
    push.minWeight = request.minWeight;
    push.rayLimit = push.maxDepth;
    push.first = 1;
    push.background = p.background;
    push.rayOrigin = p.rayOrigin;
    push.rayX = p.rayX;
    push.rayY = p.rayY;
    push.sky = p.backgroundLinear;
    push.seed = request.rays.seed;
    return push;
}

void traceFrameCpu(const Prepared& p, const Scene& scene, const RenderRequest& request, PlaneWriter& writer, RenderResult& result) {
    TwinTrace(p, scene, request, writer, result).draw();
}

}  // namespace plumb
