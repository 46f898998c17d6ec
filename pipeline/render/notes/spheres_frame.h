// SPDX-License-Identifier: MIT
// `--fill notes` for a scene of spheres: the implicit sphere rendering of 16.5, one pass for all of it. Encoding and the other planes are host code, the
// same for device and twin.
#pragma once

#include "pipeline/passes/spheres.h"
#include "pipeline/render/technique.h"

namespace plumb {

extern const Technique kSpheres;

}  // namespace plumb
