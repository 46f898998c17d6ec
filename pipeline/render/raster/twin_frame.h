// SPDX-License-Identifier: MIT
// The twin, pass by pass. It keeps the output of every pass, so that the device can be compared with it.
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
    std::vector<glm::vec4> faceColours;     // one colour a face; flat shading only
    std::vector<gpu::CullRecord> records;
    DrawSlots slots;
    std::vector<gpu::DrawTriangle> draws;
    std::vector<uint32_t> clipKinds;
    std::vector<glm::vec4> clipSpace;  // clip-space vertices (transform.h) where some object is not transformed in float32
};

// The passes of the geometry. Each reads what those before it left in `geometry`. `normals`: attributes are world normals whatever the
// shading.
class TwinPasses {
public:
    TwinPasses(const DrawList& list, const FillChoices& choices, bool normals, uint32_t threads, TwinGeometry& geometry);
    bool illuminates() const;  // true when vertices or faces get colours
    void transform();
    void illuminate();
    void cull();
    void setUp();  // set-up and clip

private:
    const DrawList& list_;
    const FillChoices& choices_;
    const bool normals_;
    const uint32_t threads_;
    TwinGeometry& g_;
};

// Runs all passes on the whole list.
TwinGeometry twinGeometry(const DrawList& list, const FillChoices& choices, bool normals, uint32_t threads);

}  // namespace plumb
