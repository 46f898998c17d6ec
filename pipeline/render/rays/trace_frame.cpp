// SPDX-License-Identifier: MIT
// The twin of a traced picture.
#include "pipeline/passes/encode.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/passes/resolve.h"
#include "pipeline/render/rays/trace_samples.h"
#include "pipeline/render/stopwatch.h"

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
    TwinTrace(const Prepared& p, const Scene& scene, const RenderRequest& request, RenderResult& result)
        : p_(p),
          request_(request),
          result_(result),
          grid_(sampleGridOf(p, request)),
          traced_(traceSceneOf(scene, p)),
          choices_(traceChoicesOf(scene, request, p, traced_)),
          push_(tracePushOf(p, request, traced_)),
          planes_(p, scene, request, grid_, result.frame),
          threads_(threadCount(request.threads)),
          counters_(gpu::kCounters) {}

    void draw() {
        uint32_t bandRows = uint32_t(std::max<uint64_t>(1, kTwinBandSamples / grid_.width / grid_.stride));
        if (request_.bandRows) bandRows = request_.bandRows;
        for (uint32_t first = 0; first < p_.height; first += bandRows) {
            reportTrace(request_, double(first) / p_.height);
            band(first, std::min(bandRows, p_.height - first));
            ++result_.counters.bands;
        }
        addRayCounts(counters_, push_.maxDepth, result_.counters);
        countParts(traced_, result_.counters);
    }

private:
    bool resolves() const { return grid_.side > 1; }

    // Rows of pixels.
    void band(uint32_t firstRow, uint32_t rows) {
        const uint32_t sampleRows = grid_.rowsFor(rows), shared = firstRow ? grid_.overlap() : 0;
        const size_t kept = size_t(shared) * grid_.width;
        samples_.begin(size_t(sampleRows) * grid_.width, kept, request_.planes & kPlaneNormal);
        push_.firstItem = (firstRow * grid_.stride + shared) * grid_.width;
        push_.itemCount = (sampleRows - shared) * grid_.width;
        {
            const Stopwatch watch(&result_.times, "trace");
            traceCpu(push_, traced_, choices_, samples_.from(kept), counters_, threads_);
        }
        {
            const Stopwatch watch(&result_.times, resolves() ? "resolve" : "encode");
            colour(firstRow, rows);
        }
        for (uint32_t y = 0; y < rows; ++y)
            for (uint32_t x = 0; x < p_.width; ++x) {
                bool any = false;
                for (uint32_t k = 0; k < grid_.side * grid_.side; ++k)
                    any |= samples_.distance[at(x, y, k % grid_.side, k / grid_.side)] != 0;
                result_.frame.coveredPixels += any;
                const size_t sample = at(x, y, grid_.anchor, grid_.anchor);
                planes_.write(x, firstRow + y, samples_.distance[sample], samples_.object[sample],
                              samples_.normal.empty() ? nullptr : &samples_.normal[3 * sample]);
            }
        if (request_.rays.sampling == RayChoices::Sampling::adaptive) refine(firstRow, rows);
    }

    size_t at(uint32_t x, uint32_t y, uint32_t i, uint32_t j) const {
        return size_t(y * grid_.stride + j) * grid_.width + x * grid_.stride + i;
    }

    void colour(uint32_t firstRow, uint32_t rows) {
        const size_t first = size_t(firstRow) * p_.width, pixels = size_t(rows) * p_.width;
        const std::span<uint32_t> rgba(result_.frame.rgba.data() + first, pixels);
        if (resolves()) {
            covered_.assign(samples_.distance.begin(), samples_.distance.end());
            resolved_.resize(3 * pixels);
            resolveCpu(p_.width, rows, grid_.side, request_.transparent, choices_.encoding, samples_.linear, covered_, resolved_, rgba,
                       threads_, grid_.stride);
        } else {
            for (size_t i = 0; i < pixels; ++i)
                if (samples_.distance[i]) rgba[i] = encodePixelCpu(choices_.encoding, &samples_.linear[3 * i], 255);
        }
        if (request_.planes & kPlaneLinear)
            std::copy_n((resolves() ? resolved_ : samples_.linear).begin(), 3 * pixels,
                        result_.frame.linear.begin() + ptrdiff_t(3 * first));
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
        covered_.assign(fine_.distance.begin(), fine_.distance.end());
        resolved_.resize(3 * pixels.size());
        std::vector<uint32_t> rgba(pixels.size());
        resolveCpu(count, 1, kFineSide, request_.transparent, choices.encoding, fine_.linear, covered_, resolved_, rgba, threads_);
        for (size_t i = 0; i < pixels.size(); ++i) {
            const size_t pixel = size_t(pixels[i] >> 16) * p_.width + (pixels[i] & 0xffffu);
            result_.frame.rgba[pixel] = rgba[i];
            if (request_.planes & kPlaneLinear)
                std::copy_n(resolved_.begin() + ptrdiff_t(3 * i), 3, result_.frame.linear.begin() + ptrdiff_t(3 * pixel));
        }
    }

    const Prepared& p_;
    const RenderRequest& request_;
    RenderResult& result_;
    const SampleGrid grid_;
    TraceScene traced_;
    TraceChoices choices_;
    gpu::TracePush push_;
    TracePlanes planes_;
    const uint32_t threads_;
    std::vector<uint64_t> counters_;
    Samples samples_, fine_;
    std::vector<int> covered_;
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

void traceFrameCpu(const Prepared& p, const Scene& scene, const RenderRequest& request, RenderResult& result) {
    TwinTrace(p, scene, request, result).draw();
}

}  // namespace plumb
