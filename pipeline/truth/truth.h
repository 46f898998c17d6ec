// SPDX-License-Identifier: MIT
// The truth of a picture, for every error figure: what the most accurate choice of every knob would give, in binary64 (docs/accuracy.md). Per-pixel
// Phong, perspective, exact specular power, vertices not snapped; which triangle is seen is decided without rounding wherever binary64 leaves it
// open. It shares no function with the passes: of render/ it takes the types of a request and of a frame, nothing that computes.
#pragma once

#include "pipeline/render/render.h"

namespace plumb {

struct Truth {
    uint32_t width = 0, height = 0, samples = 1;
    // Conventions of docs/outputs.md. Linear colour is the mean of the samples (with a transparent background: of those covered), not clamped.
    std::vector<double> linear;  // 3 a pixel
    std::vector<double> alpha;   // share of the samples that is covered
    // Of the sample that stands for the pixel.
    std::vector<double> depth;                // planar, scene units; +infinity where nothing is seen
    std::vector<uint32_t> object, primitive;  // kNone where nothing is seen
    uint64_t redone = 0;                      // decisions that binary64 left open, decided without rounding
    double timeMs = 0;
};

// Of `request`: size, samples, background, transparent, threads, fill (notes: sample (x, y) of a picture with `drawnSamples` a pixel stands for the point
// (x, y) of the screen, and the truth's samples lie around it; 0: as many as the truth's)
// and onProgress (called by one thread; false cancels: Error(interrupted)). Its shading
// changes nothing, since the truth is Phong's. A wire frame has no truth here: Error(usage).
Truth truthOf(const Scene& scene, const RenderRequest& request, uint32_t drawnSamples = 0);

// 0 to 255, not rounded: IEC 61966-2-1 of the value clamped to [0, 1].
double srgbCode(double linear);

}  // namespace plumb
