// SPDX-License-Identifier: MIT
// The technique of traced rays.
#pragma once

#include "pipeline/render/technique.h"

#include <string>

namespace plumb {

extern const Technique kRays;

// Reason to trace a scene that a material of an object or a sphere gives. Empty: no material asks for rays.
std::string raysAskedByMaterials(const Scene& scene);

}  // namespace plumb
