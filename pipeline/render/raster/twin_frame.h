// SPDX-License-Identifier: MIT
// The twin, pass by pass: what every pass of a draw list leaves, kept so that the device can be compared with it.
#pragma once

#include "pipeline/passes/bin.h"
#include "pipeline/passes/cull.h"
#include "pipeline/render/prepare.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb {

struct TwinGeometry {
    std::vector<gpu::ScreenVertex> screen;  // vertices, then clipped corners
    std::vector<glm::vec4> attributes;      // normals or vertex colours, then clipped corners
    std::vector<glm::vec4> faceColours;     // flat
    std::vector<gpu::CullRecord> records;
    DrawPlaces places;
    std::vector<gpu::DrawTriangle> draws;
    std::vector<uint32_t> clipKinds;
    std::vector<glm::vec4> clipSpace;  // of vertices, unless they are transformed in float32
};

// The passes of the geometry, each on what those before it left in `geometry`. `normals`: attributes are world normals whatever the shading.
class TwinPasses {
public:
    TwinPasses(const DrawList& list, const FillChoices& choices, bool normals, uint32_t threads, TwinGeometry& geometry);
    bool illuminates() const;  // vertices or faces
    void transform();
    void illuminate();
    void cull();
    void setUp();  // and clip

private:
    const DrawList& list_;
    const FillChoices& choices_;
    const bool normals_;
    const uint32_t threads_;
    TwinGeometry& g_;
};

// All of them on the whole list.
TwinGeometry twinGeometry(const DrawList& list, const FillChoices& choices, bool normals, uint32_t threads);

}  // namespace plumb
