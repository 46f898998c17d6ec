// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/raster.h"

#include "host/binary64.h"
#include "pipeline/render/bounds/vertex_arithmetic.h"
#include "pipeline/render/preparing.h"
#include "pipeline/render/raster/device_render.h"
#include "pipeline/render/raster/stages.h"
#include "pipeline/render/raster/twin_render.h"
#include "pipeline/render/rays/rays.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

namespace {

using Vectors = Trade::Vectors;
bool hasOwnVectors(const Trade& trade) { return trade.vectors == Vectors::face || trade.vectors == Vectors::vertex; }

// A device that has too little memory for one chunk is met later; only a stated limit is known here.
void refuseCoarseInChunks(const Scene& scene, const RenderRequest& request) {
    uint64_t triangles = 0;
    for (const Object& object : scene.objects) triangles += scene.meshes[object.mesh].triangles.size();
    if (request.knobs.chunkTriangles != 0 && triangles > request.knobs.chunkTriangles)
        throw usageError(fmt::format("rate=1/2 draws a picture in one piece, and --limit-chunk {} cuts its {} triangles: leave one out",
                                     request.knobs.chunkTriangles, triangles));
}

void refuseRaster(const Scene& scene, const RenderRequest& request) {
    refuseNoZBuffer(scene);
    refuseShapes(scene);
    const Trade& trade = request.trade;
    if (request.shading != Shading::phong) return;
    if (trade.coarse) refuseCoarseInChunks(scene, request);
    if (!hasOwnVectors(trade)) return;
    const char* which = tradeAxis("light-vector")->chosen(trade).word;
    if (trade.coarse) throw usageError(fmt::format("light-vector={} shades every pixel: leave rate=1/2 out", which));
    if (trade.native())
        throw usageError(
            fmt::format("light-vector={} takes none of the device's own functions: leave specular=native and encode=native out", which));
}

// How pixels are shaded, where they are.
void chooseAtPixels(const Trade& trade, Prepared& p) {
    const bool atPixels = p.choices.shading == gpu::kShadingPhong;
    p.choices.unitNormals = trade.unitNormals || !atPixels;
    p.choices.coarse = trade.coarse && atPixels;
    if (!atPixels || !hasOwnVectors(trade)) return;
    if (!p.list.lights.empty() && (p.choices.parts.diffuse || p.choices.parts.specular))
        p.choices.vectors = trade.vectors == Vectors::face ? gpu::kVectorsFace : gpu::kVectorsVertex;
}

void planSteps(const RenderRequest& request, RunsOn side, Prepared& p) {
    if (p.list.triangles.empty()) return stateDrop(dropRow("nothing"), p.plan, "", "nothing to draw", "");
    StepList steps(request, p, side);
    addSurfaceSteps(steps, p, true);
    const char* shades = p.choices.shading == gpu::kShadingPhong ? "illumination at each sample"
                                                                 : "the colour of the triangle's corners or face, at each sample";
    if (steps.onDevice())
        steps.addFused("shade", "fill", shades);
    else
        steps.add("shade", shades);
    steps.addColours(p.side * p.side, side, steps.onDevice() ? "fill" : "");
}

Prepared prepareRaster(const Scene& scene, const RenderRequest& request, RunsOn side) {
    Preparing it(scene, request, shadingOf(request), kWayRaster);
    it.dropRays(raysAskedBy(scene));
    it.chooseArithmetic();
    it.addObjects(request.repeated && !(request.planes & kPlaneTriangle));
    it.addLights();
    it.drop(DropStage::illumination);
    chooseAtPixels(request.trade, it.p);
    if (!it.p.list.triangles.empty()) it.drop(DropStage::steps);
    planSteps(request, side, it.p);
    return it.finish();
}

// Binary64 that this scene asks for, on a device that lacks it: block-scaled integers are the next best, on every device. A stated
// transform=fp64 is refused by the transform pass instead.
void keepTo(Device& device, const RenderRequest& request, Prepared& p) {
    const auto isLong = [](const DrawList::Range& r) { return r.precision == Precision::fp64; };
    std::vector<DrawList::Range>& ranges = p.list.ranges;
    if (request.trade.precision == Precision::fp64 || std::none_of(ranges.begin(), ranges.end(), isLong)) return;
    const std::string lacks = lacksBinary64(device);
    if (lacks.empty()) return;
    for (DrawList::Range& r : ranges)
        if (isLong(r)) r.precision = Precision::blockInteger;
    for (Plan::Raise& raise : p.plan.raised) {
        if (raise.to != wordOf(Precision::fp64)) continue;
        raise.to = wordOf(Precision::blockInteger);
        p.plan.warnings.push_back(fmt::format("precision: {} needs binary64 and is drawn in block-scaled integers: {}", raise.of, lacks));
    }
}

class RasterPicture : public PreparedPicture {
public:
    using PreparedPicture::PreparedPicture;
    std::unique_ptr<ResidentPicture> stay(Device& device) override {
        keepTo(device, request_, p_);
        return DeviceRender::stays(p_, request_) ? std::make_unique<DeviceRender>(device, p_, request_) : nullptr;
    }
    bool place() override { return placeAgain(scene_, request_, p_); }
    void verifyStages(Device& device, StageCheck& check) override {
        keepTo(device, request_, p_);
        verifyRasterStages(device, p_, request_, check);
    }

private:
    void draw(Device* device, PlaneWriter& writer, RenderResult& result) override {
        if (device != nullptr) {
            keepTo(*device, request_, p_);
            result.plan = p_.plan;
            DeviceRender(*device, p_, request_).draw(writer, result);
        } else if (p_.list.triangles.empty())  // the picture is the background, which the writer has put there
            result.counters.bands = result.counters.chunks = 1;
        else
            drawRasterCpu(p_, request_, writer, result);
    }
};

std::unique_ptr<PreparedPicture> pictureOf(const Scene& scene, const RenderRequest& request, Prepared prepared) {
    return std::make_unique<RasterPicture>(scene, request, std::move(prepared));
}

}  // namespace

const Technique kRaster = {
    .name = "raster",
    .refuse = refuseRaster,
    .prepare = prepareRaster,
    .picture = pictureOf,
    .leavesToRays = raysAskedBy,
    .planes = kPlanesOfLines | kPlanesOfSurfaces | kPlaneTriangle,
    .vertices = Technique::Vertices::transformPass,
};

void addSurfaceSteps(StepList& steps, const Prepared& p, bool illuminated) {
    if (steps.onDevice()) steps.add("clear", "tiles that no triangle touches show the background");
    steps.add("transform", "vertices from object space to the screen");
    if (illuminated) steps.addIllumination();
    steps.add("cull", p.list.cullBackFaces ? "triangles that face away or lie outside the view are left out"
                                           : "triangles that lie outside the view are left out");
    steps.add("setup", steps.onDevice() ? "drawn triangles are listed, small ones in their tiles" : "drawn triangles are listed");
    const char* cuts = "triangles that cross the near plane or leave the guard band are cut";
    if (steps.onDevice()) {
        if (!p.nothingCrosses) steps.add("clip", cuts);
        steps.add("bin", "medium triangles are listed in their tiles");
        steps.add("bin strips", "large triangles are listed in their tiles, strip by strip");
    } else if (!p.nothingCrosses) {
        steps.addFused("clip", "setup", cuts);
    }
    steps.add("fill", "the nearest triangle of each sample");
}

}  // namespace plumb
