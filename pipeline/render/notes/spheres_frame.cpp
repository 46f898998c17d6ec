// SPDX-License-Identifier: MIT
#include "pipeline/render/notes/spheres_frame.h"

#include "pipeline/passes/encode.h"
#include "pipeline/passes/parallel.h"
#include "pipeline/render/stopwatch.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb {

namespace {

struct Listed {
    SphereList list;
    std::vector<uint32_t> from;  // sphere of the scene of each disc
};

Listed listOf(const Scene& scene, const Prepared& p, const RenderRequest& request) {
    if (request.onProgress && !request.onProgress(0)) throw Error(Exit::interrupted, "interrupted");
    Listed out{SphereList(int(p.width), int(p.height)), {}};
    const glm::dvec3 eye = scene.camera->eye;
    constexpr double kFar = 0x1p24;  // pixels: whole numbers, and far off any canvas
    for (uint32_t i = 0; i < scene.spheres.size(); ++i) {
        const SphereShape& s = scene.spheres[i];
        const auto refuse = [&](const std::string& what) {
            throw inputError(placeOfPart(s.place, scene.path, "sphere", s.name.empty() ? std::to_string(i) : s.name), what);
        };
        if (s.radius < 1 || s.radius > gpu::kSphereReach)
            refuse(fmt::format("its radius is {:g}; --fill notes draws spheres of 1 to {} pixels", s.radius, gpu::kSphereReach));
        const glm::dvec3 centre = s.centre - eye;
        if (!(centre.z - s.radius >= double(p.near)))
            refuse("it reaches behind the near plane, and --fill notes cuts no spheres: move it or the viewer");
        if (!(glm::length(centre) * p.unit <= 0x1p60)) refuse("it is further from the eye than 2^60 times the near plane");
        const double column = std::nearbyint(double(p.width) / 2 + centre.x), row = std::nearbyint(double(p.height) / 2 - centre.y);
        gpu::SphereDisc d{};
        d.column = int(std::clamp(column, -kFar, kFar));
        d.row = int(std::clamp(row, -kFar, kFar));
        d.reach = int(s.radius);
        d.radiusSquared = int(s.radius * s.radius);
        d.centre = glm::vec3(centre * p.unit);
        d.depth = d.centre.z;
        d.material = p.list.sphereMaterial[i];
        if (out.list.add(d)) out.from.push_back(i);
    }
    out.list.close();
    return out;
}

SphereLight lightOf(const Scene& scene, const Prepared& p) {
    return {p.choices.parts, p.list.materials, p.list.lights, scene.wholeSphereHeights, float(p.unit)};
}

void write(const Scene& scene, const Prepared& p, const RenderRequest& request, const Listed& listed, const SphereCanvas& canvas,
           RenderResult& result) {
    const Stopwatch watch(&result.times, "encode");
    Frame& out = result.frame;
    const PlaneWriter restarted(p, request.planes, out);  // every plane as if nothing were drawn
    const uint32_t width = p.width;
    for (size_t i = 0; i < canvas.owner.size(); ++i) {
        const bool covered = canvas.owner[i] != gpu::kNoSphere;
        const glm::vec3 linear = covered ? glm::vec3(canvas.colour[i]) : p.backgroundLinear;
        if (request.planes & kPlaneLinear) std::copy_n(&linear.x, 3, out.linear.begin() + ptrdiff_t(3 * i));
        if (!covered) continue;
        ++out.coveredPixels;
        const gpu::SphereDisc& d = listed.list.discs[canvas.owner[i]];
        const float depth = float(double(canvas.depth[i]) / p.unit);
        out.rgba[i] = encodePixelCpu(p.choices.encoding, &linear.x, 255);
        if (request.planes & kPlaneZ) out.z[i] = p.near / depth;
        if (request.planes & kPlaneDepth) out.depth[i] = depth;
        if (request.planes & kPlaneDistance) out.distance[i] = depth;  // rays are parallel
        if (request.planes & kPlaneNormal) {
            const int x = int(i % width) - d.column, y = d.row - int(i / width);
            const gpu::Surface s = gpu::sphereSurface(d, x, y, gpu::sphereHeight(d, x, y, scene.wholeSphereHeights), 1);
            std::copy_n(&glm::vec3(s.nx, s.ny, s.nz)[0], 3, out.normal.begin() + ptrdiff_t(3 * i));
        }
        if (request.planes & kPlaneObject) out.object[i] = uint32_t(scene.objects.size()) + listed.from[canvas.owner[i]];
        if (request.planes & kPlanePrimitive) out.primitive[i] = 0;
    }
    result.counters.objectsDrawn = listed.list.discs.size();
    result.counters.illuminations = out.coveredPixels;
    result.counters.bands = result.counters.chunks = 1;
}

}  // namespace

void drawSpheresCpu(const Scene& scene, const Prepared& prepared, const RenderRequest& request, RenderResult& result) {
    const Listed listed = listOf(scene, prepared, request);
    SphereCanvas canvas;
    {
        const Stopwatch watch(&result.times, "spheres");
        canvas = spheresCpu(listed.list, lightOf(scene, prepared), threadCount(request.threads));
    }
    write(scene, prepared, request, listed, canvas, result);
}

void drawSpheresGpu(Device& device, const Scene& scene, const Prepared& prepared, const RenderRequest& request, RenderResult& result) {
    const Listed listed = listOf(scene, prepared, request);
    Recorder recorder(device);
    recorder.allow(prepared.plan.labels(RunsOn::device));
    const SphereCanvas canvas = spheresGpu(device, recorder, listed.list, lightOf(scene, prepared), {}, request.watchdogMs);
    result.times = recorder.takeTimes();
    write(scene, prepared, request, listed, canvas, result);
}

}  // namespace plumb
