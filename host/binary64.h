// SPDX-License-Identifier: MIT
// Whether a device computes in binary64 as the processor does: asked of it once, by a dispatch, when something wants to.
#pragma once

#include "host/device.h"
#include "shared/selftest.h"

#include <span>
#include <string>
#include <vector>

namespace plumb {

// Why this device cannot take the place of the twin in binary64, one sentence that names it; empty: it can.
// Throws Error when the dispatch fails.
std::string lacksBinary64(Device& device);

// kDoubleVectors operands: some whose float32 is a tie or a unit beside one, the others random; the same on every machine.
std::vector<gpu::DoubleVector> doubleVectors();
// Whether all answers are those of the processor. Zeros compare equal whatever their sign.
bool judgeDoubles(std::span<const gpu::DoubleVector> vectors, std::span<const gpu::DoubleAnswer> answers);

}  // namespace plumb
