// SPDX-License-Identifier: MIT
// Rounding: the error of float32 by itself. The contracts are evaluated again in binary64, from the inputs of the passes and with their
// decisions (the visible triangle, the snapped corners). The result is compared with the colours that were drawn. Rounding says nothing
// about the error against the truth: a choice that is far from the truth may round little.
#pragma once

#include "pipeline/render/render.h"

#include <cstdint>
#include <optional>

namespace plumb {

struct Rounding {
    // Rounding in steps of the sRGB code (1/255), before a colour becomes a byte. It is taken over the pixels that show something, each by
    // its largest channel.
    double max = 0, mean = 0, rms = 0, p99 = 0;
    uint32_t x = 0, y = 0;  // pixel at which the largest is first met
    double linearMax = 0;   // largest rounding in linear light
    uint64_t pixels = 0;    // pixels that show something
};

// Rounding of `frame`, which `request` drew with kPlaneLinear. None for wire frames, rays, --fill notes, a distant viewer and shading once
// in 2 x 2 pixels, whose passes are not evaluated again.
std::optional<Rounding> roundingOf(const Scene& scene, const RenderRequest& request, const Frame& frame);

}  // namespace plumb
