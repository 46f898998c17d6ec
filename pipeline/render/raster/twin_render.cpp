// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/twin_render.h"

#include "host/error.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/render/raster/triangle_seen.h"
#include "pipeline/render/raster/twin_frame.h"
#include "pipeline/render/walk.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

namespace {

// Samples of a band held at once: 20 bytes each with linear colour.
constexpr uint64_t kTwinBandSamples = uint64_t(1) << 25;

void countGeometry(const TwinGeometry& g, RenderCounters& c) {
    c.culledBackFace = g.slots.backFacing;
    c.culledZeroArea = g.slots.zeroArea;
    c.culledOutside = g.slots.outside;
    c.clipped = g.slots.jobs.size();
    c.drawnTriangles = g.slots.drawn;
    for (uint32_t kind : g.clipKinds) c.drawnTriangles += kind >> 1;
}

class TwinRender {
public:
    TwinRender(const Prepared& p, const RenderRequest& request, PlaneWriter& writer, RenderResult& result)
        : p_(p), request_(request), writer_(writer), result_(result), threads_(threadCount(request.threads)), seen_(p) {}

    void draw() {
        TwinPasses passes(p_.list, p_.choices, false, threads_, geometry_);
        const StepBody geometry[] = {{"transform", [&] { passes.transform(); }},
                                     {"illuminate", [&] { passes.illuminate(); }},
                                     {"cull", [&] { passes.cull(); }},
                                     {"setup", [&] { passes.setUp(); }}};
        walk(p_.plan, result_.times, geometry);
        // The normal plane of a picture that is not shaded by normals: the same vertices with normals as attributes.
        if (wantsNormals() && !shadesPixels()) withNormals_ = twinGeometry(p_.list, p_.choices, true, threads_);
        countGeometry(geometry_, result_.counters);
        const uint32_t height = uint32_t(p_.list.frame.height), rows = rowsOfBand();
        const StepBody band[] = {
            {"fill", [&] { fill(); }}, {"shade", [&] { shade(); }}, {"resolve", [&] { write(); }}, {"encode", [&] { write(); }}};
        for (uint32_t firstRow = 0; firstRow < height; firstRow += rows) {
            if (request_.onProgress && !request_.onProgress(double(firstRow) / height)) throw Error(Exit::interrupted, "interrupted");
            band_ = p_.list.frame;
            band_.firstRow = int(firstRow);
            band_.rows = int(std::min(rows, height - firstRow));
            walk(p_.plan, result_.times, band);
            ++result_.counters.bands;
        }
        if (p_.choices.shading == gpu::kShadingFlat) result_.counters.illuminations = p_.list.facePositions.size();
        if (p_.choices.shading == gpu::kShadingGouraud) result_.counters.illuminations = p_.list.positions.size();
        result_.counters.chunks = 1;
    }

private:
    bool wantsNormals() const { return writer_.wants(kPlaneNormal); }
    bool shadesPixels() const { return p_.choices.shading == gpu::kShadingPhong; }

    uint32_t rowsOfBand() const {
        const uint32_t side = p_.side;
        uint32_t rows = uint32_t(std::max<uint64_t>(side, kTwinBandSamples / uint64_t(p_.list.frame.width) / side * side));
        if (request_.knobs.bandRows) rows = request_.knobs.bandRows * side;
        rows += p_.choices.coarse ? rows % 2 : 0;  // 2 x 2 pixels lie in one band
        return std::min(rows, uint32_t(p_.list.frame.height));
    }

    void fill() {
        const size_t samples = size_t(band_.width) * size_t(band_.rows);
        z_.resize(samples);
        draw_.resize(samples);
        fillCpu(band_, geometry_.draws, geometry_.screen, z_, draw_, threads_, p_.choices.depthBits);
    }

    void shade() {
        linear_.resize(3 * draw_.size());
        normal_.assign(wantsNormals() ? 3 * draw_.size() : 0, 0.0f);
        for (size_t i = 0; i < draw_.size(); ++i)
            if (!draw_[i]) std::copy_n(&p_.backgroundLinear.x, 3, linear_.begin() + ptrdiff_t(3 * i));
        const bool flat = p_.choices.shading == gpu::kShadingFlat;
        shadeCpu(band_, p_.list, p_.choices, geometry_.draws, geometry_.screen, flat ? geometry_.faceColours : geometry_.attributes, z_,
                 draw_, linear_, shadesPixels() ? std::span<float>(normal_) : std::span<float>(), threads_);
        if (!wantsNormals() || shadesPixels()) return;
        std::vector<float> unused(linear_.size());
        shadeCpu(band_, p_.list, forNormals(p_.choices), geometry_.draws, geometry_.screen, withNormals_.attributes, z_, draw_, unused,
                 normal_, threads_);
    }

    void write() {
        const uint32_t side = p_.side, rows = uint32_t(band_.rows) / side, firstRow = uint32_t(band_.firstRow) / side;
        const SampleLayout layout{uint32_t(band_.width), side, side, side / 2};
        const std::span<const int> drawn(z_);
        writer_.takeColours(firstRow, rows, {layout, linear_, drawn}, threads_);
        const uint64_t samples = writer_.takeCoverage(rows, layout, drawn);
        if (shadesPixels()) result_.counters.illuminations += samples;
        writer_.takeSeen(firstRow, rows, layout, drawn, [&](uint32_t x, uint32_t y, size_t at) {
            const float* n = normal_.empty() ? nullptr : &normal_[3 * at];
            return seen_.at(x, y, z_[at], geometry_.draws[draw_[at] - 1].source, n ? glm::vec3(n[0], n[1], n[2]) : glm::vec3(0));
        });
    }

    const Prepared& p_;
    const RenderRequest& request_;
    PlaneWriter& writer_;
    RenderResult& result_;
    const uint32_t threads_;
    TriangleSeen seen_;
    TwinGeometry geometry_, withNormals_;
    gpu::FrameBox band_{};
    std::vector<int> z_;
    std::vector<uint32_t> draw_;  // drawn triangle + 1 of each sample
    std::vector<float> linear_, normal_;
};

}  // namespace

void drawRasterCpu(const Prepared& p, const RenderRequest& request, PlaneWriter& writer, RenderResult& result) {
    TwinRender(p, request, writer, result).draw();
}

}  // namespace plumb
