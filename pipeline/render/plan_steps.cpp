// SPDX-License-Identifier: MIT
#include "pipeline/render/plan_steps.h"

#include <cstdint>

namespace plumb {

void StepList::addIllumination() {
    if (p_.choices.shading == gpu::kShadingFlat) add("illuminate", "one illumination a face");
    if (p_.choices.shading == gpu::kShadingGouraud) add("illuminate", "one illumination a vertex");
}

void StepList::addColours(uint32_t samples, RunsOn side, const char* in) {
    const char* encodes = request_.encoding == Encoding::linear ? "colours become bytes, in linear light" : "colours become sRGB";
    if (samples > 1) p_.plan.add({"resolve", side, "the samples of a pixel become one colour, in linear light"});
    p_.plan.add({"encode", side, encodes, samples > 1 ? "resolve" : in});
}

}  // namespace plumb
