// SPDX-License-Identifier: MIT
// Test whether a device computes in binary64 as the processor does. It runs once, as a dispatch, when binary64 is first needed.
#pragma once

#include "host/device.h"
#include "shared/selftest.h"

#include <span>
#include <string>
#include <vector>

namespace plumb {

// Reason why this device cannot replace the twin in binary64, one sentence that names the device; empty when it can. Throws Error when the
// dispatch fails.
std::string lacksBinary64(Device& device);

// Operands of the test, kDoubleVectors of them: some whose float32 is a tie or a unit beside one, the others random; the same on every
// machine.
std::vector<gpu::DoubleVector> doubleVectors();
// True when all answers are those of the processor. Zeros compare equal whatever their sign.
bool judgeDoubles(std::span<const gpu::DoubleVector> vectors, std::span<const gpu::DoubleAnswer> answers);

}  // namespace plumb
