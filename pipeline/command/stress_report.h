// SPDX-License-Identifier: MIT
// Margins of a scene as text and JSON (docs/outputs.md, "stress").
#pragma once

#include "pipeline/command/command.h"
#include "pipeline/stress/stress.h"

#include <string>

namespace plumb {

// One line about the scene as it is, then one an axis.
std::string stressText(const stress::StressReport& report);
Json stressJson(const stress::StressReport& report);

}  // namespace plumb
