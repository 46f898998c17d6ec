// SPDX-License-Identifier: MIT
#include "pipeline/render/wire/wire.h"

#include "pipeline/passes/lines.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/render/notes/notes.h"
#include "pipeline/render/notes/polygons.h"
#include "pipeline/render/planes.h"
#include "pipeline/render/preparing.h"
#include "pipeline/render/raster/raster.h"
#include "pipeline/render/stage_check.h"
#include "pipeline/render/walk.h"
#include "pipeline/scene/flattened.h"

#include <fmt/core.h>
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

gpu::LinesPush linesPush(const Prepared& p, const DrawList::Range& r) {
    gpu::LinesPush push{};
    push.firstEdge = r.firstEdge;
    push.edgeNumber = r.firstEdge;
    push.edgeCount = r.edgeCount;
    push.object = r.record;
    push.width = p.list.frame.width;
    push.height = p.list.frame.height;
    push.rows = p.list.frame.height;
    push.rowPixels = uint32_t(p.list.frame.width);
    push.surfaceRows = p.list.frame.height;
    push.viewport = p.list.viewport;
    push.viewport.guardX = p.list.viewport.centreX + 1.0f;
    push.viewport.guardY = p.list.viewport.centreY + 1.0f;
    return push;
}

// What the filled picture shows at each sample of the frame: bits of z, and the face in the draw list. Drawn by the passes of the fill on the same
// side, and counted and timed with the lines. Empty where hidden lines are drawn as well.
std::vector<glm::uvec2> surfacesOf(Device* device, const Scene& scene, const Prepared& p, const RenderRequest& request,
                                   RenderResult& result) {
    if (request.wire != WireView::solid) return {};
    RenderRequest filled = request;
    filled.shading = Shading::unlit;
    filled.fill = Fill::exact;
    filled.width = uint32_t(p.list.frame.width);  // a sample is a pixel of this picture
    filled.height = uint32_t(p.list.frame.height);
    filled.samples = 1;
    filled.transparent = false;
    filled.planes = kPlaneColour | kPlaneZ | kPlaneTriangle;
    RenderResult seen;
    if (p.side > 1 && scene.camera->focalPixels > 0) {
        Scene larger = scene;
        larger.camera->focalPixels *= p.side;
        seen = render(device, larger, filled);
    } else {
        seen = render(device, scene, filled);
    }
    std::vector<glm::uvec2> surfaces(seen.frame.z.size());
    for (size_t i = 0; i < surfaces.size(); ++i) {
        const uint32_t triangle = seen.frame.triangle[i];
        surfaces[i] = {gpu::ubitsOf(seen.frame.z[i]), triangle == kNone ? gpu::kNoFace : p.list.triangleFace[triangle]};
    }
    result.counters = seen.counters;
    result.times = seen.times;
    for (const PlanStep& step : seen.plan.steps)
        if (!step.ran) result.plan.skip(step.name, step.idle);
    if (seen.plan.steps.empty())
        for (const PlanStep& step : result.plan.steps) result.plan.skip(step.name, "nothing to draw");
    return surfaces;
}

// An edge belongs to an object and to no single face, and has no depth.
struct EdgeSeen : SeenNothing {
    const DrawList& list;
    const uint32_t edge;
    EdgeSeen(const DrawList& drawn, uint32_t shown) : list(drawn), edge(shown) {}
    uint32_t object() const {
        for (const DrawList::Range& r : list.ranges)
            if (edge >= r.firstEdge && edge < r.firstEdge + r.edgeCount) return r.sceneObject;
        return kNone;
    }
};

// Owner -> diffuse colour of the edge's material; samples are resolved in linear light.
void finishWire(const Prepared& p, const RenderRequest& request, std::span<const uint32_t> owners, PlaneWriter& writer,
                RenderResult& result) {
    std::vector<float> linear(3 * owners.size());
    std::vector<int> drawn(owners.size());
    for (size_t i = 0; i < owners.size(); ++i) {
        drawn[i] = owners[i] != gpu::kNoEdge;
        const glm::vec3 c = drawn[i] ? p.list.materials[p.list.vertexMaterial[p.list.edges[owners[i]].x]].diffuse : p.backgroundLinear;
        std::copy_n(&c.x, 3, linear.begin() + ptrdiff_t(3 * i));
    }
    const SampleLayout layout{uint32_t(p.list.frame.width), p.side, p.side, p.side / 2};
    writer.takeColours(0, p.height, {layout, linear, drawn}, threadCount(request.threads));
    writer.takeCoverage<int>(p.height, layout, drawn);
    writer.takeSeen<int>(0, p.height, layout, drawn, [&](uint32_t, uint32_t, size_t at) { return EdgeSeen(p.list, owners[at]); });
    result.counters.edges = p.list.edges.size();
    if (request.wire != WireView::solid) result.counters.bands = result.counters.chunks = 1;
}

std::vector<uint32_t> ownersCpu(const Prepared& p, const std::vector<glm::uvec2>& surfaces) {
    std::vector<uint32_t> owners(size_t(p.list.frame.width) * size_t(p.list.frame.height), gpu::kNoEdge);
    for (const DrawList::Range& r : p.list.ranges)
        linesCpu(linesPush(p, r), p.list.edges, p.list.positions, p.list.objects, owners, {p.list.edgeFace, surfaces});
    return owners;
}

std::vector<uint32_t> ownersGpu(Device& device, const Prepared& p, const RenderRequest& request, const std::vector<glm::uvec2>& surfaces,
                                RenderResult& result) {
    const DeviceLimits& limits = device.limits();
    Recorder recorder(device);
    recorder.allow(p.plan.labels(RunsOn::device));
    if (p.list.edges.empty()) result.plan.skip("lines", "no edge is in the view");
    const uint64_t pitch = uint64_t(p.list.frame.width);
    std::vector<uint32_t> all(size_t(pitch) * size_t(p.list.frame.height), gpu::kNoEdge);
    Buffer<gpu::ObjectRecord> objects(device, std::max<size_t>(1, p.list.objects.size()), "objects");
    objects.upload(p.list.objects);
    // A pixel of the surfaces has two words, and a band the rows beside it.
    const uint64_t fitting = std::min(limits.storageRangeBytes / (surfaces.empty() ? 4 : 8), limits.texelElements) / pitch;
    uint64_t bandRows = surfaces.empty() ? std::max<uint64_t>(1, fitting) : std::max<uint64_t>(3, fitting) - 2;
    if (request.knobs.bandRows) bandRows = std::min<uint64_t>(bandRows, request.knobs.bandRows);
    // Edges in chunks, each with the vertices that its edges name.
    uint64_t chunkEdges = std::max<uint64_t>(1, std::min(limits.storageRangeBytes / 32, limits.texelElements / 2));
    if (request.knobs.chunkTriangles) chunkEdges = std::min(chunkEdges, request.knobs.chunkTriangles);
    for (uint64_t firstRow = 0; firstRow < uint64_t(p.list.frame.height); firstRow += bandRows) {
        const uint64_t rows = std::min(bandRows, uint64_t(p.list.frame.height) - firstRow);
        Buffer<uint32_t> owners(device, rows * pitch, "edge owners");
        owners.fill(gpu::kNoEdge);
        const uint64_t surfaceFirst = firstRow > 0 ? firstRow - 1 : 0,
                       surfaceEnd = std::min(firstRow + rows + 1, uint64_t(p.list.frame.height));
        Buffer<glm::uvec2> surfaceBand(device, surfaces.empty() ? 1 : (surfaceEnd - surfaceFirst) * pitch, "surfaces");
        if (!surfaces.empty()) surfaceBand.upload(std::span(surfaces).subspan(surfaceFirst * pitch, (surfaceEnd - surfaceFirst) * pitch));
        for (const DrawList::Range& r : p.list.ranges)
            for (uint64_t first = 0; first < r.edgeCount; first += chunkEdges) {
                const uint64_t count = std::min<uint64_t>(chunkEdges, r.edgeCount - first);
                Buffer<glm::uvec2> edges(device, count, "edges");
                Buffer<glm::vec4> positions(device, 2 * count, "edge ends");
                for (uint64_t i = 0; i < count; ++i) {
                    const glm::uvec2 e = p.list.edges[r.firstEdge + first + i];
                    positions.span()[2 * i] = p.list.positions[e.x];
                    positions.span()[2 * i + 1] = p.list.positions[e.y];
                    edges.span()[i] = {uint32_t(2 * i), uint32_t(2 * i + 1)};
                }
                gpu::LinesPush push = linesPush(p, r);
                push.firstEdge = 0;
                push.edgeCount = uint32_t(count);
                push.edgeNumber = uint32_t(r.firstEdge + first);
                push.firstRow = int(firstRow);
                push.rows = int(rows);
                if (surfaces.empty()) {
                    recordLines(recorder, push, {}, edges, positions, objects, owners);
                    recorder.run(request.watchdogMs);
                    continue;
                }
                push.surfaceRow = int(surfaceFirst);
                push.surfaceRows = int(surfaceEnd - surfaceFirst);
                Buffer<uint32_t> edgeFaces(device, count, "edge faces");
                edgeFaces.upload(std::span(p.list.edgeFace).subspan(r.firstEdge + first, count));
                recordHiddenLines(recorder, push, {}, edges, positions, objects, owners, edgeFaces, surfaceBand);
                recorder.run(request.watchdogMs);
            }
        std::copy_n(owners.span().begin(), rows * pitch, all.begin() + ptrdiff_t(firstRow * pitch));
    }
    const std::vector<PassTime> lines = recorder.takeTimes();
    result.times.insert(result.times.end(), lines.begin(), lines.end());
    return all;
}

void refuseWire(const Scene& scene, const RenderRequest& request) {
    if (request.fill == Fill::notes) refuseOtherTrade(request);
    refuseNoZBuffer(scene);
    refuseShapes(scene);
    const uint64_t side = sideOf(request), limit = uint64_t(gpu::kLineFrameLimit);
    if (request.width * side > limit || request.height * side > limit)
        throw usageError(fmt::format("--shading wire draws at most {0}x{0} samples", gpu::kLineFrameLimit));
}

// Projects the vertices of objects that need more than float32 on the host: what the lines pass multiplies is then clip space already.
void projectLong(DrawList& list) {
    for (const DrawList::Range& r : list.ranges) {
        if (r.precision == Precision::fp32) continue;
        const gpu::LongRecord& record = list.longs[r.record];
        for (uint32_t v = r.firstVertex; v < r.firstVertex + r.vertexCount; ++v) {
            const glm::vec3 p(list.positions[v]);
            list.positions[v] = glm::vec4(r.precision == Precision::fp64 ? gpu::doubleClip(record, p) : gpu::blockClip(record, p), 1.0f);
        }
        gpu::ObjectRecord& o = list.objects[r.record];
        o.rowX = {1, 0, 0, 0};
        o.rowY = {0, 1, 0, 0};
        o.rowW = {0, 0, 1, 0};
    }
}

void addEdges(const Scene& scene, const RenderRequest& request, const Pinhole& view, DrawList& list) {
    const bool solid = request.wire == WireView::solid;
    const WireChoices choices{request.wirePerPolygon || solid, request.wire == WireView::culled};
    for (DrawList::Range& r : list.ranges) {
        const Object& object = scene.objects[r.sceneObject];
        r.firstEdge = uint32_t(list.edges.size());
        for (const WireEdge& e : wireEdges(scene.meshes[object.mesh], worldFromMesh(scene, object), view.eye, choices)) {
            list.edges.push_back(e.vertex + r.firstVertex);
            if (solid) list.edgeFace.push_back(r.firstFace + e.face);
        }
        r.edgeCount = uint32_t(list.edges.size()) - r.firstEdge;
    }
}

Prepared prepareWire(const Scene& scene, const RenderRequest& request, RunsOn side) {
    Preparing it(scene, request, gpu::kShadingUnlit, request.wire == WireView::solid ? kWayHiddenLines : kWayWire);
    it.dropRays(raysAskedBy(scene));
    it.chooseArithmetic();
    it.addObjects();
    projectLong(it.p.list);
    addEdges(scene, request, it.view, it.p.list);
    it.addLights();
    it.drop(DropStage::steps);
    StepList steps(request, it.p, side);
    if (request.wire == WireView::solid) {
        addSurfaceSteps(steps, it.p, false);
        if (!steps.onDevice()) {
            steps.add("shade", "the colour of the triangle's corners or face, at each sample");
            steps.addColours(1, side, "");
        }
    }
    steps.add("lines", "edges, pixel by pixel");
    steps.addColours(it.p.side * it.p.side, RunsOn::host, "");
    Plan& plan = it.p.plan;
    if (request.wire == WireView::solid)
        plan.choices.push_back("wire: hidden lines are removed by the filled picture's depth and faces, polygon by polygon");
    if (request.wire == WireView::culled) plan.choices.push_back("wire: edges of polygons that face the viewer");
    if (request.wirePerPolygon) plan.choices.push_back("edges: as often as polygons have them");
    return it.finish();
}

class WirePicture : public PreparedPicture {
public:
    using PreparedPicture::PreparedPicture;

    void verifyStages(Device& device, StageCheck& check) override {
        RenderResult unused;
        unused.plan = p_.plan;
        const std::vector<glm::uvec2> surfaces = surfacesOf(nullptr, scene_, p_, request_, unused);
        check.compare<uint32_t>("lines", "edge of sample", ownersCpu(p_, surfaces), ownersGpu(device, p_, request_, surfaces, unused));
    }

private:
    void draw(Device* device, PlaneWriter& writer, RenderResult& result) override {
        const std::vector<glm::uvec2> surfaces = surfacesOf(device, scene_, p_, request_, result);
        std::vector<uint32_t> owners;
        if (device != nullptr) {
            owners = ownersGpu(*device, p_, request_, surfaces, result);
        } else {
            const StepBody twin[] = {{"lines", [&] { owners = ownersCpu(p_, surfaces); }}};
            walk(p_.plan, result.times, twin);
        }
        // A filled picture under the lines may have an "encode" of its own.
        const StepBody host[] = {{p_.side > 1 ? "resolve" : "encode", [&] { finishWire(p_, request_, owners, writer, result); }}};
        walk(p_.plan, result.times, host);
    }
};

std::unique_ptr<PreparedPicture> pictureOf(const Scene& scene, const RenderRequest& request, Prepared prepared) {
    return std::make_unique<WirePicture>(scene, request, std::move(prepared));
}

}  // namespace

const Technique kWire = {
    .name = "wire",
    .refuse = refuseWire,
    .prepare = prepareWire,
    .picture = pictureOf,
    .leavesToRays = raysAskedBy,
    .planes = kPlanesOfLines,
    .vertices = Technique::Vertices::linesPass,
};

}  // namespace plumb
