// SPDX-License-Identifier: MIT
// Opened pixels as JSON and as text.
#pragma once

#include "pipeline/command/command.h"
#include "pipeline/pixel/line.h"

#include <string>

namespace plumb {

// Keys: docs/outputs.md. Numbers that are not finite are strings: "inf", "-inf", "nan".
Json pixelJson(const OpenedPixel& opened);
Json chainJson(const Chain& chain);
// Lines with four columns; a number in brackets in place of a value names the reason below.
std::string textOf(const OpenedPixel& opened);
std::string textOf(const Chain& chain);

}  // namespace plumb
