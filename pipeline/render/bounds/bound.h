// SPDX-License-Identifier: MIT
// How far choices may move a colour, where that is proved: from the bounds beside the functions (shaders/shared/), the scene's lights and materials,
// the distance of its lights and the angles between its normals. Of a picture is taken which face a pixel shows, never a colour.
#pragma once

#include "pipeline/render/render.h"

#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb {

struct ColourBound {
    bool proved = true;
    glm::dvec3 linear{0};                     // at most this much in linear light, a channel, wherever both pictures show the same triangle
    glm::dvec3 darker{0};                     // toward black at most this much
    std::vector<float> brighterAt, darkerAt;  // three a pixel, where a picture was given that shows which face is where
    double steps = 0;                         // and then at most so many steps of the stored code more
    std::string why;                          // not proved: which choice has no bound, one sentence
};

// Between a picture with the trade of `request` and the same with none. `shown`: either of them, of one sample a pixel, with its planes kPlaneObject and
// kPlanePrimitive; then the bound is that of the faces in it. None: of every face that may be drawn.
ColourBound boundOfTrade(const Scene& scene, const RenderRequest& request, const Frame* shown = nullptr);

// Between traced pictures that differ in depth and cutoff alone, pixel by pixel. A picture that follows more rays adds their colours to what it had, and
// takes nothing away. Each colour is no brighter than its surface can be in all the light that there is. So every surface is given that
// brightness as its own, the lamps are taken out, and the twin traces both pictures: what one has more than the other is all that their own colours
// can differ by.
class BoundOfRays {
public:
    BoundOfRays(const Scene& scene, const RenderRequest& base);
    struct Moves {
        bool proved = true;
        std::string why;                      // not proved
        std::vector<float> brighter, darker;  // three a pixel: how far from the base's linear light at most, either way
    };
    Moves of(const RenderRequest& request) const;

private:
    struct Glow {
        std::vector<float> linear;
        double rays = 0;  // of a sample at most
    };
    Glow glowOf(const RenderRequest& request) const;

    Scene glowing_;
    RenderRequest base_;
    std::string why_;  // nothing is proved: why
    Glow baseGlow_;
};

// Between two devices, or device and twin, that draw `request`: 0 but for the device's own functions. Always proved unless a light may touch a
// surface.
ColourBound boundOfNative(const Scene& scene, const RenderRequest& request, const Frame* shown = nullptr);

}  // namespace plumb
