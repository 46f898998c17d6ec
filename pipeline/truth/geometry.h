// SPDX-License-Identifier: MIT
// Visibility at a sample, by rays rather than by edge functions on a grid. The sample's ray is r = (X, Y, 1) in camera axes: x to the right
// and y down times the focal length, w forward. It meets the plane of a triangle (a, b, c) at w = D / S, with
//   E_a = r . (b x c), E_b = r . (c x a), E_c = r . (a x b),   S = E_a + E_b + E_c,   D = a . (b x c).
// It hits when all E / D >= 0 and w >= near, whatever lies behind the eye. Nothing is clipped, and no vertex is snapped. D / |D| says which
// side is seen. Everything is a polynomial in the scene's numbers, computed in binary64 with a running bound. A sign or an order in depth
// that the bound leaves open is found again without rounding (exact.h).
#pragma once

#include "pipeline/scene/scene.h"
#include "pipeline/truth/exact.h"

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <unordered_map>
#include <vector>

namespace plumb::truth {

// Samples: columns from left to right and rows downward; sample (i, j) lies at X = i + 0.5 - width / 2 - shift, Y = j + 0.5 - height / 2 - shift.
struct Pinhole {
    double width = 0, height = 0;  // samples
    double focal = 0;              // samples
    double near = 0;               // scene units
    double shift = 0;              // in samples; half a drawn sample where that stands for a whole coordinate of the screen (--fill notes)
    glm::dvec3 eye, right, down, forward;

    Pinhole(const Camera& camera, uint32_t width, uint32_t height, uint32_t side, double shift = 0);
    double x(int i) const { return i + 0.5 - width / 2 - shift; }
    double y(int j) const { return j + 0.5 - height / 2 - shift; }
};

// A number and a bound of its error.
struct Bounded {
    double value = 0, error = 0;
};

struct Corner {
    Bounded x, y, w;          // camera axes, x and y times the focal length
    glm::dvec3 fromEye{0};    // world axes, relative to the eye
    double fromEyeError = 0;  // no vector is further from the true one
};

struct Triangle {
    uint32_t object = 0, triangle = 0;  // object of the scene; triangle of the object's mesh
    std::array<uint32_t, 3> vertex{};   // vertices of the mesh, in the order in which the front runs
    // Edge functions E_i(X, Y) = a X + b Y + c, >= 0 inside whichever side is seen, with a bound of their error anywhere in the frame.
    double a[3] = {}, b[3] = {}, c[3] = {}, error[3] = {};
    // Inverse depth 1 / w = sa X + sb Y + sc, with a bound of its error anywhere in the frame.
    double sa = 0, sb = 0, sc = 0, inverseError = 0;
    int firstColumn = 0, lastColumn = -1, firstRow = 0, lastRow = -1;  // samples that it may cover
};

// Polynomials of a triangle without rounding; signs so that the seen side is positive.
struct ExactTriangle {
    Exact a[3], b[3], c[3], volume;  // E_i and D
    Exact edge(int i, double x, double y) const { return a[i] * x + b[i] * y + c[i]; }
};

class Geometry {
public:
    Geometry(const Scene& scene, const Pinhole& pinhole);

    // Triangles that may be seen, in the order that decides ties: object, then index in the mesh.
    const std::vector<Triangle>& triangles() const { return triangles_; }
    Corner corner(uint32_t object, uint32_t vertex) const;
    ExactTriangle exactly(const Triangle& t) const;
    const Pinhole& pinhole() const { return pinhole_; }
    uint64_t redone() const { return redone_; }  // decisions of the set-up that were found again without rounding

private:
    std::array<Exact, 3> exactCorner(uint32_t object, uint32_t vertex) const;
    void add(uint32_t object, uint32_t index, bool mirrored);

    const Scene& scene_;
    Pinhole pinhole_;
    std::vector<Triangle> triangles_;
    std::vector<Corner> corners_;  // corners of the current object
    uint64_t redone_ = 0;
};

// Decides coverage and depth for one thread; remembers the exact form of the triangles in doubt.
class Judge {
public:
    explicit Judge(const Geometry& geometry) : geometry_(geometry) {}

    // True when the ray of sample (X, Y) hits triangle `index` at or beyond the near plane. A sample on an edge belongs to the triangle of
    // which the edge is a left or a top one.
    bool hits(uint32_t index, double x, double y);
    // True when triangle `index` is nearer than `best` at a sample that both cover. At equal depth the smaller index is nearer.
    bool nearer(uint32_t index, uint32_t best, double x, double y);
    uint64_t redone() const { return redone_; }

private:
    const ExactTriangle& exactly(uint32_t index);

    const Geometry& geometry_;
    std::unordered_map<uint32_t, ExactTriangle> known_;
    uint64_t redone_ = 0;
};

}  // namespace plumb::truth
