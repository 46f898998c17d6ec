// SPDX-License-Identifier: MIT
// The planes of a picture, as bits and as words of --aov. Their values stand in a Frame (pipeline/render/frame.h).
#pragma once

#include "pipeline/choices/choice.h"

#include <cstdint>

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
    // Certificate of a pixel (pipeline/truth/certificate.h): no byte of it is further from the picture in exact arithmetic. In steps of the sRGB code,
    // 1/255 of full scale; +infinity where what is seen is open.
    kPlaneError = 512u,
    kPlaneCertified = 1024u,  // what that proves: 0 open, 1 decided, 2 within a step, 3 within half a step
};

// Planes that come of comparing a finished picture with its truth. No pass writes them, and a request to draw does not ask for them.
inline constexpr uint32_t kPlanesJudged = kPlaneError | kPlaneCertified;

// Planes that --aov can ask for.
inline constexpr Choice<Plane> kAovs[] = {
    {.word = "color", .value = kPlaneColour, .help = "the picture", .alias = "colour"},
    {.word = "linear", .value = kPlaneLinear, .help = "linear RGB"},
    {.word = "depth", .value = kPlaneDepth, .help = "depth along the view axis"},
    {.word = "distance", .value = kPlaneDistance, .help = "distance from the eye"},
    {.word = "normal", .value = kPlaneNormal, .help = "unit normal in world space"},
    {.word = "object_id", .value = kPlaneObject, .help = "which object is seen", .alias = "id"},
    {.word = "primitive_id", .value = kPlanePrimitive, .help = "which face is seen, in file order"},
    {.word = "error", .value = kPlaneError, .help = "how far a pixel is from exact arithmetic at most, in steps of 1/255"},
    {.word = "certified", .value = kPlaneCertified, .help = "what that proves: 0 open, 1 decided, 2 within a step, 3 within half a step"},
};

inline const char* nameOf(Plane plane) { return wordOf(kAovs, plane); }

}  // namespace plumb
