// SPDX-License-Identifier: MIT
#include "pipeline/render/prepare.h"

#include "pipeline/passes/encode.h"
#include "pipeline/passes/resolve.h"
#include "pipeline/render/bounds/vertex_arithmetic.h"
#include "pipeline/render/drops.h"
#include "pipeline/render/preparing.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

namespace {

// Error of a sum of lights above which a warning is given, in steps of an encoded channel.
constexpr double kSumSteps = 0.25;
// Bound of that error: k terms of one sign, added one after another, are off by k u of their sum. A step of sRGB is steepest for that at 1,
// where its slope is 1.055 / 2.4.
double stepsOfSum(size_t lights, Encoding encoding) {
    return double(lights) * 0x1p-24 * 255 * (encoding == Encoding::srgb ? 1.055 / 2.4 : 1);
}

static_assert(Trade::kStandardDepth == gpu::kDepthStandard);

// By the resolve pass itself: a mean of equal samples rounds, and a transparent pixel without a covered sample is black.
void findUndrawn(bool transparent, Prepared& p) {
    p.undrawn = p.background;
    p.undrawnLinear = p.backgroundLinear;
    if (p.side == 1) return;
    const size_t samples = size_t(p.side) * p.side;
    std::vector<float> linear;
    for (size_t i = 0; i < samples; ++i) linear.insert(linear.end(), &p.backgroundLinear.x, &p.backgroundLinear.x + 3);
    const std::vector<int> z(samples, 0);
    resolveCpu(1, 1, p.side, transparent, p.choices.encoding, linear, z, std::span(&p.undrawnLinear.x, 3), std::span(&p.undrawn, 1), 1);
}

Pinhole viewOf(const Scene& scene, const RenderRequest& request) {
    PLUMB_ASSERT(scene.camera.has_value());
    const double side = sideOf(request);
    return pinholeOf(*scene.camera, request.width * side, request.height * side, side);
}

void setCanvas(const Pinhole& view, const RenderRequest& request, Prepared& p) {
    p.width = request.width;
    p.height = request.height;
    p.side = sideOf(request);
    p.unit = view.unit;
    p.near = float(view.near);
    DrawList& list = p.list;
    const double width = view.width, height = view.height;
    list.viewport = {float(width / 2), float(height / 2), float(width / 2) + gpu::kGuardPixels, float(height / 2) + gpu::kGuardPixels,
                     float(view.near * view.unit)};
    list.viewport.droppedBits = request.trade.subpixelBits == 4 ? 4 : 0;
    list.frame = {int(width), int(height), 0, int(height)};
    list.rayOrigin = glm::vec3(view.forward - view.right * (width / 2 / view.focal) - view.down * (height / 2 / view.focal));
    list.rayX = glm::vec3(view.right / view.focal);
    list.rayY = glm::vec3(view.down / view.focal);
    p.rayOrigin = list.rayOrigin;
    p.rayX = list.rayX;
    p.rayY = list.rayY;
    if (request.trade.vectors == Trade::Vectors::scene) {
        list.rayOrigin = glm::vec3(view.forward);
        list.rayX = list.rayY = glm::vec3(0);
    }
    if (request.distantViewer) list.towardViewer = glm::vec3(-view.forward);
}

void setChoices(const RenderRequest& request, FillChoices& c) {
    c.encoding = request.encoding == Encoding::linear ? gpu::kEncodeLinear
                 : request.trade.nativeEncode         ? gpu::kEncodeNative
                                                      : gpu::kEncodeSrgb;
    using Specular = Trade::Specular;
    const Specular specularBy = request.trade.specular;
    c.parts.power = specularBy == Specular::schlick  ? gpu::kPowerSchlick
                    : specularBy == Specular::native ? gpu::kPowerNative
                                                     : gpu::kPowerExact;
    c.affine = request.trade.affine;
    c.depthBits = request.trade.depthBits;
}

}  // namespace

uint32_t sideOf(const RenderRequest& request) { return request.samples == 16 ? 4 : request.samples == 4 ? 2 : 1; }

uint32_t shadingOf(const RenderRequest& request) {
    switch (request.shading) {
        case Shading::unlit:
            return gpu::kShadingUnlit;
        case Shading::flat:
            return gpu::kShadingFlat;
        case Shading::gouraud:
            return gpu::kShadingGouraud;
        default:
            return gpu::kShadingPhong;
    }
}

void refuseNoZBuffer(const Scene& scene) {
    if (!scene.zBuffer)
        throw inputError(scene.zBufferLocation.empty() ? printablePath(scene.path) : scene.zBufferLocation,
                         "z_buffer = false is for the polygons of --fill notes; every other picture needs one");
}

std::string firstShapeLocation(const Scene& scene) {
    const std::string location = !scene.spheres.empty() ? scene.spheres[0].location : !scene.planes.empty() ? scene.planes[0].location : "";
    return location.empty() ? printablePath(scene.path) : location;
}

void refuseShapes(const Scene& scene) {
    if (onlyRaysDraw(scene))
        throw inputError(firstShapeLocation(scene), "it has spheres or planes, which only --shading ray draws, spheres --fill notes too");
}

bool placeAgain(const Scene& scene, const RenderRequest& request, Prepared& p) {
    const auto& dropped = p.plan.dropped;
    // What one view of the scene lets a picture leave out, another may need.
    const auto ofView = [](const Plan::Drop& d) { return d.row == "turned-away"; };
    if (std::any_of(dropped.begin(), dropped.end(), ofView)) return false;
    const Pinhole view = viewOf(scene, request);
    setCanvas(view, request, p);
    Plan stated = std::exchange(p.plan, {});  // by the first picture; what rows state here is not kept
    Dropping dropping{scene, request, view, p, kWayRaster};
    const bool hadNoCrossing = std::exchange(p.nothingCrosses, false);
    walkDrops(DropStage::objects, dropping);
    ListBuilder list(scene, request, view, p);
    list.setPrecisions(precisionsOf(vertexArithmetic(scene, request)));
    bool same = list.placeObjects();
    if (same && !p.list.lights.empty()) {
        const std::vector<gpu::LightRecord> before = std::exchange(p.list.lights, {});
        list.addLights();
        walkDrops(DropStage::lights, dropping);
        same = std::equal(before.begin(), before.end(), p.list.lights.begin(), p.list.lights.end(),
                          [](const gpu::LightRecord& a, const gpu::LightRecord& b) { return a.kind == b.kind; });
    }
    if (hadNoCrossing) p.nothingCrosses = nothingCrosses(dropping);
    same &= p.nothingCrosses == hadNoCrossing;
    p.plan = std::move(stated);
    return same;
}

Preparing::Preparing(const Scene& stated, const RenderRequest& asked, uint32_t shading, uint32_t drawn)
    : scene(stated), request(asked), way(drawn), view(viewOf(scene, request)), list(scene, request, view, p) {
    setCanvas(view, request, p);
    p.list.cullBackFaces = scene.cullBackFaces ? 1 : 0;
    p.counters.objects = scene.objects.size();
    setChoices(request, p.choices);
    p.choices.shading = shading;
    p.choices.keepNormals = way == kWayRaster && shading != gpu::kShadingPhong;
    p.backgroundLinear = request.background;
    p.background = encodePixelCpu(p.choices.encoding, &request.background.x, request.transparent ? 0 : 255);
    findUndrawn(request.transparent, p);
    if (!request.stated.shading.empty()) p.plan.choices.push_back(request.stated.shading);
}

void Preparing::chooseArithmetic() {
    const std::vector<VertexArithmetic> chosen = vertexArithmetic(scene, request);
    list.setPrecisions(precisionsOf(chosen));
    for (uint32_t i = 0; i < chosen.size(); ++i)
        if (chosen[i].raised) p.plan.raised.push_back(raiseOf(scene, i, chosen[i]));
}

void Preparing::dropRays(const std::string& asked) {
    if (!asked.empty()) p.plan.dropped.push_back({"reflection and refraction", asked + "; only --shading ray traces them"});
}

void Preparing::drop(DropStage stage) {
    Dropping dropping{scene, request, view, p, way};
    walkDrops(stage, dropping);
}

void Preparing::addObjects(bool keepOutside) {
    drop(DropStage::objects);
    list.addObjects(keepOutside);
}

void Preparing::addLights() {
    if (p.list.materials.empty()) p.list.materials.push_back({});
    list.addLights();
    if (p.choices.shading != gpu::kShadingUnlit) return drop(DropStage::lights);
    p.choices.parts = {false, false, false};
    p.list.lights.clear();
}

Prepared Preparing::finish() {
    Plan& plan = p.plan;
    const Trade& trade = request.trade;
    const double width = view.width, height = view.height;
    using Vectors = Trade::Vectors;
    if (p.side > 1)
        plan.choices.push_back(fmt::format("{} samples a pixel: the frame is drawn at {}x{} and resolved in linear light", request.samples,
                                           uint32_t(width), uint32_t(height)));
    if (request.distantViewer) plan.choices.push_back("viewer: distant, one vector toward it for every point");
    if (trade.specular == Trade::Specular::schlick) plan.choices.push_back("specular: Schlick's quotient in place of the power");
    if (trade.vectors == Trade::Vectors::scene)
        plan.choices.push_back("light-vector: one direction to the eye and to each light for the whole scene");
    if (p.choices.vectors == gpu::kVectorsFace) plan.choices.push_back("light-vector: directions made once a face, at its centre");
    if (p.choices.vectors == gpu::kVectorsVertex)
        plan.choices.push_back("light-vector: directions made at the corners and interpolated, not made unit again");
    if ((trade.vectors == Vectors::face || trade.vectors == Vectors::vertex) && p.choices.vectors == gpu::kVectorsPixel)
        plan.choices.push_back("light-vector: no pixel is lit by a direction of its own; nothing changes");
    if (trade.affine) plan.choices.push_back("interpolation: affine");
    if (trade.precision == Precision::blockInteger) plan.choices.push_back("transform: block-scaled integers, rounded to float32 once");
    if (trade.precision == Precision::fp64) plan.choices.push_back("transform: binary64, rounded to float32 at its end");
    if (trade.specular == Trade::Specular::native) plan.choices.push_back("specular: the device's own power (bounded)");
    if (trade.nativeEncode && request.encoding == Encoding::srgb) plan.choices.push_back("encode: the device's own power (bounded)");
    if (!trade.unitNormals)
        plan.choices.push_back(p.choices.unitNormals ? "normals: as interpolated; no pixel is shaded by one"
                                                     : "normals: as interpolated, not made unit at pixels");
    if (trade.coarse) plan.choices.push_back(p.choices.coarse ? "rate: one pixel in 2x2 is shaded" : "rate: 1/2; no pixel is shaded");
    if (trade.depthBits == gpu::kDepthStandard)
        plan.choices.push_back("depth: 1 - n/w in float32");
    else if (trade.depthBits != 32)
        plan.choices.push_back(fmt::format("depth: fixed point of {} bits", trade.depthBits));
    if (trade.subpixelBits != 8) plan.choices.push_back(fmt::format("subpixel: {} bits", trade.subpixelBits));
    plan.choices.push_back(fmt::format("near plane at {}", view.near));
    if (const double steps = stepsOfSum(p.list.lights.size(), request.encoding); steps > kSumSteps)
        plan.warnings.push_back(
            fmt::format("light: the sum of {} lights in float32 may be off by up to {:.2g} steps of 1/255", p.list.lights.size(), steps));
    return std::move(p);
}

}  // namespace plumb
