// SPDX-License-Identifier: MIT
#include "pipeline/render/rays/rays.h"

#include "pipeline/render/plan_steps.h"
#include "pipeline/render/preparing.h"
#include "pipeline/render/rays/trace_frame.h"
#include "pipeline/scene/ray_shares.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

namespace {

using Sampling = RayChoices::Sampling;
bool sharesCorners(const RenderRequest& request) {
    return request.rays.sampling == Sampling::corners || request.rays.sampling == Sampling::adaptive;
}

void refuseRays(const Scene& scene, const RenderRequest& request) {
    if (request.distantViewer) {
        constexpr const char* kWhy = "is a simplification of the raster shadings; a ray comes from the eye that it is traced from";
        if (scene.distantViewer == request.distantViewer && !scene.viewerLocation.empty())
            throw inputError(scene.viewerLocation, fmt::format("viewer = \"distant\" {}; --viewer local overrides", kWhy));
        throw usageError(fmt::format("--viewer distant {}", kWhy));
    }
    if (request.fill == Fill::notes) {
        constexpr const char* kWhy = "is a fill of the raster shadings; --shading ray has none";
        if (scene.fill == request.fill && !scene.fillLocation.empty())
            throw inputError(scene.fillLocation, fmt::format("fill = \"notes\" {}; --fill exact overrides", kWhy));
        throw usageError(fmt::format("--fill notes {}", kWhy));
    }
    if (request.trade != Trade{}) throw usageError("--trade is about the raster shadings; --shading ray has none of these choices");
    refuseNoZBuffer(scene);
    const RayChoices& rays = request.rays;
    const bool adaptive = rays.sampling == Sampling::adaptive, corners = rays.sampling == Sampling::corners;
    if (sharesCorners(request) && request.samples != 1)
        throw usageError(fmt::format("--sampling {} has its own number of samples; leave --samples out", nameOf(rays.sampling)));
    if (adaptive && std::max(request.width, request.height) > 16384)
        throw usageError("--sampling adaptive: a picture of at most 16384 pixels a side, four samples each");
    if (corners && std::max(request.width, request.height) > 65535)
        throw usageError("--sampling corners: a picture of at most 65535 pixels a side, and one corner more");
    for (const float amount : {rays.jitterReflect, rays.jitterRefract, rays.jitterShadow})
        if (!(amount >= 0 && amount <= 0.5f)) throw usageError("--jitter: an amount is outside 0 to 0.5");
    if (rays.cutLevels && request.encoding != Encoding::linear)
        throw usageError("--levels cut counts bytes as light: it goes with --encode linear");
}

// "word: what it does"; the default, which needs no explanation, is its word alone.
template <class Rows, class Value>
std::string meaningOf(const Rows& rows, const Value& value) {
    const auto& row = choiceOfValue(rows, value);
    return &row == &rows[0] ? row.word : fmt::format("{}: {}", row.word, row.help);
}

void planChoices(const RenderRequest& request, Plan& plan) {
    const RayChoices& rays = request.rays;
    const auto by = [](const std::string& who) { return who.empty() ? "" : fmt::format(" (stated by {})", who); };
    const Stated& stated = request.stated;
    if (rays.sampling != RayChoices::Sampling::grid || !stated.sampling.empty())
        plan.choices.push_back(fmt::format("sampling {}{}", meaningOf(kSamplings, rays.sampling), by(stated.sampling)));
    for (const auto& [name, amount] : {std::pair("reflected rays", rays.jitterReflect), std::pair("refracted rays", rays.jitterRefract),
                                       std::pair("shadow rays", rays.jitterShadow)})
        if (amount > 0) plan.choices.push_back(fmt::format("noise of {:g} on {}, seed {}{}", amount, name, rays.seed, by(stated.jitter)));
    if (!stated.seed.empty()) plan.choices.push_back(fmt::format("seed {}{}", rays.seed, by(stated.seed)));
    if (rays.cutLevels || !stated.levels.empty())
        plan.choices.push_back(fmt::format("levels {}{}", meaningOf(kLevelForms, rays.cutLevels), by(stated.levels)));
}

Prepared prepareRays(const Scene& scene, const RenderRequest& request, RunsOn side) {
    Preparing it(scene, request, gpu::kShadingPhong, kWayRays);
    it.addLights();
    it.drop(DropStage::illumination);
    it.drop(DropStage::steps);
    stateSphereForms(scene, it.p);
    StepList steps(request, it.p, side);
    steps.add("trace", "rays through each sample, and what they are followed by");
    steps.addColours(sharesCorners(request) ? 4 : it.p.side * it.p.side, side, steps.onDevice() ? "trace" : "");
    planChoices(request, it.p.plan);
    return it.finish();
}

class RayPicture : public PreparedPicture {
public:
    using PreparedPicture::PreparedPicture;
    std::unique_ptr<ResidentPicture> stay(Device& device) override { return residentTrace(device, p_, scene_, request_); }

private:
    void draw(Device* device, PlaneWriter& writer, RenderResult& result) override {
        if (device != nullptr)
            traceFrameGpu(*device, p_, scene_, request_, writer, result);
        else
            traceFrameCpu(p_, scene_, request_, writer, result);
    }
};

std::unique_ptr<PreparedPicture> pictureOf(const Scene& scene, const RenderRequest& request, Prepared prepared) {
    return std::make_unique<RayPicture>(scene, request, std::move(prepared));
}

}  // namespace

const Technique kRays = {
    .name = "rays",
    .refuse = refuseRays,
    .prepare = prepareRays,
    .picture = pictureOf,
    .leavesToRays = [](const Scene&) { return std::string(); },
    .planes = kPlanesOfLines | kPlanesOfSurfaces,  // rays meet more than triangles
    .vertices = Technique::Vertices::none,
    .wholePass = "trace",
};

bool onlyRaysDraw(const Scene& scene) { return !scene.spheres.empty() || !scene.planes.empty(); }

std::string raysAskedByMaterials(const Scene& scene) {
    std::vector<bool> asks(scene.materials.size());
    for (size_t i = 0; i < asks.size(); ++i) asks[i] = asksForRays(scene.materials[i]);
    if (std::find(asks.begin(), asks.end(), true) == asks.end()) return {};
    const auto sentence = [](const Material& m) {
        const RayShares s = raySharesOf(m);
        return s.transmit > 0 ? fmt::format("material '{}' transmits {:g}", printable(m.name, 64), s.transmit)
                              : fmt::format("material '{}' reflects {:g}", printable(m.name, 64), s.reflect);
    };
    for (const Object& object : scene.objects)
        for (const uint32_t material : scene.meshes[object.mesh].faceMaterial)
            if (asks[material]) return sentence(scene.materials[material]);
    for (const SphereShape& sphere : scene.spheres)
        if (asks[sphere.material]) return sentence(scene.materials[sphere.material]);
    return {};
}

std::string raysAskedBy(const Scene& scene) {
    return onlyRaysDraw(scene) ? "the scene has spheres or planes, which only rays meet" : raysAskedByMaterials(scene);
}

}  // namespace plumb
