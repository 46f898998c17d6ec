// SPDX-License-Identifier: MIT
// plumb verify --suite.
#pragma once

#include "pipeline/command/command.h"

namespace plumb {

// Draws the built-in scenes on both sides, runs the modules that draw no picture, and says which modules no test ran.
Exit suiteCommand(const Options&);

}  // namespace plumb
