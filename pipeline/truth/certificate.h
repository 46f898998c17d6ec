// SPDX-License-Identifier: MIT
// What the truth proves of a drawn picture, pixel by pixel: no byte of it is further from the picture in exact arithmetic.
#pragma once

#include "pipeline/truth/truth.h"

#include <cstdint>
#include <vector>

namespace plumb {

// Values of kPlaneCertified, by what is proved; each one includes those below it but `open`.
enum class Grade : uint32_t { open = 0, decided = 1, oneStep = 2, halfStep = 3 };

struct Certificate {
    // kPlaneError: distance of a pixel's largest channel to the truth, and the truth's own error on top (docs/derivations.md). In steps of the sRGB code,
    // rounded up to float32; +infinity where the truth leaves open what is seen, or does not bound its own error.
    std::vector<float> steps;
    std::vector<uint32_t> grades;  // kPlaneCertified: values of Grade
    // Counts over the pixels in which the picture or the truth shows something.
    uint64_t pixels = 0;
    uint64_t open = 0, oneStep = 0, halfStep = 0;  // oneStep: half a step included
    double max = 0;                                // largest that is finite, and its first pixel
    uint32_t x = 0, y = 0;
    double shareOf(uint64_t count) const { return pixels == 0 ? 0 : double(count) / double(pixels); }
};

// Certificate of a frame that has kPlaneObject, drawn with that encoding and background. The bytes are judged as they are stored, rounding to bytes
// included, and alpha is a channel where it is stored.
Certificate certificateOf(const Frame& frame, const Truth& truth, Encoding encoding, bool transparent);

}  // namespace plumb
