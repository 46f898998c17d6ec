// SPDX-License-Identifier: MIT
// How far choices may move a colour, where that is proved: from the bounds beside the functions (shaders/shared/), the scene's lights and materials,
// the distance of its lights and the angles between its normals. No picture is looked at.
#pragma once

#include "pipeline/render/render.h"

#include <glm/glm.hpp>
#include <string>

namespace plumb {

struct ColourBound {
    bool proved = true;
    glm::dvec3 linear{
        0};            // at most this much in linear light, a channel, wherever both pictures show the same triangle
    double steps = 0;  // and then at most so many steps of the stored code more
    std::string why;   // not proved: which choice has no bound, one sentence
};

// Between a picture with the trade of `request` and the same with none.
ColourBound boundOfTrade(const Scene& scene, const RenderRequest& request);

// Between two traced pictures that differ in depth and cutoff alone. A ray is no brighter than the brightest material in all the light that there is, or
// the sky; rays beyond depth d weigh m^d together, with m the largest share that a material sends on; those below the cutoff, the most that any
// sequence of the scene's materials leaves below it.
ColourBound boundOfDepth(const Scene& scene, const RenderRequest& base, const RenderRequest& request);

// Between two devices, or device and twin, that draw `request`: 0 but for the device's own functions. Always proved unless a light may touch a
// surface.
ColourBound boundOfNative(const Scene& scene, const RenderRequest& request);

}  // namespace plumb
