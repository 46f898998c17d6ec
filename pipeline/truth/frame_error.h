// SPDX-License-Identifier: MIT
// Error of a picture against the truth.
#pragma once

#include "pipeline/truth/truth.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace plumb {

// Error over the pixels in which the picture or the truth shows something. Largest value and percentile are of a pixel's largest channel.
// Mean and root mean square are over all channels, so that the mean is never above the root mean square.
struct ErrorFigures {
    double max = 0, mean = 0, rms = 0, p99 = 0;
    uint32_t x = 0, y = 0;  // pixel at which the largest value is first met
};

struct FrameError {
    uint64_t pixels = 0;  // pixels in which the picture or the truth shows something
    // Errors in steps of the sRGB code (1/255 of full scale), whichever curve the picture is stored with, so that pictures of both curves
    // compare.
    ErrorFigures picture;      // the bytes as they are stored, rounding to bytes included; alpha is a channel where it is stored
    ErrorFigures unrounded;    // the float32 colour through the same curve, before it becomes a byte; 0 pixels without kPlaneLinear
    ErrorFigures linear;       // the float32 colour in linear light, not clamped
    double depthRelative = 0;  // largest |w - truth| / truth where the same primitive is seen (kPlaneDepth)
    // Pixels that show another face than the truth, a face where it has none, or none where it has one. Of an object without faces of its own in
    // the truth, any face is right.
    uint64_t wrongPrimitive = 0;
    uint32_t wrongX = 0, wrongY = 0;  // the first such pixel
    // `picture.max` over the pixels that PixelChoice::decided holds, and its first pixel. Without that choice over every pixel.
    double decidedMax = 0;
    uint32_t decidedX = 0, decidedY = 0;
    uint64_t undecided = 0;  // pixels that it leaves out
    double wrongShare() const { return pixels == 0 ? 0 : double(wrongPrimitive) / double(pixels); }
    std::vector<float> unroundedPerPixel;  // `unrounded` of each pixel, in steps; the largest channel
    std::vector<float> perPixel;           // `picture` of each pixel, in shares of full scale (1 = 255 steps)
};

// True when a pixel counts: the picture or the truth shows something in it.
bool showsSomething(const Frame& frame, const Truth& truth, size_t at, bool transparent);

// Pixels that an error is taken over, one value a pixel.
struct PixelChoice {
    std::span<const uint8_t> wanted;   // 0: left out of every figure, as its truth is not known; empty: none is left out
    std::span<const uint8_t> decided;  // 0: left out of `decidedMax` (truth/decided.h); empty: none is left out
};

// Error of a frame that has kPlaneLinear, kPlaneDepth, kPlaneObject and kPlanePrimitive. Its samples need not be the truth's. A NaN or
// infinity in a drawn pixel fails before any figure is taken: Error(failed), naming the first pixel.
FrameError errorOf(const Frame& frame, const Truth& truth, Encoding encoding, bool transparent, const PixelChoice& pixels = {});

}  // namespace plumb
