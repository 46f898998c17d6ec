// SPDX-License-Identifier: MIT
#include "pipeline/planner/work.h"
#include "pipeline/render/technique.h"

#include <algorithm>
#include <cstdint>

namespace plumb {
namespace {

double sideOf(const RenderRequest& request) { return request.samples == 16 ? 4 : request.samples == 4 ? 2 : 1; }

double facesOf(const Scene& scene) {
    double faces = 0;
    for (const Object& object : scene.objects) faces += double(scene.meshes[object.mesh].faceNormal.size());
    return faces;
}

// Work of lighting `points` samples one by one.
void addShading(const RenderRequest& request, double points, double lights, Work& work) {
    const Trade& trade = request.trade;
    if (trade.coarse) points /= 4;
    work[Unit::shade] = points;
    work[Unit::light] = points * lights;
    work[trade.specular == Trade::Specular::schlick ? Unit::quickPower : Unit::power] = points * lights;
    constexpr Unit kVectors[] = {Unit::vectorPixel, Unit::vectorVertex, Unit::vectorFace, Unit::vectorScene};
    work[kVectors[size_t(trade.vectors)]] = points * (lights + 1);
    work[trade.unitNormals ? Unit::unitNormal : Unit::shortNormal] = points;
    work[trade.affine ? Unit::affine : Unit::perspective] = points;
}

}  // namespace

double raysOf(const RenderCounters& counters) {
    double rays = 0;
    for (const RenderCounters::RayCounts& r : counters.rays) rays += double(r.primary + r.reflected + r.refracted + r.shadowRays);
    return rays;
}

Counted countedOf(const RenderResult& result, const RenderRequest& request) {
    return {double(result.frame.coveredPixels) * sideOf(request) * sideOf(request), result.counters};
}

Work workOf(const Scene& scene, const RenderRequest& request, const Counted& counted, double shrink) {
    const double scale = shrink * shrink, lights = double(scene.lights.size());
    Work work;
    work[Unit::picture] = 1;
    work[Unit::sample] = double(request.width) * request.height * sideOf(request) * sideOf(request);
    if (isTraced(request)) {
        work[Unit::ray] = raysOf(counted.counters) * scale;
        return work;
    }
    work[Unit::covered] = std::min(counted.covered * scale, work[Unit::sample]);
    constexpr Unit kVertices[] = {Unit::vertex, Unit::vertexInteger, Unit::vertex64};
    work[kVertices[size_t(request.trade.precision)]] = double(counted.counters.vertices);
    work[Unit::triangle] = double(counted.counters.triangles);
    if (request.shading == Shading::flat) work[Unit::corner] = facesOf(scene) * lights;
    if (request.shading == Shading::gouraud) work[Unit::corner] = double(counted.counters.vertices) * lights;
    if (request.shading == Shading::gouraud) work[request.trade.affine ? Unit::affine : Unit::perspective] = work[Unit::covered];
    if (request.shading == Shading::phong) addShading(request, work[Unit::covered], lights, work);
    return work;
}

double costOf(const Work& work, const UnitCosts& costs) {
    double ns = 0;
    for (size_t i = 0; i < kUnits; ++i) ns += work.of[i] * costs.of[i];
    return ns * 1e-6;
}

UnitCosts nominalCosts() {
    UnitCosts c;
    c[Unit::picture] = 2e5;
    c[Unit::sample] = 4;
    c[Unit::covered] = 6;
    c[Unit::vertex] = c[Unit::vertex64] = 12;
    c[Unit::vertexInteger] = 30;
    c[Unit::triangle] = 60;
    c[Unit::corner] = 40;
    c[Unit::shade] = 6;
    c[Unit::light] = 8;
    c[Unit::power] = 10;
    c[Unit::quickPower] = 5;
    c[Unit::vectorPixel] = 9;
    c[Unit::vectorVertex] = 5;
    c[Unit::vectorFace] = 3;
    c[Unit::vectorScene] = 1;
    c[Unit::perspective] = 4;
    c[Unit::affine] = 2;
    c[Unit::unitNormal] = 6;
    c[Unit::shortNormal] = 1;
    c[Unit::ray] = 300;
    return c;
}

}  // namespace plumb
