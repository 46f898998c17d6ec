// SPDX-License-Identifier: MIT
// Truth of a picture, for every error figure: what the most accurate choice of every knob would give, in binary64 (docs/truth.md).
// Per-pixel Phong, perspective, exact specular power, vertices not snapped. The visible triangle is decided without rounding wherever
// binary64 leaves it open. It shares no function with the passes: from render/ it takes the types of a request and of a frame, nothing that
// computes.
#pragma once

#include "pipeline/render/render.h"

#include <cstdint>
#include <span>
#include <vector>

namespace plumb {

struct Truth {
    uint32_t width = 0, height = 0, samples = 1;
    bool traced = false;  // true: rays made it, for Shading::ray
    // Planes by the conventions of docs/outputs.md. Linear colour is the mean of the samples (with a transparent background: of the covered
    // ones), not clamped.
    std::vector<double> linear;  // 3 a pixel
    std::vector<double> alpha;   // share of the samples that is covered
    // The truth's own error (docs/derivations.md): no channel is further than this from what exact arithmetic makes of the scene's numbers.
    // 3 a pixel, linear light; +infinity where nothing is known of it.
    std::vector<double> bound;
    std::vector<uint8_t> decided;  // 0: what a sample of the pixel shows is open, even in more bits, and `bound` says nothing
    // Planes of the sample that stands for the pixel.
    std::vector<double> depth;       // planar, scene units; +infinity where nothing is seen
    std::vector<double> depthBound;  // the truth's own error of it; +infinity where nothing is seen
    std::vector<uint32_t> object;    // kNone where nothing is seen
    // kNone where nothing is seen, and on what has no faces of its own: generated shapes, and objects of forgetFaces()
    std::vector<uint32_t> primitive;
    // decisions that binary64 left open and that were decided without rounding; with rays: samples traced again in more bits
    uint64_t redone = 0;
    uint64_t undecided = 0;  // with rays or generated bodies: decisions that binary128 leaves open, such as exact ties
    double leftOut = 0;      // with rays: the largest share of a pixel's weight whose rays were not followed
    double timeMs = 0;
};

// Truth of a scene. From `request` it takes size, samples, background, transparent, threads, fill, and onProgress (called by one thread;
// false cancels: Error(interrupted)). The request's shading changes nothing, since the truth is Phong's. A wire frame has no truth here:
// Error(usage).
// --fill notes: sample (x, y) of a picture with `drawnSamples` a pixel stands for the point (x, y) of the screen. The truth's samples lie
// around it. 0: as many samples as the truth has. Spheres that --fill notes draws have a truth of their own (spheres.h), in parallel
// projection.
// Generated spheres and cylinders are the surfaces themselves (solids.h), whatever segments draw them. A teapot is its patches, cut as finely as a
// scene can have them. With rays, both are their polygons.
// Shading::ray has a truth of its own (rays.h), whatever the request's depth and cutoff. It follows 64 rays one after another and weights
// down to 2^-20 (leftOut: where a tree of thousands ended earlier). Colours have no noise and are not cut to levels. The request says
// where rays pass through a pixel: the grid, the middle, the four corners (their mean), or the notes' corner. Random positions and
// adaptive sampling have the grid's truth. The planes hold the sample that the picture's planes hold.
// `wanted`: nonzero for each pixel whose truth is asked for; the others stay as where nothing is seen. Empty: every pixel.
Truth truthOf(const Scene& scene, const RenderRequest& request, uint32_t drawnSamples = 0, std::span<const uint8_t> wanted = {});

// Takes the faces of objects out of a truth: a picture that draws them by other faces is asked for the object alone.
void forgetFaces(Truth& truth, const std::vector<bool>& objects);

// Code 0 to 255, not rounded: IEC 61966-2-1 of the value clamped to [0, 1].
double srgbCode(double linear);
// Bound of the distance from srgbCode(linear) to the code of any value within `error` of it, in steps.
double srgbCodeError(double linear, double error);

}  // namespace plumb
