// SPDX-License-Identifier: MIT
#pragma once

namespace plumb {

// Number format in which vertices are transformed; the last two are more accurate than float32 (shaders/shared/long_transform.h).
enum class Numbers { fp32, blockInteger, fp64 };

}  // namespace plumb
