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
    std::vector<glm::vec4> carried;         // normals or vertex colours, then clipped corners
    std::vector<glm::vec4> faceColours;     // flat
    std::vector<gpu::CullRecord> records;
    DrawPlaces places;
    std::vector<gpu::DrawTriangle> draws;
    std::vector<uint32_t> clipKinds;
    std::vector<glm::vec4> clipSpace;  // of vertices, unless they are transformed in float32
};

// transform, illuminate, cull, set-up and clip of the whole list. `normals`: carry world normals whatever the shading.
TwinGeometry twinGeometry(const DrawList& list, const FillChoices& choices, bool normals, uint32_t threads, std::vector<PassTime>* times);

}  // namespace plumb
