// SPDX-License-Identifier: MIT
// Generated shapes: curved surfaces that a scene names, drawn as polygons. Object space, around the origin, +Y up, binary64.
#pragma once

#include "pipeline/scene/load.h"
#include "pipeline/scene/scene.h"

#include <cstdint>
#include <span>
#include <vector>

namespace plumb {

enum class ShapeKind { sphere, cylinder, teapot };

// The surface is the shape's own; `segments` say how many polygons stand for it.
struct GeneratedShape {
    ShapeKind kind = ShapeKind::sphere;
    double radius = 1;       // scene units; sphere, cylinder
    double length = 2;       // along Y, with the origin in the middle; cylinder, which has two caps
    uint32_t segments = 64;  // polygons once around the Y axis
};

// Numbers of segments that a kind can have: from least to most, in steps. A sphere has half as many from pole to pole, the teapot a quarter along
// each side of its 32 patches.
struct SegmentRange {
    uint32_t least, most, step;
};
SegmentRange segmentRangeOf(ShapeKind kind);
// Name in a scene file.
const char* nameOf(ShapeKind kind);

// Polygons of a shape, counter-clockwise from outside, with the normals of the surface itself at their corners. Corners lie on the surface. No
// material.
PolygonMesh polygonsOf(const GeneratedShape& shape);

// Bound of the distance between the surface and its polygons, either way, in the shape's own units, with the rounding of corners to float32:
//   sphere     r sin^2(pi / n)        the plane of a polygon is no nearer to the centre than r cos(pi / n) cos(pi / n), and no polygon is outside
//   cylinder   r (1 - cos(pi / n))
//   teapot     (|Suu| + 2 |Suv| + |Svv|) / (8 s^2), s = n / 4, over all patches (Filip, Magedson and Markot 1986); derivatives by control nets
double deviationOf(const GeneratedShape& shape);
// The fewest segments whose deviation is at most `deviation`; the most of the kind where none are enough.
uint32_t segmentsFor(const GeneratedShape& shape, double deviation);

// Mesh of a shape with another number of segments: name, location and material are those of `mesh`, which has a shape.
TriangleMesh tessellated(const TriangleMesh& mesh, uint32_t segments, bool keepNumbers);

// True when the truth knows the object's surface itself (pipeline/truth/solids.h): a sphere or a cylinder that its matrix does not flatten.
bool standsForSolid(const Scene& scene, uint32_t object);

}  // namespace plumb
