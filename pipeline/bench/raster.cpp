// SPDX-License-Identifier: MIT
#include "pipeline/bench/raster.h"

#include "host/graphics.h"
#include "pipeline/bench/agreement.h"
#include "pipeline/render/prepare.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <bench_spirv/baseline_frag.h>
#include <bench_spirv/baseline_vert.h>
#include <glm/glm.hpp>
#include <span>
#include <utility>

namespace plumb {
namespace {

constexpr uint32_t kMostLights = 4;  // limit of baseline.frag
constexpr uint32_t kWarmFrames = 3;  // warm-up frames of each side: the first compiles shaders, the second touches memory

// Push constants of baseline.glsl.
struct BaselinePush {
    glm::vec4 rowX, rowY, rowW, base, diffuse, specular, rayX;
    glm::vec3 rayY;
    float near;
};
static_assert(sizeof(BaselinePush) == 128);

struct BaselineVertex {
    glm::vec3 position, normal;
};

class Baseline {
public:
    Baseline(Device& device, const Prepared& prepared)
        : pipeline_(device, setupOf(prepared)),
          vertices_(device, std::max<size_t>(1, prepared.list.positions.size()), "baseline vertices"),
          indices_(device, std::max<size_t>(1, prepared.list.triangles.size() * 3), "baseline indices") {
        const DrawList& list = prepared.list;
        for (const DrawList::Range& r : list.ranges) {
            const gpu::ObjectRecord& o = list.objects[r.record];
            for (uint32_t v = r.firstVertex; v < r.firstVertex + r.vertexCount; ++v) {
                const glm::vec3 n(list.normals[v]);
                vertices_.span()[v] = {
                    glm::vec3(list.positions[v]),
                    {gpu::rowTimesVector(o.normal0, n), gpu::rowTimesVector(o.normal1, n), gpu::rowTimesVector(o.normal2, n)}};
            }
            addDraws(list, r);
        }
        pipeline_.record(uint32_t(list.frame.width), uint32_t(list.frame.height), {0, 0, float(list.frame.width), float(list.frame.height)},
                         0, vertices_, indices_, draws_, false);
    }
    void draw(double watchdogMs) { pipeline_.run(watchdogMs); }
    std::span<const uint32_t> pixels() const { return pipeline_.colour(); }

private:
    static GraphicsSetup setupOf(const Prepared& prepared) {
        const std::vector<gpu::LightRecord>& lights = prepared.list.lights;
        GraphicsSetup setup;
        setup.vertexWords = kBaselineVert;
        setup.fragmentWords = kBaselineFrag;
        setup.vertexBytes = sizeof(BaselineVertex);
        setup.inputs = {{VertexFormat::float3, offsetof(BaselineVertex, position)},
                        {VertexFormat::float3, offsetof(BaselineVertex, normal)}};
        setup.cullBackFaces = prepared.list.cullBackFaces != 0;
        setup.pushBytes = sizeof(BaselinePush);
        setup.fragmentConstants = {uint32_t(lights.size()), prepared.choices.parts.specular ? 1u : 0u};
        for (uint32_t i = 0; i < kMostLights; ++i) {
            const gpu::LightRecord l = i < lights.size() ? lights[i] : gpu::LightRecord{};
            for (const float x :
                 {l.kind, l.position.x, l.position.y, l.position.z, l.intensity.x, l.intensity.y, l.intensity.z, l.attenuation})
                setup.fragmentConstants.push_back(gpu::ubitsOf(x));
        }
        return setup;
    }

    // Adds one draw for each material of the object, triangles in the order of the file.
    void addDraws(const DrawList& list, const DrawList::Range& r) {
        const gpu::ObjectRecord& o = list.objects[r.record];
        const float perX = 2.0f / float(list.frame.width), perY = 2.0f / float(list.frame.height);
        for (uint32_t m = 0; m < list.materials.size(); ++m) {
            GraphicsDraw draw;
            draw.firstIndex = filled_;
            for (uint32_t t = r.firstTriangle; t < r.firstTriangle + r.triangleCount; ++t)
                if (list.triangles[t].w == m)
                    for (int i = 0; i < 3; ++i) indices_.span()[filled_++] = list.triangles[t][i];
            draw.indexCount = filled_ - draw.firstIndex;
            if (draw.indexCount == 0) continue;
            const gpu::MaterialRecord& material = list.materials[m];
            const BaselinePush push{o.rowX * perX,
                                    o.rowY * perY,
                                    o.rowW,
                                    {material.base, material.shininess},
                                    {material.diffuse, list.rayOrigin.x},
                                    {material.specular, list.rayOrigin.y},
                                    {list.rayX, list.rayOrigin.z},
                                    list.rayY,
                                    list.viewport.near};
            draw.push.resize(sizeof push / 4);
            std::memcpy(draw.push.data(), &push, sizeof push);
            draws_.push_back(std::move(draw));
        }
    }

    GraphicsPipeline pipeline_;
    Buffer<BaselineVertex> vertices_;
    Buffer<uint32_t> indices_;
    std::vector<GraphicsDraw> draws_;
    uint32_t filled_ = 0;
};

RenderRequest requestOf(const RasterOptions& options) {
    RenderRequest request;
    request.width = options.width;
    request.height = options.height;
    request.shading = Shading::phong;
    request.encoding = Encoding::linear;  // an R8G8B8A8_UNORM attachment encodes linearly
    request.watchdogMs = options.watchdogMs;
    return request;
}

// Medians of a few pictures drawn apart from the pairs. Each pass waits for the pass before, which costs time of its own.
std::vector<PassTime> medianPasses(ResidentScene& scene) {
    constexpr uint32_t kPictures = 9;
    std::vector<std::vector<PassTime>> pictures;
    for (uint32_t i = 0; i < kPictures; ++i) pictures.push_back(scene.timePasses());
    std::vector<PassTime> passes = pictures[0];
    for (size_t p = 0; p < passes.size(); ++p) {
        std::vector<double> ms;
        for (const std::vector<PassTime>& picture : pictures)
            if (p < picture.size()) ms.push_back(picture[p].ms);
        passes[p].ms = spreadOf(ms).median;
    }
    return passes;
}

}  // namespace

PassesRow benchPasses(Device& device, const Scene& scene, const std::string& name, const RasterOptions& options) {
    ResidentScene compute(device, scene, requestOf(options));
    PassesRow row;
    row.name = name;
    row.width = options.width;
    row.height = options.height;
    for (uint32_t i = 0; i < kWarmFrames; ++i) compute.draw();
    std::vector<double> ms;
    for (uint32_t i = 0; i < options.pairs; ++i) {
        if (options.onProgress) options.onProgress(double(i) / options.pairs);
        ms.push_back(msOf([&] { compute.draw(); }));
    }
    row.ms = spreadOf(ms);
    row.resident = compute.resident();
    row.counters = compute.counters();
    row.triangles = row.counters.triangles;
    row.lights = scene.lights.size();
    row.passes = medianPasses(compute);
    return row;
}

RasterRow benchRaster(Device& device, const Scene& scene, const std::string& name, const RasterOptions& options) {
    const RenderRequest request = requestOf(options);
    const Prepared prepared = prepare(scene, request);
    if (prepared.list.lights.size() > kMostLights)
        throw inputError(scene.path, fmt::format("{} lights; the graphics pipeline of the benchmark takes at most {}",
                                                 prepared.list.lights.size(), kMostLights));
    Baseline graphics(device, prepared);
    ResidentScene compute(device, scene, request);

    RasterRow row;
    row.name = name;
    row.triangles = prepared.list.triangles.size();
    row.width = options.width;
    row.height = options.height;
    ResidentScene::Picture picture;
    const auto drawGraphics = [&] { graphics.draw(options.watchdogMs); };
    const auto drawCompute = [&] { picture = compute.draw(); };
    for (uint32_t i = 0; i < kWarmFrames; ++i) drawGraphics(), drawCompute();
    row.agreement =
        agreementOf(prepared.list, options.width, options.height,
                    {picture.pixels, size_t(picture.pitch) * (picture.height - 1) + picture.width}, picture.pitch, graphics.pixels());
    std::vector<double> graphicsMs, computeMs;
    for (uint32_t i = 0; i < options.pairs; ++i) {
        if (options.onProgress) options.onProgress(double(i) / options.pairs);
        // Sides take turns in going first, because the second finds the caches of the first.
        if (i % 2 == 0) graphicsMs.push_back(msOf(drawGraphics));
        computeMs.push_back(msOf(drawCompute));
        if (i % 2 != 0) graphicsMs.push_back(msOf(drawGraphics));
    }
    row.resident = compute.resident();
    row.counters = compute.counters();
    row.passes = medianPasses(compute);
    row.graphicsMs = spreadOf(graphicsMs);
    row.computeMs = spreadOf(computeMs);
    row.ratio = ratioOf(graphicsMs, computeMs);
    row.ratioOfLeast = row.graphicsMs.least / row.computeMs.least;
    return row;
}

}  // namespace plumb
