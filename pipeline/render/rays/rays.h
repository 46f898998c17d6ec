// SPDX-License-Identifier: MIT
// Rays from the eye: what they meet, and what they are followed by.
#pragma once

#include "pipeline/render/technique.h"

#include <string>

namespace plumb {

extern const Technique kRays;

// What a material of an object or a sphere asks for. Empty: no material asks for rays.
std::string raysAskedByMaterials(const Scene& scene);

}  // namespace plumb
