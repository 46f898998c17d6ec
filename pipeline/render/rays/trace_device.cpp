// SPDX-License-Identifier: MIT
// A traced picture on the device: bands of rows, each in dispatches that stay short.
#include "host/error.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/passes/resolve.h"
#include "pipeline/render/rays/trace_dispatches.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace plumb {

namespace {

class DeviceTrace : public ResidentPicture {
public:
    DeviceTrace(Device& device, const Prepared& p, const Scene& scene, const RenderRequest& request)
        : device_(device),
          p_(p),
          request_(request),
          grid_(sampleGridOf(p, request)),
          recorder_(device),
          dispatches_(device, recorder_, p, scene, request),
          choices_(dispatches_.choices()),
          push_(dispatches_.push()),
          buffers_(dispatches_.buffers()),
          seen_(p, scene, request, grid_),
          counted_(p.counters) {
        recorder_.allow(p.plan.labels(RunsOn::device));
        choices_.colour = !resolves();
        choices_.planes = resolves() ? gpu::kTracePlaneDistance | gpu::kTracePlaneLinear : 0u;
        if (request.planes & kPlanesSeen) choices_.planes |= gpu::kTracePlaneDistance | gpu::kTracePlaneObject;
        if (request.planes & kPlaneLinear) choices_.planes |= gpu::kTracePlaneLinear | gpu::kTracePlaneDistance;
        if (request.planes & kPlaneNormal) choices_.planes |= gpu::kTracePlaneNormal;
        slots_ = slotsOf(choices_.planes);
    }

    void draw(PlaneWriter& writer, RenderResult& result) {
        dispatches_.upload();
        drawBands(writer, result.frame);
        result.counters = counted_;
        result.times = recorder_.takeTimes();
    }

    // One band of one sample a pixel, left where the device wrote it.
    bool draw() override {
        if (!dispatches_.uploaded()) dispatches_.upload();
        if (resolves() || rowsOfBand() < p_.height) return false;
        std::fill(dispatches_.counters().begin(), dispatches_.counters().end(), 0);
        traceBand(0, p_.height);
        counted_.rays.clear();
        counted_.undecidedRays = 0;
        countRays();
        return true;
    }
    ResidentScene::Picture pixels() const override { return {buffers_.colours.span().data(), p_.width, p_.height, push_.rowWords}; }
    bool drawPlanes(Frame& out) override {
        if (!dispatches_.uploaded()) dispatches_.upload();
        std::fill(dispatches_.counters().begin(), dispatches_.counters().end(), 0);
        counted_ = p_.counters;
        PlaneWriter writer(p_, request_, out);
        drawBands(writer, out);
        return true;
    }
    void moved(bool) override { PLUMB_ASSERT(!"rays meet surfaces relative to the eye: place() is false"); }
    RenderCounters counters() const override { return counted_; }
    Recorder& recorder() override { return recorder_; }

private:
    void drawBands(PlaneWriter& writer, Frame& out) {
        const uint64_t bandRows = rowsOfBand();
        for (uint32_t first = 0; first < p_.height; first += uint32_t(bandRows)) {
            band(first, uint32_t(std::min<uint64_t>(bandRows, p_.height - first)), writer, out);
            ++counted_.bands;
        }
        countRays();
    }

    uint64_t rowsOfBand() {
        push_.rowWords = (grid_.width + 3) / 4 * 4;
        const DeviceLimits& l = device_.limits();
        bandWords_ = std::min({l.storageRangeBytes / 4, l.texelElements, device_.memoryBudgetBytes() / 16}) * 4 / 5 - 64;
        const uint64_t sampleRows = bandWords_ / (uint64_t(push_.rowWords) * std::max(1u, slots_));
        if (sampleRows < grid_.side) throw renderError("a row of the picture exceeds the device's buffers");
        const uint64_t rows = (sampleRows - grid_.overlap()) / grid_.stride;
        return request_.knobs.bandRows ? std::min<uint64_t>(rows, request_.knobs.bandRows) : rows;
    }

    void countRays() {
        addRayCounts(dispatches_.counters(), push_.maxDepth, counted_);
        countParts(dispatches_.scene(), counted_);
    }

    static uint32_t slotsOf(uint32_t planes) {
        return (planes & gpu::kTracePlaneDistance ? 1u : 0u) + (planes & gpu::kTracePlaneObject ? 1u : 0u) +
               (planes & gpu::kTracePlaneLinear ? 3u : 0u) + (planes & gpu::kTracePlaneNormal ? 3u : 0u);
    }
    bool resolves() const { return grid_.side > 1; }

    void band(uint32_t firstRow, uint32_t rows, PlaneWriter& writer, Frame& out) {
        traceBand(firstRow, rows);
        if (resolves()) resolve(push_, choices_, grid_.side, grid_.stride, p_.width, rows);
        read(firstRow, rows, writer, out);
        if (request_.rays.sampling == RayChoices::Sampling::adaptive) refine(firstRow, rows, writer);
    }

    // Samples of rows of pixels. What they share with the rows above is copied down.
    void traceBand(uint32_t firstRow, uint32_t rows) {
        const uint32_t sampleRows = grid_.rowsFor(rows), shared = firstRow ? grid_.overlap() : 0;
        const size_t keptWords = size_t(shared) * push_.rowWords;
        std::vector<uint32_t> kept;
        for (uint32_t slot = 0; shared && slot < slots_; ++slot) {
            const auto end = buffers_.planeWords.span().begin() + ptrdiff_t(size_t(slot + 1) * push_.planeWords);
            kept.insert(kept.end(), end - ptrdiff_t(keptWords), end);
        }
        push_.firstRow = firstRow * grid_.stride;
        push_.planeWords = push_.rowWords * sampleRows;
        buffers_.colours.reserve(device_, choices_.colour ? push_.planeWords : 1, "colours");
        buffers_.planeWords.reserve(device_, std::max<uint64_t>(1, uint64_t(push_.planeWords) * slots_), "planes");
        for (uint32_t slot = 0; shared && slot < slots_; ++slot)
            std::copy_n(kept.begin() + ptrdiff_t(slot * keptWords), keptWords,
                        buffers_.planeWords.span().begin() + ptrdiff_t(size_t(slot) * push_.planeWords));
        const uint64_t begin = (uint64_t(push_.firstRow) + shared) * grid_.width,
                       end = (uint64_t(push_.firstRow) + sampleRows) * grid_.width;
        dispatches_.trace(push_, choices_, begin, end, double(grid_.height) * grid_.width);
    }

    void resolve(const gpu::TracePush& traced, const TraceChoices& choices, uint32_t side, uint32_t stride, uint32_t width, uint32_t rows) {
        resolvedQuads_ = (width + 3) / 4;
        resolvedRows_ = rows;
        const uint64_t quads = uint64_t(resolvedQuads_) * rows;
        const bool linearOut = request_.planes & kPlaneLinear;
        resolved_.reserve(device_, quads, "pixels");
        resolvedLinear_.reserve(device_, linearOut ? quads * 3 : 1, "linear pixels");
        gpu::ResolvePush push{};
        push.pixelQuads = uint32_t(quads);
        push.rowQuads = resolvedQuads_;
        push.sampleRowQuads = traced.rowWords / 4;
        push.samplePlaneQuads = traced.planeWords / 4;
        push.zSlot = 0;
        push.linearSlot = linearSlotOf(choices.planes);
        push.side = side;
        push.stride = stride;
        push.transparent = request_.transparent;
        recordResolve(recorder_, push, choices.encoding, linearOut, {}, buffers_.planeWords, buffers_.encodeTable, resolved_,
                      resolvedLinear_);
        recorder_.run(request_.watchdogMs);
    }
    static uint32_t linearSlotOf(uint32_t planes) { return planes & gpu::kTracePlaneObject ? 2 : 1; }
    const uint32_t* plane(uint32_t slot) const { return buffers_.planeWords.span().data() + size_t(slot) * push_.planeWords; }
    void read(uint32_t firstRow, uint32_t rows, PlaneWriter& writer, Frame& out) {
        const SampleLayout layout = grid_.inRowsOf(push_.rowWords);
        const uint32_t linearSlot = linearSlotOf(choices_.planes),
                       normalSlot = linearSlot + (choices_.planes & gpu::kTracePlaneLinear ? 3 : 0);
        const uint32_t pitch = resolves() ? resolvedQuads_ * 4 : push_.rowWords;
        PlaneWriter::DeviceRows colours{resolves() ? wordsOf(resolved_) : wordsOf(buffers_.colours), pitch, {}, pitch};
        for (uint32_t i = 0; i < 3 && writer.wants(kPlaneLinear); ++i)
            colours.linear[i] = resolves() ? resolvedLinear(i) : plane(linearSlot + i);
        const uint64_t covered = writer.takeColours(firstRow, rows, colours);
        const std::span<const uint32_t> distance(plane(0), choices_.planes & gpu::kTracePlaneDistance ? push_.planeWords : 0);
        if (resolves())
            writer.takeCoverage(rows, layout, distance);
        else
            out.coveredPixels += covered;
        if (!(choices_.planes & gpu::kTracePlaneObject)) return;
        const uint32_t* object = plane(1);
        writer.takeSeen(firstRow, rows, layout, distance, [&](uint32_t x, uint32_t y, size_t sample) {
            glm::vec3 normal(0);
            for (uint32_t i = 0; i < 3 && writer.wants(kPlaneNormal); ++i) normal[int(i)] = gpu::realOf(int(plane(normalSlot + i)[sample]));
            return seen_.at(x, y, distance[sample], object[sample], normal);
        });
    }
    template <class T>
    static std::span<const uint32_t> wordsOf(const Buffer<T>& buffer) {
        return {static_cast<const uint32_t*>(buffer.data()), buffer.count() * (sizeof(T) / 4)};
    }
    const uint32_t* resolvedLinear(uint32_t channel) const {
        return static_cast<const uint32_t*>(resolvedLinear_.data()) + size_t(channel) * resolvedQuads_ * 4 * resolvedRows_;
    }

    // Pixels whose corners differ, again by the samples of a grid. The band's planes are overwritten, so but for the row that the next band shares.
    void refine(uint32_t firstRow, uint32_t rows, PlaneWriter& writer) {
        const uint32_t linearSlot = linearSlotOf(choices_.planes);
        const std::vector<uint32_t> pixels = pixelsWithDifferentCorners(
            p_.width, firstRow, rows, choices_.encoding,
            [&](uint32_t x, uint32_t y) {
                const size_t sample = size_t(y) * push_.rowWords + x;
                return glm::vec3(gpu::realOf(int(plane(linearSlot)[sample])), gpu::realOf(int(plane(linearSlot + 1)[sample])),
                                 gpu::realOf(int(plane(linearSlot + 2)[sample])));
            },
            [&](uint32_t x, uint32_t y) { return plane(0)[size_t(y) * push_.rowWords + x] != 0; }, threadCount(request_.threads));
        counted_.refinedPixels += pixels.size();
        TraceChoices choices = choices_;
        choices.sampling = gpu::kSampleGrid;
        choices.side = kFineSide;
        choices.planes = gpu::kTracePlaneDistance | gpu::kTracePlaneLinear;
        const size_t chunk = std::max<size_t>(1, bandWords_ / (uint64_t(kFineSide) * kFineSide * slotsOf(choices.planes)));
        Buffer<uint32_t> coarse;  // the band's planes, which the next band takes a row of
        std::swap(coarse, buffers_.planeWords);
        for (size_t first = 0; first < pixels.size(); first += chunk) {
            const std::vector<uint32_t> some(pixels.begin() + ptrdiff_t(first),
                                             pixels.begin() + ptrdiff_t(std::min(pixels.size(), first + chunk)));
            const auto count = uint32_t(some.size());
            dispatches_.put(buffers_.pixels, some, "pixels to refine");
            choices.pixels = some;
            gpu::TracePush push = finePushOf(push_, count);
            buffers_.planeWords.reserve(device_, uint64_t(push.planeWords) * slotsOf(choices.planes), "planes");
            dispatches_.trace(push, choices, 0, push.planeWords, double(push.planeWords));
            resolve(push, choices, kFineSide, kFineSide, count, 1);
            const std::span<const uint32_t> words = wordsOf(resolved_);
            const auto* linear = static_cast<const float*>(resolvedLinear_.data());
            for (size_t i = 0; i < some.size(); ++i)
                writer.replaceColour(some[i] & 0xffffu, some[i] >> 16, words[i], linear + i, size_t(resolvedQuads_) * 4 * resolvedRows_);
        }
        std::swap(coarse, buffers_.planeWords);
    }

    Device& device_;
    const Prepared& p_;
    const RenderRequest& request_;
    const SampleGrid grid_;
    Recorder recorder_;
    TraceDispatches dispatches_;
    TraceChoices& choices_;
    gpu::TracePush& push_;
    TraceBuffers& buffers_;
    RaySeen seen_;
    RenderCounters counted_;
    Buffer<glm::uvec4> resolved_;
    Buffer<glm::vec4> resolvedLinear_;
    uint64_t bandWords_ = 0;  // words of a band
    uint32_t slots_ = 0, resolvedQuads_ = 0, resolvedRows_ = 0;
};

}  // namespace

void traceFrameGpu(Device& device, const Prepared& p, const Scene& scene, const RenderRequest& request, PlaneWriter& writer,
                   RenderResult& result) {
    DeviceTrace(device, p, scene, request).draw(writer, result);
}

std::unique_ptr<ResidentPicture> residentTrace(Device& device, const Prepared& p, const Scene& scene, const RenderRequest& request) {
    return std::make_unique<DeviceTrace>(device, p, scene, request);
}

}  // namespace plumb
