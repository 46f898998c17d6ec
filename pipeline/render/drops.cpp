// SPDX-License-Identifier: MIT
#include "pipeline/render/drops.h"

#include "pipeline/render/dark_lights.h"
#include "pipeline/render/hidden.h"
#include "pipeline/render/rays/ray_parts.h"
#include "pipeline/scene/flattened.h"

#include <fmt/core.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace plumb {

namespace {

// From here on a kernel with its lights unrolled pays for the time that it takes to make (decision 71).
constexpr uint64_t kPixelsWorthUnrolling = uint64_t(1) << 23;

bool isLit(const Dropping& d) { return d.p.choices.shading != gpu::kShadingUnlit; }

void outside(const DropRow& row, Dropping& d) {
    for (size_t i = 0; i < d.scene.objects.size(); ++i) {
        const Object& object = d.scene.objects[i];
        if (outsideView(d.scene.meshes[object.mesh], worldFromMesh(d.scene, object), d.view)) d.p.leftOut[i] = &row;
    }
}

// Coarser depths than float32 may find two surfaces alike that are not, and a picture that is drawn again may look from elsewhere.
void hidden(const DropRow& row, Dropping& d) {
    if (d.request.trade.depthBits != 32 || (d.way == kWayRaster && d.request.repeated && !(d.request.planes & kPlaneTriangle))) return;
    std::vector<bool> gone;
    for (const DropRow* left : d.p.leftOut) gone.push_back(left != nullptr);
    const std::vector<uint32_t> hiders = hidersOf(d.scene, d.view, gone);
    for (size_t i = 0; i < hiders.size(); ++i)
        if (hiders[i] != kNone) d.p.leftOut[i] = &row;
}

// Takes the lights of which `needless` is true out of the list.
void dropLights(const DropRow& row, Dropping& d, const char* why, const std::function<bool(const gpu::LightRecord&)>& needless) {
    std::vector<gpu::LightRecord>& lights = d.p.list.lights;
    const size_t all = lights.size();
    const size_t gone = std::erase_if(lights, needless);
    for (size_t i = 0; i < gone; ++i)
        stateDrop(row, d.p.plan, "", why,
                  fmt::format("1 of {} at each illumination{}", countOf(all, "light", "lights"),
                              d.way == kWayRays ? ", and its shadow ray" : ""));
}

void unreflected(const DropRow& row, Dropping& d) {
    if (!isLit(d)) return;
    if (d.way != kWayRays)
        return dropLights(row, d, "no material reflects its colour", [&](const gpu::LightRecord& l) { return isUnreflected(l, d.p.list); });
    DrawList all;  // of a scene of rays, the materials alone
    for (const Material& m : d.scene.materials) all.materials.push_back({glm::vec3(0), 0, m.diffuse, 0, m.specular, 0});
    dropLights(row, d, "no material reflects its colour", [&](const gpu::LightRecord& l) { return isUnreflected(l, all); });
}

void turnedAway(const DropRow& row, Dropping& d) {
    if (!isLit(d) || d.request.repeated || d.request.trade.vectors != Trade::Vectors::pixel) return;
    dropLights(row, d, "every drawn face is turned away from it",
               [&](const gpu::LightRecord& l) { return isTurnedAway(l, d.p.list, d.p.choices.shading); });
}

bool none(const glm::vec3& colour) { return colour == glm::vec3(0); }

// Materials of a list, or those that rays may meet.
struct Terms {
    bool diffuse = false, specular = false, point = false;
};
Terms termsOf(const Dropping& d) {
    Terms t;
    for (const gpu::MaterialRecord& m : d.p.list.materials) {
        t.diffuse |= !none(m.diffuse);
        t.specular |= !none(m.specular);
    }
    if (d.way == kWayRays) {
        t.diffuse = true;  // its kernel has no form without
        t.specular = false;
        for (const uint32_t m : materialsOfRays(d.scene)) t.specular |= !none(d.scene.materials[m].specular);
    }
    for (const gpu::LightRecord& l : d.p.list.lights) t.point |= l.kind != 0;
    return t;
}

void illumination(const DropRow& row, Dropping& d) {
    if (!isLit(d)) return;
    Prepared& p = d.p;
    FillChoices& c = p.choices;
    const Terms terms = termsOf(d);
    if (!p.list.lights.empty() && (terms.diffuse || terms.specular)) return;
    stateDrop(row, p.plan, "", p.list.lights.empty() ? "no light" : "no material reflects light", "all of it");
    p.list.lights.clear();
    if (d.way == kWayRays) return;
    c.parts = {false, false, false};
    // Interpolating equal colours rounds: Gouraud keeps its colours of vertices, the others draw the base colour itself.
    // The notes' polygons keep theirs too, where their normals are asked for.
    if (c.shading == gpu::kShadingGouraud || (d.way == kWayPolygons && (d.request.planes & kPlaneNormal))) return;
    c.shading = gpu::kShadingUnlit;
    for (gpu::MaterialRecord& m : p.list.materials) m.diffuse = m.base;
}

bool isIlluminated(const Dropping& d) { return isLit(d) && !d.p.list.lights.empty(); }

void diffuse(const DropRow& row, Dropping& d) {
    if (!isIlluminated(d) || termsOf(d).diffuse) return;
    d.p.choices.parts.diffuse = false;
    stateDrop(row, d.p.plan, "", "Kd is 0 everywhere", "a term of each light");
}
void specular(const DropRow& row, Dropping& d) {
    if (!isIlluminated(d) || termsOf(d).specular) return;
    d.p.choices.parts.specular = false;
    stateDrop(row, d.p.plan, "", "Ks is 0 everywhere", "a power of each light");
}
void position(const DropRow& row, Dropping& d) {
    if (!isIlluminated(d) || termsOf(d).point) return;
    d.p.choices.parts.point = false;
    stateDrop(row, d.p.plan, "", "no point light", "a position at each illumination");
}

void lamps(const DropRow& row, Dropping& d) {
    FillChoices& c = d.p.choices;
    const size_t lights = d.p.list.lights.size();
    const bool manyPixels = d.request.repeated || uint64_t(d.p.width) * d.p.height >= kPixelsWorthUnrolling;
    if (!isIlluminated(d) || !manyPixels || lights > gpu::kUnrolledLights) return;
    c.lightCount = uint32_t(lights);
    c.lightKinds = kindsOf(d.p.list.lights);
    stateDrop(row, d.p.plan, "", fmt::format("{}, of known kinds", countOf(lights, "light", "lights")), "a loop at each pixel");
}
void material(const DropRow& row, Dropping& d) {
    if (!isIlluminated(d) || d.p.list.materials.size() != 1) return;
    d.p.choices.oneMaterial = true;
    stateDrop(row, d.p.plan, "", "there is one", "a read at each pixel");
}

// A picture that is drawn again from elsewhere keeps the step.
void clip(const DropRow& row, Dropping& d) {
    if (d.p.list.triangles.empty() || (d.request.repeated && d.way == kWayRaster) || !nothingCrosses(d)) return;
    d.p.nothingCrosses = true;
    stateDrop(row, d.p.plan, "", "every object lies beyond the near plane and within the guard band", "1 step");
}

void normals(const DropRow& row, Dropping& d) {
    if (d.p.choices.shading == gpu::kShadingPhong) return;
    d.p.choices.keepNormals = false;
    stateDrop(row, d.p.plan, "", "no pixel is shaded by its normal", countOf(d.p.list.positions.size(), "normal", "normals"));
}

// Children of the first hits, and with them all others. The eye sees objects in the view alone; a ray that goes on may see everything.
void children(const DropRow& row, Dropping& d, bool RayParts::*part, bool (*sends)(const RayReach&), const char* noneAtAll) {
    const RayReach reach = rayReachOf(d.scene, d.request, d.view);
    if (reach.eyeSends && sends(reach)) return;
    d.p.rays.*part = false;
    stateDrop(row, d.p.plan, "", sends(reach) ? "no material in the view sends a ray on" : noneAtAll, "a child of each hit");
}
void mirrored(const DropRow& row, Dropping& d) {
    children(
        row, d, &RayParts::mirrors, [](const RayReach& r) { return r.mirrors; }, "no material reflects, or the depth is 1");
}
void refracted(const DropRow& row, Dropping& d) {
    children(
        row, d, &RayParts::passes, [](const RayReach& r) { return r.passes; }, "no material transmits, or the depth is 1");
}
void shadowRays(const DropRow& row, Dropping& d) {
    if (!d.scene.shadows || d.p.list.lights.empty()) return;
    const std::string why = standsAlone(d.scene);
    if (why.empty()) return;
    d.p.rays.shadows = false;
    stateDrop(row, d.p.plan, "", why, "1 ray a light and hit");
}

constexpr uint32_t kTriangles = kWayRaster | kWayHiddenLines;
constexpr uint32_t kLit = kWayRaster | kWayPolygons | kWaySpheres;
// Every row also stands in the comparisons over committed and random scenes beside it.
constexpr const char* kOwn = "DropsOf.EachRowFiresInASceneOfItsOwn";

// In the order in which they decide; a row may make those behind it needless.
constexpr DropRow kRows[] = {
    {"outside", "object", "no pixel of it is in the picture", kOwn, kTriangles | kWayWire | kWayPolygons, DropStage::objects, outside},
    {"hidden", "object", "each pixel of it lies behind a face that is drawn there", kOwn, kTriangles, DropStage::objects, hidden},
    {"dark", "light", "it adds 0", kOwn, kLit | kWayRays, DropStage::lights, nullptr},
    {"unreflected", "light", "each of its terms is 0", kOwn, kLit | kWayRays, DropStage::lights, unreflected},
    {"turned-away", "light", "N.L is at most 0 at each drawn point", kOwn, kWayRaster, DropStage::lights, turnedAway},
    {"illumination", "illumination", "a sum of nothing is what it starts from", kOwn, kLit | kWayRays, DropStage::illumination,
     illumination},
    {"diffuse", "diffuse", "its term is 0", kOwn, kLit, DropStage::illumination, diffuse},
    {"specular", "specular", "its term is 0", kOwn, kLit | kWayRays, DropStage::illumination, specular},
    {"position", "surface position", "directions do not depend on it", kOwn, kLit | kWayRays, DropStage::illumination, position},
    {"lamps", "lights in a loop", "constants are folded, and rounded as before", kOwn, kWayRaster, DropStage::illumination, lamps},
    {"material", "material of each pixel", "all have the same", kOwn, kWayRaster, DropStage::illumination, material},
    {"clip", "clip", "no triangle is cut", kOwn, kTriangles, DropStage::steps, clip},
    {"normals", "normals", "nobody reads them", kOwn, kWayRaster, DropStage::steps, normals},
    {"nothing", "every pass", "there is no triangle", kOwn, kWayRaster, DropStage::steps, nullptr},
    {"mirrored", "mirrored rays", "their weight is 0, or nothing that sends one is hit", kOwn, kWayRays, DropStage::steps, mirrored},
    {"refracted", "refracted rays", "their weight is 0, or nothing that sends one is hit", kOwn, kWayRays, DropStage::steps, refracted},
    {"shadow-rays", "shadow rays", "they meet nothing", kOwn, kWayRays, DropStage::steps, shadowRays},
};

}  // namespace

bool nothingCrosses(const Dropping& d) {
    return std::all_of(d.p.list.ranges.begin(), d.p.list.ranges.end(), [&](const DrawList::Range& r) {
        const Object& object = d.scene.objects[r.sceneObject];
        return screenBoxOf(d.scene.meshes[object.mesh], worldFromMesh(d.scene, object), d.view).ahead;
    });
}

std::span<const DropRow> dropRows() { return kRows; }

const DropRow& dropRow(const char* name) {
    const auto found = std::find_if(std::begin(kRows), std::end(kRows), [&](const DropRow& row) { return std::string(row.name) == name; });
    PLUMB_ASSERT(found != std::end(kRows));
    return *found;
}

void walkDrops(DropStage stage, Dropping& dropping) {
    if (stage == DropStage::objects) dropping.p.leftOut.assign(dropping.scene.objects.size(), nullptr);
    if (dropping.request.knobs.keepEverything) return;
    for (const DropRow& row : kRows)
        if (row.stage == stage && (row.ways & dropping.way) && row.drop != nullptr) row.drop(row, dropping);
}

void stateDrop(const DropRow& row, Plan& plan, const std::string& what, const std::string& why, const std::string& saves) {
    plan.dropped.push_back({what.empty() ? row.what : what, why, row.name, saves});
}

std::string countOf(uint64_t count, const char* one, const char* several) {
    return fmt::format("{} {}", count, count == 1 ? one : several);
}

}  // namespace plumb
