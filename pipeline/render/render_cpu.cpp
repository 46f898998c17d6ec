// SPDX-License-Identifier: MIT
// The twin draws: the whole list at once, the frame in bands of rows to bound memory.
#include "pipeline/passes/parallel.h"
#include "pipeline/render/notes/notes.h"
#include "pipeline/render/notes/spheres_frame.h"
#include "pipeline/render/raster/triangle_seen.h"
#include "pipeline/render/raster/twin_frame.h"
#include "pipeline/render/rays/trace_frame.h"
#include "pipeline/render/stopwatch.h"
#include "pipeline/render/wire/wire.h"
#include "pipeline/scene/plain_floats.h"

#include <algorithm>
#include <bit>
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
    c.culledBackFace = g.places.backFacing;
    c.culledZeroArea = g.places.zeroArea;
    c.culledOutside = g.places.outside;
    c.clipped = g.places.jobs.size();
    c.drawnTriangles = g.places.drawn;
    for (uint32_t kind : g.clipKinds) c.drawnTriangles += kind >> 1;
}

void drawRaster(const Prepared& p, const RenderRequest& request, PlaneWriter& writer, RenderResult& result) {
    const uint32_t threads = threadCount(request.threads);
    const DrawList& list = p.list;
    const uint32_t side = p.side;
    const bool wantNormal = request.planes & kPlaneNormal;
    const TwinGeometry g = twinGeometry(list, p.choices, false, threads, &result.times);
    // The normal plane of a picture that is not shaded by normals: the same vertices, carrying normals.
    const TwinGeometry withNormals =
        wantNormal && p.choices.shading != gpu::kShadingPhong ? twinGeometry(list, p.choices, true, threads, nullptr) : TwinGeometry{};
    countGeometry(g, result.counters);
    uint32_t bandRows = uint32_t(std::max<uint64_t>(side, kTwinBandSamples / uint64_t(list.frame.width) / side * side));
    if (request.bandRows) bandRows = request.bandRows * side;
    bandRows += p.choices.coarse ? bandRows % 2 : 0;  // 2 x 2 pixels lie in one band
    bandRows = std::min(bandRows, uint32_t(list.frame.height));
    std::vector<int> z;
    std::vector<uint32_t> draw;
    std::vector<float> linear, normal;
    TriangleSeen seen(p);
    const float background[3] = {request.background.x, request.background.y, request.background.z};
    for (uint32_t firstRow = 0; firstRow < uint32_t(list.frame.height); firstRow += bandRows) {
        if (request.onProgress && !request.onProgress(double(firstRow) / list.frame.height)) throw Error(Exit::interrupted, "interrupted");
        gpu::FrameBox band = list.frame;
        band.firstRow = int(firstRow);
        band.rows = int(std::min(bandRows, uint32_t(list.frame.height) - firstRow));
        const size_t samples = size_t(band.width) * size_t(band.rows);
        z.resize(samples);
        draw.resize(samples);
        linear.resize(3 * samples);
        normal.assign(wantNormal ? 3 * samples : 0, 0.0f);
        {
            const Stopwatch watch(&result.times, "fill");
            fillCpu(band, g.draws, g.screen, z, draw, threads, p.choices.depthBits);
        }
        {
            const Stopwatch watch(&result.times, "shade");
            for (size_t i = 0; i < samples; ++i)
                if (!draw[i]) std::copy(background, background + 3, linear.begin() + ptrdiff_t(3 * i));
            const bool flat = p.choices.shading == gpu::kShadingFlat, phong = p.choices.shading == gpu::kShadingPhong;
            shadeCpu(band, list, p.choices, g.draws, g.screen, flat ? g.faceColours : g.carried, z, draw, linear,
                     phong ? std::span<float>(normal) : std::span<float>(), threads);
            if (wantNormal && !phong) {
                std::vector<float> unused(linear.size());
                shadeCpu(band, list, forNormals(p.choices), g.draws, g.screen, withNormals.carried, z, draw, unused, normal, threads);
            }
        }
        const uint32_t rows = uint32_t(band.rows) / side, firstPixelRow = firstRow / side;
        const SampleLayout layout{uint32_t(band.width), side, side, side / 2};
        const std::span<const int> drawn(z);
        const Stopwatch watch(&result.times, side > 1 ? "resolve" : "encode");
        writer.takeColours(firstPixelRow, rows, {layout, linear, drawn}, threads);
        writer.takeCoverage(rows, layout, drawn);
        writer.takeSeen(firstPixelRow, rows, layout, drawn, [&](uint32_t x, uint32_t y, size_t at) {
            const float* n = wantNormal ? &normal[3 * at] : nullptr;
            return seen.at(x, y, z[at], g.draws[draw[at] - 1].source, n ? glm::vec3(n[0], n[1], n[2]) : glm::vec3(0));
        });
        for (uint32_t d : draw) result.counters.illuminations += d != 0;
        ++result.counters.bands;
    }
    if (p.choices.shading == gpu::kShadingFlat) result.counters.illuminations = list.facePositions.size();
    if (p.choices.shading == gpu::kShadingGouraud) result.counters.illuminations = list.positions.size();
    if (p.choices.shading == gpu::kShadingUnlit) result.counters.illuminations = 0;
    result.counters.chunks = 1;
}

}  // namespace

RenderResult renderCpu(const Scene& scene, const RenderRequest& request) {
    const PlainFloats plain;
    const Stopwatch total(nullptr, "");
    const Prepared p = prepare(scene, request, RunsOn::twin);
    RenderResult result;
    result.plan = p.plan;
    result.counters = p.counters;
    PlaneWriter writer(p, request, result.frame);
    if (request.shading == Shading::ray)
        traceFrameCpu(p, scene, request, result);
    else if (request.shading == Shading::wire)
        drawWireCpu(scene, p, request, result);
    else if (drawsSpheres(scene, request))
        drawSpheresCpu(scene, p, request, result);
    else if (request.fill == Fill::notes)
        drawNotesCpu(scene, p, request, result);
    else if (p.list.triangles.empty())  // the picture is the background, which the writer has put there
        result.counters.bands = result.counters.chunks = 1;
    else
        drawRaster(p, request, writer, result);
    result.plan.close(result.times);
    result.totalMs = total.elapsedMs();
    return result;
}

}  // namespace plumb
