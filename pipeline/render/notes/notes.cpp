// SPDX-License-Identifier: MIT
#include "pipeline/render/notes/notes.h"

#include "pipeline/render/notes/polygon_frame.h"
#include "pipeline/render/plan_steps.h"
#include "pipeline/render/preparing.h"

#include <memory>
#include <utility>

namespace plumb {

namespace {

void refusePolygons(const Scene& scene, const RenderRequest& request) {
    refuseOtherTrade(request);
    refuseShapes(scene);
}

Prepared preparePolygons(const Scene& scene, const RenderRequest& request, RunsOn side) {
    Preparing it(scene, request, shadingOf(request), kWayPolygons);
    it.dropRays(raysAskedBy(scene));
    it.addObjects();
    it.addLights();
    it.drop(DropStage::illumination);
    const bool atPixels = it.p.choices.shading == gpu::kShadingPhong;
    StepList steps(request, it.p, side);
    steps.addOnHost("project", "corners to whole pixels, by the notes' projection");
    if (!atPixels) steps.addIllumination();
    steps.add("scanline", "the first and last column of each polygon in each row");
    if (steps.onDevice())
        steps.add("scanpaint", "the nearest polygon of each pixel, row by row");
    else
        steps.addFused("scanpaint", "scanline", "the nearest polygon of each pixel, row by row");
    if (atPixels) steps.add("illuminate", "illumination at each pixel");
    steps.addColours(it.p.side * it.p.side, RunsOn::host, "");
    it.p.plan.choices.push_back(
        "fill notes: corners on whole pixels, both ends of a line painted, attributes interpolated along edges and lines");
    return it.finish();
}

class PolygonPicture : public PreparedPicture {
public:
    using PreparedPicture::PreparedPicture;

    void verifyStages(Device& device, StageCheck& check) override {
        RenderResult unused;
        unused.plan = p_.plan;
        PlaneWriter writer(p_, request_, unused.frame);
        const std::unique_ptr<NotesSide> side = checkedSideOf(device, p_, request_, unused, check);
        drawPolygons(scene_, p_, request_, *side, writer, unused);
    }

private:
    void draw(Device* device, PlaneWriter& writer, RenderResult& result) override {
        const std::unique_ptr<NotesSide> side = notesSideOf(device, p_, request_, result);
        drawPolygons(scene_, p_, request_, *side, writer, result);
        side->finish();
    }
};

std::unique_ptr<PreparedPicture> pictureOf(const Scene& scene, const RenderRequest& request, Prepared prepared) {
    return std::make_unique<PolygonPicture>(scene, request, std::move(prepared));
}

}  // namespace

const Technique kPolygons = {
    .name = "notes",
    .refuse = refusePolygons,
    .prepare = preparePolygons,
    .picture = pictureOf,
    .leavesToRays = raysAskedBy,
    .planes = kPlanesOfLines | kPlanesOfSurfaces | kPlaneTriangle,
    .vertices = Technique::Vertices::host,
};

void refuseOtherTrade(const RenderRequest& request) {
    Trade other = request.trade;
    other.specular = Trade().specular;
    if (other != Trade{}) throw usageError("--trade: --fill notes has the axis specular; the others are of --fill exact");
}

}  // namespace plumb
