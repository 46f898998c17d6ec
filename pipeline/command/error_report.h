// SPDX-License-Identifier: MIT
// Error figures in reports. Shares of full scale: 1 is 255 steps.
#pragma once

#include "pipeline/command/command.h"
#include "pipeline/render/bounds/rounding.h"
#include "pipeline/truth/certificate.h"
#include "pipeline/truth/frame_error.h"

#include <optional>
#include <string>

namespace plumb {

Json truthJson(const Truth&);
// Error figures in JSON. `sampledAlike`: the picture's samples are the truth's, so that visible primitives and depths can be compared. No
// rounding: null.
Json errorJson(const FrameError&, bool sampledAlike, const std::optional<Rounding>& rounding);
// Error figures in one line for people: max and where, p99, rms, wrong primitives, rounding.
std::string errorLine(const FrameError&, const Truth&, const std::optional<Rounding>& rounding);
// Shares of the pixels that are certified to half a step, to a step, and not at all.
Json certificateJson(const Certificate&);
std::string certificateLine(const Certificate&);

}  // namespace plumb
