// SPDX-License-Identifier: MIT
#include "pipeline/render/notes/spheres_frame.h"

#include "pipeline/passes/parallel.h"
#include "pipeline/render/notes/notes.h"
#include "pipeline/render/plan_steps.h"
#include "pipeline/render/planes.h"
#include "pipeline/render/preparing.h"
#include "pipeline/render/rays/rays.h"
#include "pipeline/render/stage_check.h"
#include "pipeline/render/walk.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <utility>
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
    const auto locationOf = [&](size_t i) {
        const SphereShape& s = scene.spheres[i];
        return locationOfPart(s.location, scene.path, "sphere", s.name.empty() ? std::to_string(i) : s.name);
    };
    for (uint32_t i = 0; i < scene.spheres.size(); ++i) {
        const SphereShape& s = scene.spheres[i];
        const auto refuse = [&](const std::string& what) { throw inputError(locationOf(i), what); };
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
    out.list.close([&](size_t disc) { return locationOf(out.from[disc]); });
    return out;
}

SphereLight lightOf(const Scene& scene, const Prepared& p) {
    return {p.choices.parts, p.list.materials, p.list.lights, scene.wholeSphereHeights, float(p.unit)};
}

// What a disc shows at a pixel. Rays are parallel: the distance is the depth.
class DiscSeen : public SeenNothing {
public:
    DiscSeen(const Scene& scene, const Prepared& p, const Listed& listed, const SphereCanvas& canvas, size_t pixel)
        : scene_(scene),
          p_(p),
          sphere_(listed.from[canvas.owner[pixel]]),
          disc_(listed.list.discs[canvas.owner[pixel]]),
          pixel_(pixel),
          depth_(float(double(canvas.depth[pixel]) / p.unit)) {}
    float z() const { return p_.near / depth_; }
    float depth() const { return depth_; }
    float distance() const { return depth_; }
    glm::vec3 normal() const {
        const int x = int(pixel_ % p_.width) - disc_.column, y = disc_.row - int(pixel_ / p_.width);
        const gpu::Surface s = gpu::sphereSurface(disc_, x, y, gpu::sphereHeight(disc_, x, y, scene_.wholeSphereHeights), 1);
        return {s.nx, s.ny, s.nz};
    }
    uint32_t object() const { return uint32_t(scene_.objects.size()) + sphere_; }
    uint32_t primitive() const { return 0; }

private:
    const Scene& scene_;
    const Prepared& p_;
    const uint32_t sphere_;
    const gpu::SphereDisc& disc_;
    const size_t pixel_;
    const float depth_;
};

void write(const Scene& scene, const Prepared& p, const RenderRequest& request, const Listed& listed, const SphereCanvas& canvas,
           PlaneWriter& writer, RenderResult& result) {
    std::vector<int> drawn(canvas.owner.size());
    std::vector<float> linear(3 * canvas.owner.size());
    for (size_t i = 0; i < drawn.size(); ++i) {
        drawn[i] = canvas.owner[i] != gpu::kNoSphere;
        const glm::vec3 colour = drawn[i] ? glm::vec3(canvas.colour[i]) : p.backgroundLinear;
        std::copy_n(&colour.x, 3, linear.begin() + ptrdiff_t(3 * i));
    }
    const SampleLayout layout{p.width, 1, 1, 0};
    writer.takeColours(0, p.height, {layout, linear, drawn}, threadCount(request.threads));
    writer.takeCoverage<int>(p.height, layout, drawn);
    writer.takeSeen<int>(0, p.height, layout, drawn,
                         [&](uint32_t, uint32_t, size_t pixel) { return DiscSeen(scene, p, listed, canvas, pixel); });
    result.counters.objectsDrawn = listed.list.discs.size();
    result.counters.illuminations = result.frame.coveredPixels;
    result.counters.bands = result.counters.chunks = 1;
}

// What the implicit sphere rendering of the notes can draw.
void refuseSpheres(const Scene& scene, const RenderRequest& request) {
    refuseOtherTrade(request);
    refuseNoZBuffer(scene);
    if (request.shading != Shading::phong) throw usageError("--fill notes illuminates spheres at each pixel: --shading phong");
    if (request.samples != 1) throw usageError("--fill notes draws one sample a pixel: leave --samples out");
    if (!scene.objects.empty())
        throw inputError(
            firstShapeLocation(scene),
            "it has meshes beside spheres; --fill notes draws spheres in parallel projection and meshes in perspective, so not both");
    if (scene.lights.size() > size_t(gpu::kSphereLights))
        throw inputError(scene.lights[size_t(gpu::kSphereLights)].location.empty() ? printablePath(scene.path)
                                                                                   : scene.lights[size_t(gpu::kSphereLights)].location,
                         fmt::format("{} lights; --fill notes draws spheres under at most {}", scene.lights.size(), gpu::kSphereLights));
    if (!(scene.camera->focalPixels > 0))
        throw inputError(firstShapeLocation(scene), "--fill notes draws spheres for the viewer of camera.distance, a pixel a unit");
}

Prepared prepareSpheres(const Scene& scene, const RenderRequest& request, RunsOn side) {
    Preparing it(scene, request, gpu::kShadingPhong, kWaySpheres);
    it.list.addSphereMaterials();
    it.dropRays(raysAskedByMaterials(scene));
    it.addLights();
    it.drop(DropStage::illumination);
    StepList steps(request, it.p, side);
    steps.add("spheres", "the nearest sphere of each pixel and its illumination, in parallel projection");
    steps.addColours(1, RunsOn::host, "");
    it.p.plan.choices.push_back(fmt::format("fill notes: spheres pixel by pixel in parallel projection, z {}",
                                            scene.wholeSphereHeights ? "rounded to whole numbers" : "not rounded"));
    return it.finish();
}

class SpheresPicture : public PreparedPicture {
public:
    using PreparedPicture::PreparedPicture;

    void verifyStages(Device& device, StageCheck& check) override {
        const Listed listed = listOf(scene_, p_, request_);
        Recorder recorder(device);
        recorder.allow(p_.plan.labels(RunsOn::device));
        const SphereCanvas want = spheresCpu(listed.list, lightOf(scene_, p_), threadCount(request_.threads));
        const SphereCanvas got = spheresGpu(device, recorder, listed.list, lightOf(scene_, p_), {}, request_.watchdogMs);
        check.compare<float>("spheres", "depth of pixel", want.depth, got.depth);
        check.compare<uint32_t>("spheres", "sphere of pixel", want.owner, got.owner);
        std::vector<glm::vec4> colour = got.colour;  // nothing is shaded, and nothing is compared, where no sphere is
        for (size_t i = 0; i < colour.size(); ++i)
            if (want.owner[i] != gpu::kNoSphere && !check.coloursAsNear(want.colour[i], got.colour[i])) colour[i] = want.colour[i];
        check.compare<glm::vec4>("spheres", "colour of pixel", colour, got.colour);
    }

private:
    void draw(Device* device, PlaneWriter& writer, RenderResult& result) override {
        const Listed listed = listOf(scene_, p_, request_);
        SphereCanvas canvas;
        if (device != nullptr) {
            Recorder recorder(*device);
            recorder.allow(p_.plan.labels(RunsOn::device));
            canvas = spheresGpu(*device, recorder, listed.list, lightOf(scene_, p_), {}, request_.watchdogMs);
            result.times = recorder.takeTimes();
        }
        const StepBody twin[] = {
            {"spheres", [&] { canvas = spheresCpu(listed.list, lightOf(scene_, p_), threadCount(request_.threads)); }}};
        if (device == nullptr) walk(p_.plan, result.times, twin);
        const StepBody host[] = {{"encode", [&] { write(scene_, p_, request_, listed, canvas, writer, result); }}};
        walk(p_.plan, result.times, host);
    }
};

std::unique_ptr<PreparedPicture> pictureOf(const Scene& scene, const RenderRequest& request, Prepared prepared) {
    return std::make_unique<SpheresPicture>(scene, request, std::move(prepared));
}

}  // namespace

const Technique kSpheres = {
    .name = "spheres",
    .refuse = refuseSpheres,
    .prepare = prepareSpheres,
    .picture = pictureOf,
    .leavesToRays = raysAskedByMaterials,
    .planes = kPlanesOfLines | kPlanesOfSurfaces | kPlaneTriangle,
    .vertices = Technique::Vertices::none,
    .parallel = true,
};

}  // namespace plumb
