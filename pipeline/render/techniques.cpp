// SPDX-License-Identifier: MIT
// The table of the ways to draw. A further one is a folder with its Technique, and a row here.
#include "pipeline/render/notes/notes.h"
#include "pipeline/render/notes/spheres_frame.h"
#include "pipeline/render/preparing.h"
#include "pipeline/render/raster/raster.h"
#include "pipeline/render/rays/rays.h"
#include "pipeline/render/technique.h"
#include "pipeline/render/wire/wire.h"
#include "pipeline/scene/plain_floats.h"

#include <fmt/core.h>
#include <algorithm>
#include <memory>
#include <string>
#include <utility>

namespace plumb {

namespace {

struct Row {
    const Technique& technique;
    bool (*draws)(const Scene&, const RenderRequest&);
};

// The first that draws a request is the one. Spheres stand before wire frames, which have none, because they say better what is missing.
constexpr Row kTable[] = {
    {kRays, [](const Scene&, const RenderRequest& r) { return isTraced(r); }},
    {kSpheres, [](const Scene& s, const RenderRequest& r) { return r.fill == Fill::notes && !s.spheres.empty() && s.planes.empty(); }},
    {kWire, [](const Scene&, const RenderRequest& r) { return r.shading == Shading::wire; }},
    {kPolygons, [](const Scene&, const RenderRequest& r) { return r.fill == Fill::notes; }},
    {kRaster, [](const Scene&, const RenderRequest&) { return true; }},
};

// What no way to draw has.
void refuseSize(const RenderRequest& request) {
    if (request.samples != 1 && request.samples != 4 && request.samples != 16) throw usageError("--samples takes 1, 4 or 16");
    if (request.width == 0 || request.height == 0) throw usageError("--size: a picture needs at least 1x1 pixels");
    const double side = sideOf(request), width = request.width * side, height = request.height * side;
    const double guard = 2.0 * gpu::kGuardPixels;
    if ((width + guard) * (height + guard) >= 0x1p31 || width > 65536 || height > 65536)
        throw usageError(
            fmt::format("--size: {}x{} with {} samples a pixel is beyond the exact grid: (width + 16384) (height + "
                        "16384) must stay below 2^31, each side at most 65536 samples",
                        request.width, request.height, request.samples));
}

}  // namespace

bool isTraced(const RenderRequest& request) { return request.shading == Shading::ray; }

const Technique& techniqueOf(const Scene& scene, const RenderRequest& request) {
    return std::find_if(std::begin(kTable), std::end(kTable), [&](const Row& row) { return row.draws(scene, request); })->technique;
}

void refuse(const Scene& scene, const RenderRequest& request) {
    if (request.planes & kPlanesJudged)
        throw usageError("the planes error and certified compare a finished picture with its truth: `plumb render --aov` writes them");
    refuseSize(request);
    techniqueOf(scene, request).refuse(scene, request);
}

Prepared prepare(const Scene& scene, const RenderRequest& request, RunsOn side) {
    const PlainFloats plain;
    refuse(scene, request);
    return techniqueOf(scene, request).prepare(scene, request, side);
}

std::unique_ptr<PreparedPicture> pictureOf(const Scene& scene, const RenderRequest& request, RunsOn side) {
    return techniqueOf(scene, request).picture(scene, request, prepare(scene, request, side));
}

std::string leftToRays(const Scene& scene, const RenderRequest& request) { return techniqueOf(scene, request).leavesToRays(scene); }

Plan planRender(const Scene& scene, const RenderRequest& request, RunsOn side) { return prepare(scene, request, side).plan; }

}  // namespace plumb
