// SPDX-License-Identifier: MIT
// Table of drops: work that pictures of a kind have and this one does not need, left out without a difference in any byte. A row decides for one
// picture, changes what is drawn and states it in the plan. Techniques walk the rows stage by stage; TestKnobs::keepEverything walks none.
#pragma once

#include "pipeline/render/camera.h"
#include "pipeline/render/prepare.h"

#include <cstdint>
#include <span>
#include <string>

namespace plumb {

// Ways to draw, as bits of DropRow::ways. hiddenLines: wire frames whose hidden lines are removed.
inline constexpr uint32_t kWayRaster = 1, kWayWire = 2, kWayHiddenLines = 4, kWayPolygons = 8, kWaySpheres = 16, kWayRays = 32;

// What is known of the picture when a row decides.
enum class DropStage {
    objects,       // the view
    lights,        // and objects and lights of the draw list
    illumination,  // the same, in a picture that is lit
    steps,         // and the choices of the passes
};

struct DropRow;

// A picture that is being prepared. Rows change `p`.
struct Dropping {
    const Scene& scene;
    const RenderRequest& request;
    const Pinhole& view;
    Prepared& p;
    uint32_t way;  // kWay bit
};

struct DropRow {
    const char* name;  // of the row, in JSON
    const char* what;  // work that is left out
    const char* why;   // reason why no byte changes
    const char* test;  // test that shows the row fire, and compares the bytes with those of the full plan
    uint32_t ways;     // kWay bits
    DropStage stage;
    void (*drop)(const DropRow&, Dropping&);  // null: the code that builds the list does it, object by object or light by light
};

std::span<const DropRow> dropRows();
const DropRow& dropRow(const char* name);  // the row must be there

// True when no triangle of the draw list can be cut, by the boxes of its objects.
bool nothingCrosses(const Dropping& dropping);

// Walks the rows of a stage.
void walkDrops(DropStage stage, Dropping& dropping);

// States a drop in the plan. `what`: the thing, where it is one of several; empty: that of the row.
void stateDrop(const DropRow& row, Plan& plan, const std::string& what, const std::string& why, const std::string& saves);

// "1 vertex", "2401 vertices"
std::string countOf(uint64_t count, const char* one, const char* several);

}  // namespace plumb
