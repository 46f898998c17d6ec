// SPDX-License-Identifier: MIT
// A finished picture and its planes, in host memory. Row 0 on top. Conventions: docs/outputs.md.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace plumb {

enum Plane : uint32_t {
    kPlaneColour = 1u,      // encoded RGBA8, always present
    kPlaneLinear = 2u,      // linear RGB, 3 floats
    kPlaneDepth = 4u,       // planar depth w in scene units; +infinity where nothing is drawn
    kPlaneDistance = 8u,    // Euclidean distance from the eye; +infinity where nothing is drawn
    kPlaneNormal = 16u,     // world space, unit, 3 floats; 0 where nothing is drawn
    kPlaneObject = 32u,     // object_id, 0xFFFFFFFF where nothing is drawn
    kPlanePrimitive = 64u,  // primitive_id (face in file order), 0xFFFFFFFF where nothing is drawn
    kPlaneZ = 128u,         // the Z-buffer itself, n/w, larger is nearer, 0 where nothing is drawn (verify)
    kPlaneTriangle = 256u,  // triangle index over the whole scene, 0xFFFFFFFF where nothing is drawn (verify)
};

struct Frame {
    uint32_t width = 0, height = 0;
    std::vector<uint32_t> rgba;  // bytes R, G, B, A; A = 255, or coverage with a transparent background (straight alpha)
    std::vector<float> linear, depth, distance, normal, z;
    std::vector<uint32_t> object, primitive, triangle;
    uint64_t coveredPixels = 0;  // pixels with at least one covered sample
};

}  // namespace plumb
