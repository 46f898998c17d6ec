// SPDX-License-Identifier: MIT
// The choices of a whole picture, each an enum with its rows. Those that trade accuracy for speed stand in trade.h, the planes in planes.h.
#pragma once

#include "pipeline/choices/choice.h"

#include <cstdint>

namespace plumb {

enum class Shading { wire, unlit, flat, gouraud, phong, ray };
inline constexpr Choice<Shading> kShadings[] = {
    {"wire", Shading::wire, "edges only"},
    {"unlit", Shading::unlit, "the material's own colour"},
    {"flat", Shading::flat, "one illumination a face"},
    {"gouraud", Shading::gouraud, "one illumination a vertex, interpolated"},
    {"phong", Shading::phong, "one illumination a pixel"},
    {"ray", Shading::ray, "rays from the eye: shadows, mirrors and glass"},
};

// Which pixels a face covers.
enum class Fill { exact, notes };
inline constexpr Choice<Fill> kFills[] = {
    {"exact", Fill::exact, "8 sub-pixel bits and the top-left rule, watertight"},
    {"notes", Fill::notes, "the polygon fill of the lecture notes, which samples at whole coordinates"},
};

// Edges that a wire frame shows.
enum class WireView { seeThrough, culled, solid };
inline constexpr Choice<WireView> kWireViews[] = {
    {"see-through", WireView::seeThrough, "every edge"},
    {"culled", WireView::culled, "those of polygons that face the viewer"},
    {"solid", WireView::solid, "what is not hidden"},
};

// True: a wire frame draws an edge once for each polygon that has it.
inline constexpr Choice<bool> kEdgeCounts[] = {
    {"once", false, "each edge once"},
    {"polygons", true, "each edge as often as polygons have it"},
};

enum class Encoding { srgb, linear };
inline constexpr Choice<Encoding> kEncodings[] = {
    {"srgb", Encoding::srgb, "IEC 61966-2-1"},
    {"linear", Encoding::linear, "bytes in proportion to light"},
};

// Samples a pixel, in an ordered grid.
inline constexpr Choice<uint32_t> kSampleCounts[] = {
    {"1", 1, "the pixel's centre"},
    {"4", 4, "2x2, resolved in linear light"},
    {"16", 16, "4x4, resolved in linear light"},
};

// Positions at which rays pass through a pixel (docs/rays.md).
enum class Sampling { grid, centre, random, corners, adaptive, notes };
inline constexpr Choice<Sampling> kSamplings[] = {
    {"grid", Sampling::grid, "the middle of each sample's square"},
    {"centre", Sampling::centre, "every ray through the middle of its pixel"},
    {"random", Sampling::random, "a ray anywhere in each sample's square"},
    {"corners", Sampling::corners, "a ray through each corner, shared by up to four pixels"},
    {"adaptive", Sampling::adaptive, "corners, and the 16 samples of a grid where they differ"},
    {"notes", Sampling::notes, "through the lower right corner of each sample"},
};

// True: colours of rays are whole levels, cut after each ray; goes with Encoding::linear.
inline constexpr Choice<bool> kLevelForms[] = {
    {"exact", false, "colours are not rounded"},
    {"cut", true, "colours are whole levels, cut after each ray"},
};

// True: the viewer counts as infinitely far away when a point is lit (raster shadings; --fill notes also culls by it).
inline constexpr Choice<bool> kViewers[] = {
    {"local", false, "from the eye"},
    {"distant", true, "from one direction for every point"},
};

inline const char* nameOf(Shading shading) { return wordOf(kShadings, shading); }
inline const char* nameOf(Fill fill) { return wordOf(kFills, fill); }
inline const char* nameOf(WireView view) { return wordOf(kWireViews, view); }
inline const char* nameOf(Encoding encoding) { return wordOf(kEncodings, encoding); }
inline const char* nameOf(Sampling sampling) { return wordOf(kSamplings, sampling); }

}  // namespace plumb
