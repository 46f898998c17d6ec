// SPDX-License-Identifier: MIT
#include "pipeline/bench/trace.h"

#include "pipeline/bench/meshes.h"
#include "pipeline/bench/trace_peers.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/render/rays/trace_frame.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <glm/glm.hpp>
#include <memory>

namespace plumb {

namespace {

uint32_t addMaterial(Scene& scene, const glm::vec3& colour, float reflect) {
    Material m;
    m.ambient = colour * 0.3f;
    m.diffuse = colour * 0.7f;
    m.specular = glm::vec3(0.4f);
    m.shininess = 60;
    m.reflect = reflect;
    m.local = 1 - reflect;
    scene.materials.push_back(m);
    return uint32_t(scene.materials.size() - 1);
}

// Scene of mirrors over a board that mirrors a little, one point light with shadow rays: `count` spheres in rows of five.
Scene spheresOverBoard(uint32_t count) {
    Scene scene;
    scene.path = fmt::format("spheres{}", count);
    scene.materials.push_back({});
    const uint32_t colours[4] = {addMaterial(scene, {0.8f, 0.2f, 0.2f}, 0.5f), addMaterial(scene, {0.2f, 0.7f, 0.3f}, 0.5f),
                                 addMaterial(scene, {0.2f, 0.4f, 0.9f}, 0.5f), addMaterial(scene, {0.9f, 0.8f, 0.3f}, 0.5f)};
    const uint32_t dark = addMaterial(scene, glm::vec3(0.15f), 0.1f), light = addMaterial(scene, glm::vec3(0.9f), 0.1f);
    const uint32_t columns = count > 4 ? 5 : count;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t column = i % columns, row = i / columns;
        const double x = (column - (columns - 1) / 2.0) * 2.2, z = row * -2.2;
        scene.spheres.push_back({"", {x, 1, z}, 1, colours[i % 4]});
    }
    PlaneShape board;
    board.material = dark;
    board.square = 1;
    board.otherMaterial = light;
    scene.planes.push_back(board);
    Light lamp;
    lamp.directional = false;
    lamp.position = {-6, 10, 8};
    lamp.intensity = glm::vec3(0.8f);
    scene.lights = {lamp};
    Camera camera;
    camera.eye = {0, 3, 9};
    camera.forward = glm::normalize(glm::dvec3(0, -0.25, -1));
    camera.right = {1, 0, 0};
    camera.up = glm::cross(camera.right, camera.forward);
    camera.focusDistance = 9;
    scene.camera = camera;
    scene.background = glm::vec3(0.4f, 0.6f, 0.9f);
    return scene;
}

// Measures pairs; the sides take turns in going first.
void measurePairs(TraceRow& row, const TraceBenchOptions& options, const std::function<void()>& ours, const std::function<void()>& theirs) {
    ours();
    theirs();
    std::vector<double> mine, other;
    for (uint32_t i = 0; i < options.pairs; ++i) {
        if (options.onProgress) options.onProgress(double(i) / options.pairs);
        double a = 0, b = 0;
        if (i % 2)
            a = msOf(ours), b = msOf(theirs);
        else
            b = msOf(theirs), a = msOf(ours);
        mine.push_back(a);
        other.push_back(b);
    }
    row.oursMs = spreadOf(mine);
    row.theirsMs = spreadOf(other);
    row.ratio = ratioOf(other, mine);
    row.ratioOfLeast = row.theirsMs.least / row.oursMs.least;
}

void judge(TraceRow& row) {
    row.allowed = kTraceShare;
    const double share = double(row.differ) / (double(row.width) * row.height);
    if (!(share <= kTraceShare))
        row.failure =
            fmt::format("{} of {} pixels disagree, more than {:g} %", row.differ, uint64_t(row.width) * row.height, 100 * kTraceShare);
}

RenderRequest requestOf(const Scene& scene, const TraceBenchOptions& options) {
    RenderRequest request;
    request.width = options.width;
    request.height = options.height;
    request.shading = Shading::ray;
    request.encoding = Encoding::linear;
    request.background = scene.background.value_or(glm::vec3(0));
    request.transparent = true;  // alpha is coverage
    request.watchdogMs = options.watchdogMs;
    return request;
}

TraceRow rowOf(const std::string& name, const std::string& theirs, const TraceBenchOptions& options) {
    TraceRow row;
    row.name = name;
    row.theirs = theirs;
    row.width = options.width;
    row.height = options.height;
    return row;
}

void countWork(TraceRow& row, ResidentPicture& ours) {
    for (const auto& r : ours.counters().rays) {
        row.rays += r.primary + r.reflected + r.refracted;
        row.shadowRays += r.shadowRays;
    }
    ours.recorder().takeTimes();
    const double ms = msOf([&] { ours.draw(); });
    uint32_t dispatches = 0;
    for (const PassTime& t : ours.recorder().takeTimes()) dispatches += t.dispatches;
    row.longestDispatchMs = ms / std::max(1u, dispatches);
}

void drawOrThrow(ResidentPicture& ours) {
    if (!ours.draw()) throw renderError("the device's buffers do not hold the picture in one band; take a smaller --size");
}

TraceRow benchSpheres(Device& device, uint32_t count, const TraceBenchOptions& options) {
    const Scene scene = spheresOverBoard(count);
    const RenderRequest request = requestOf(scene, options);
    const uint32_t threads = threadCount(options.threads);
    TraceRow row = rowOf(scene.path, fmt::format("C++, {} threads", threads), options);
    row.objects = count;
    const Prepared prepared = prepare(scene, request);
    const TraceScene traced = traceSceneOf(scene, prepared);
    const gpu::TracePush push = tracePushOf(prepared, request, traced);
    const std::unique_ptr<ResidentPicture> ours = residentTrace(device, prepared, scene, request);
    std::vector<uint32_t> theirs(size_t(options.width) * options.height);
    measurePairs(
        row, options, [&] { drawOrThrow(*ours); }, [&] { peers::traceNative(push, traced, options.height, theirs, threads); });
    const ResidentScene::Picture shown = ours->pixels();
    for (uint32_t y = 0; y < options.height; ++y)
        for (uint32_t x = 0; x < options.width; ++x) {
            const uint32_t a = shown.pixels[size_t(y) * shown.pitch + x], b = theirs[size_t(y) * options.width + x];
            bool far = false;
            for (int shift = 0; shift < 32; shift += 8) far |= std::abs(int(a >> shift & 255) - int(b >> shift & 255)) > 4;
            row.differ += far;
        }
    judge(row);
    countWork(row, *ours);
    return row;
}

std::vector<TraceRow> benchMesh(Device& device, const std::string& name, const TraceBenchOptions& options,
                                std::vector<std::string>& absent) {
    std::string why;
    if (!peers::hasEmbree(why)) {
        absent.push_back(fmt::format("{}: {}", name, why));
        return {};
    }
    Scene scene = *benchScene("sphere" + name.substr(4), double(options.width) / options.height);
    scene.lights.clear();  // primary rays only
    RenderRequest request = requestOf(scene, options);
    request.maxDepth = 1;
    const uint32_t threads = threadCount(options.threads);
    const Prepared prepared = prepare(scene, request);
    const TraceScene traced = traceSceneOf(scene, prepared);
    const gpu::TracePush push = tracePushOf(prepared, request, traced);
    const std::unique_ptr<ResidentPicture> ours = residentTrace(device, prepared, scene, request);
    RenderRequest ids = request;
    ids.planes = kPlaneColour | kPlanePrimitive;
    const Frame seen = renderGpu(device, scene, ids).frame;
    std::vector<TraceRow> rows;
    for (const bool robust : {false, true}) {
        TraceRow row = rowOf(name + (robust ? " embree-robust" : " embree"),
                             fmt::format("Embree rtcIntersect1{}, {} threads", robust ? ", ROBUST" : "", threads), options);
        row.objects = traced.triangles.size() / 2;
        const peers::EmbreeScene embree(traced, robust);
        std::vector<uint32_t> theirs(size_t(options.width) * options.height);
        measurePairs(
            row, options, [&] { drawOrThrow(*ours); }, [&] { embree.primaryRays(push, options.height, theirs, threads); });
        // Numbers of triangles are those of faces, because the mesh has one face a triangle.
        for (size_t i = 0; i < theirs.size(); ++i) row.differ += (theirs[i] == gpu::kNoObject ? kNone : theirs[i]) != seen.primitive[i];
        judge(row);
        countWork(row, *ours);
        rows.push_back(row);
    }
    return rows;
}

}  // namespace

std::vector<std::string> traceBenchNames() { return {"spheres4", "spheres20", "mesh1e5", "mesh1e6"}; }

std::vector<TraceRow> benchTrace(Device& device, const std::string& name, const TraceBenchOptions& options,
                                 std::vector<std::string>& absent) {
    if (name == "spheres4") return {benchSpheres(device, 4, options)};
    if (name == "spheres20") return {benchSpheres(device, 20, options)};
    if (name == "mesh1e5" || name == "mesh1e6") return benchMesh(device, name, options, absent);
    throw usageError(fmt::format("bench trace: '{}' is no row; accepted: {}", name, fmt::join(traceBenchNames(), ", ")));
}

}  // namespace plumb
