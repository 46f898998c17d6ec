// SPDX-License-Identifier: MIT
// What float32 costs by itself: the contracts read again in binary64, from the inputs that the passes had and with the decisions that they took (which
// triangle is seen, where its snapped corners lie), against the colours that were drawn. It is no error: a choice that is far from the truth may
// round little.
#pragma once

#include "pipeline/render/render.h"

#include <cstdint>
#include <optional>

namespace plumb {

struct Rounding {
    // Steps of the sRGB code (1/255), before a colour becomes a byte, over the pixels that show something; a pixel counts by its largest channel.
    double max = 0, mean = 0, rms = 0, p99 = 0;
    uint32_t x = 0, y = 0;  // where the largest is first met
    double linearMax = 0;   // in linear light
    uint64_t pixels = 0;
};

// `frame` is what `request` drew, with kPlaneLinear. None for wire frames, rays, --fill notes, a distant viewer and shading once in 2 x 2 pixels, whose passes are not
// read again.
std::optional<Rounding> roundingOf(const Scene& scene, const RenderRequest& request, const Frame& frame);

}  // namespace plumb
