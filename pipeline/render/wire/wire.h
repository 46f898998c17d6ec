// SPDX-License-Identifier: MIT
// Wire frames: the lines pass on either side, then one piece of host code that turns edge owners into pixels.
#pragma once

#include "pipeline/render/technique.h"

namespace plumb {

extern const Technique kWire;

}  // namespace plumb
