// SPDX-License-Identifier: MIT
// Counted work of a picture, and what a unit of it costs. Counts do not depend on how busy a machine is.
#pragma once

#include "pipeline/render/render.h"

#include <array>
#include <cstddef>
#include <string>

namespace plumb {

// Units that a picture's work is counted in. Of each axis of the trade, the units of its choices differ; what they have in common is in
// `shade` and `light`.
enum class Unit : size_t {
    picture,
    sample,
    covered,
    vertex,
    vertex64,
    vertexInteger,
    triangle,
    corner,
    shade,
    light,
    power,
    quickPower,
    vectorPixel,
    vectorVertex,
    vectorFace,
    vectorScene,
    perspective,
    affine,
    unitNormal,
    shortNormal,
    ray,
};
inline constexpr size_t kUnits = size_t(Unit::ray) + 1;
inline constexpr Choice<Unit> kUnitWords[] = {
    {"picture", Unit::picture, "a picture by itself"},
    {"sample", Unit::sample, "a sample that is cleared, resolved and encoded"},
    {"covered", Unit::covered, "a sample that a triangle covers"},
    {"vertex", Unit::vertex, "a vertex transformed in float32"},
    {"vertex64", Unit::vertex64, "a vertex transformed in binary64"},
    {"vertexInteger", Unit::vertexInteger, "a vertex transformed in integers"},
    {"triangle", Unit::triangle, "a triangle of the scene"},
    {"corner", Unit::corner, "a light at a vertex or a face"},
    {"shade", Unit::shade, "a sample that is shaded"},
    {"light", Unit::light, "a light at a sample"},
    {"power", Unit::power, "a highlight's power"},
    {"quickPower", Unit::quickPower, "Schlick's quotient"},
    {"vectorPixel", Unit::vectorPixel, "a direction at a sample"},
    {"vectorVertex", Unit::vectorVertex, "an interpolated direction"},
    {"vectorFace", Unit::vectorFace, "a direction of a face"},
    {"vectorScene", Unit::vectorScene, "a direction of the scene"},
    {"perspective", Unit::perspective, "attributes interpolated by 1/w"},
    {"affine", Unit::affine, "attributes interpolated on the screen"},
    {"unitNormal", Unit::unitNormal, "a normal made unit"},
    {"shortNormal", Unit::shortNormal, "a normal as interpolated"},
    {"ray", Unit::ray, "a ray, those to lights included"},
};

// One number a unit.
struct PerUnit {
    std::array<double, kUnits> of{};
    double& operator[](Unit unit) { return of[size_t(unit)]; }
    double operator[](Unit unit) const { return of[size_t(unit)]; }
};
using Work = PerUnit;       // counts
using UnitCosts = PerUnit;  // nanoseconds of one

// What was counted of a picture, of full size or smaller.
struct Counted {
    double covered = 0;  // samples
    RenderCounters counters;
};
Counted countedOf(const RenderResult& result, const RenderRequest& request);

// Work of the picture of `request` from what was counted of one of its size divided by `shrink` each way.
Work workOf(const Scene& scene, const RenderRequest& request, const Counted& counted, double shrink = 1);
// Rays of a picture, those to lights included.
double raysOf(const RenderCounters& counters);

// Milliseconds.
double costOf(const Work& work, const UnitCosts& costs);

// Costs where no device was calibrated: the twin's on the machine that docs/budgets.md names. They order choices; they promise no time.
UnitCosts nominalCosts();

}  // namespace plumb
