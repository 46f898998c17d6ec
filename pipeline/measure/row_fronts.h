// SPDX-License-Identifier: MIT
// Fronts of a measurement's rows: of all, and of each axis with the default.
#pragma once

#include "pipeline/measure/measure.h"

#include <string>
#include <vector>

namespace plumb {

// Says which rows are on a front, and lists those of all rows by rising time. `works`: of each run; equal ones differ in nothing but noise.
void takeFronts(Measurement& m, const std::vector<std::string>& works);

}  // namespace plumb
