// SPDX-License-Identifier: MIT
// The knobs that trade speed for accuracy: one axis each, with its choices. What a renderer could offer and this one does not is listed as absent.
#pragma once

#include "pipeline/choices/choice.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace plumb {

// One way to draw the scene.
struct Setting {
    RenderRequest request;
    bool twin = false;      // the CPU twin draws, not the device
    bool again = false;     // the default picture once more: no other work
    double detail = 0;      // largest deviation of simplified meshes and generated shapes, in pixels; 0: drawn as the scene has them
    uint32_t segments = 0;  // of every generated shape; 0: as stated
};

// True when the picture shows surfaces, so that there is a truth to hold it against. Wire frames are drawings.
bool hasTruth(const RenderRequest&);

// The choices of a setting as words: equal words, equal work.
std::string wordsOf(const Setting&);

struct AxisChoice {
    const char* name;
    Verdict verdict;                      // docs/accuracy.md
    std::function<void(Setting&)> apply;  // empty: absent
    std::string why;                      // absent: why; else what it does
};

// Which pictures have such a choice.
enum class Scope { raster, rays, both };

struct Axis {
    const char* name;
    const char* what;  // one line for people
    std::vector<AxisChoice> choices;
    Scope scope = Scope::raster;
};

// Rank of an axis among what people ask about a picture: 0 is asked first, and cut last where time is short.
size_t askedRank(const Axis&);
// The default again, a row of every measurement: how far apart two measurements of one work come out.
const Axis& controlAxis();
// The most samples a pixel that any choice of any axis takes: one number for every list of axes.
uint32_t mostSamples(const Setting& base);

std::span<const Axis> axes();
// Throws Error(usage) with the accepted names.
const Axis& axisOf(const std::string& name);

}  // namespace plumb
