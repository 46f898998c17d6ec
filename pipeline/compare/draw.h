// SPDX-License-Identifier: MIT
// Differences as pictures, 8 bits RGB. NaN is magenta in both.
#pragma once

#include "pipeline/compare/compare.h"
#include "pipeline/render/frame.h"

#include <cstdint>

namespace plumb {

// Picture of |A - B| of each channel times 2^exponent, the largest power of two that keeps every finite difference below 256/255 of full
// scale. A layer of one channel is grey. Ids: white where they differ. Pixels that differ only in alpha: grey.
struct DifferencePicture {
    Frame frame;
    int exponent = 0;
};
DifferencePicture drawDifference(const Picture& a, const Picture& b, const LayerDifference&);

// Picture of the error, dark to bright: FLIP's error (0 to 1) for colour, else error over the largest finite error.
struct HeatPicture {
    Frame frame;
    double brightest = 1;  // error at the top of the scale
    bool flip = false;
};
HeatPicture drawHeat(const LayerDifference&, uint32_t width, uint32_t height);

}  // namespace plumb
