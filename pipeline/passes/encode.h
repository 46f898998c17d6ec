// SPDX-License-Identifier: MIT
// Encode on the host: thresholds, the device's table, and the twin. Contract: shaders/shared/encode.h.
#pragma once

#include "shaders/shared/encode.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace plumb {

// Thresholds of the sRGB codes. threshold[c], c = 1..255: the least float32 whose exact sRGB value times 255 is at least c - 1/2.
// threshold[0] = 0.
const std::array<float, 256>& srgbThresholds();

// Table for the device, one word a bucket (gpu::encodeInBucket).
const std::vector<uint32_t>& srgbBucketTable();

// Code of a linear value. The twin searches the thresholds by bisection.
uint32_t encodeSrgbCpu(float linear);

// Pixel of packed R, G, B, A bytes. linear: 3 floats.
uint32_t encodePixelCpu(uint32_t encoding, const float* linear, uint32_t alpha);

}  // namespace plumb
