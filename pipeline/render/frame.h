// SPDX-License-Identifier: MIT
// A finished picture and its planes, in host memory. Row 0 on top. Conventions: docs/outputs.md.
#pragma once

#include "pipeline/choices/planes.h"

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace plumb {

struct Frame {
    uint32_t width = 0, height = 0;
    std::vector<uint32_t> rgba;  // bytes R, G, B, A; A = 255, or coverage with a transparent background (straight alpha)
    std::vector<float> linear, depth, distance, normal, z, error;
    std::vector<uint32_t> object, primitive, triangle, certified;
    uint64_t coveredPixels = 0;  // pixels with at least one covered sample
};

// One plane of a frame: its bit, its name in reports, the numbers of a pixel, and their value where nothing is drawn. Colours have the
// background there.
template <class Value>
struct PlaneRow {
    Plane plane;
    const char* name;
    uint32_t channels;
    Value undrawn;
    const char* convention;  // one sentence for file formats; empty: no plane of its own in a file with several
};

// Calls body(row, member) for every plane: the table that writing, files, and comparisons walk. Its order is that in which differences are told:
// what is seen, its colour, what is measured of it.
template <class Body>
void forEachPlane(const Body& body) {
    constexpr uint32_t kNothing = 0xffffffffu;
    constexpr float kFar = std::numeric_limits<float>::infinity();
    body(PlaneRow<uint32_t>{kPlaneTriangle, "triangle", 1, kNothing, ""}, &Frame::triangle);
    body(PlaneRow<uint32_t>{kPlaneObject, nameOf(kPlaneObject), 1, kNothing, "order in the scene, 4294967295 where nothing is drawn"},
         &Frame::object);
    body(PlaneRow<uint32_t>{kPlanePrimitive, nameOf(kPlanePrimitive), 1, kNothing,
                            "face in file order before triangulation, 4294967295 where nothing is drawn"},
         &Frame::primitive);
    body(PlaneRow<float>{kPlaneZ, "z", 1, 0, ""}, &Frame::z);
    body(PlaneRow<float>{kPlaneLinear, nameOf(kPlaneLinear), 3, 0, ""}, &Frame::linear);
    body(PlaneRow<uint32_t>{kPlaneColour, "colour", 1, 0, ""}, &Frame::rgba);
    body(PlaneRow<float>{kPlaneDepth, nameOf(kPlaneDepth), 1, kFar,
                         "Z: planar depth along the view axis, scene units, +infinity where nothing is drawn"},
         &Frame::depth);
    body(PlaneRow<float>{kPlaneDistance, nameOf(kPlaneDistance), 1, kFar,
                         "Euclidean distance from the eye, scene units, +infinity where nothing is drawn"},
         &Frame::distance);
    body(PlaneRow<float>{kPlaneNormal, nameOf(kPlaneNormal), 3, 0, "world space, unit length, 0 where nothing is drawn"}, &Frame::normal);
    body(
        PlaneRow<float>{kPlaneError, nameOf(kPlaneError), 1, kFar,
                        "largest distance of a channel from exact arithmetic, steps of 1/255 of the sRGB code, +infinity where it is open"},
        &Frame::error);
    body(PlaneRow<uint32_t>{kPlaneCertified, nameOf(kPlaneCertified), 1, 0, "0 open, 1 decided, 2 within a step, 3 within half a step"},
         &Frame::certified);
}

}  // namespace plumb
