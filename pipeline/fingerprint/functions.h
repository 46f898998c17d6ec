// SPDX-License-Identifier: MIT
// Powers, logarithms, sine and cosine of float32 numbers to more than 90 bits, in integers alone. No input makes the result of one of them
// lie nearer to a middle of two float32 than that and not be it, so nearestFloat() of a result is correctly rounded.
#pragma once

#include "pipeline/fingerprint/exact.h"

#include <cstdint>

namespace plumb {

Exact exp2Of(uint32_t x);
Exact expOf(uint32_t x);
Exact log2Of(uint32_t x);  // of a negative number: NaN
Exact logOf(uint32_t x);
Exact powOf(uint32_t x, uint32_t y);  // x > 0 and both finite
Exact sinOf(uint32_t x);
Exact cosOf(uint32_t x);

}  // namespace plumb
