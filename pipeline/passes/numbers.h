// SPDX-License-Identifier: MIT
#pragma once

namespace plumb {

// In which vertices are transformed; the last two are more accurate (shaders/shared/long_transform.h).
enum class Numbers { fp32, blockInteger, fp64 };

}  // namespace plumb
