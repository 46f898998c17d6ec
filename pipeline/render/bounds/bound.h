// SPDX-License-Identifier: MIT
// Proved bounds of how far choices may move a colour. They follow from the bounds of the functions (shaders/shared/), the scene's lights
// and materials, the distance of its lights and the angles between its normals. A given picture says only which face a pixel shows, never a
// colour.
#pragma once

#include "pipeline/render/render.h"

#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb {

struct ColourBound {
    bool proved = true;
    glm::dvec3 linear{0};                     // largest move in linear light, a channel, wherever both pictures show the same triangle
    glm::dvec3 darker{0};                     // largest move toward black
    std::vector<float> brighterAt, darkerAt;  // three a pixel; only for a given picture, which shows where each face is
    double steps = 0;                         // additional move in steps of the stored code
    std::string why;                          // not proved: one sentence that names the choice without a bound
};

// Bound between a picture with the trade of `request` and the picture without any trade. `shown`: either of them, of one sample a pixel,
// with its planes kPlaneObject and kPlanePrimitive. The bound then holds for the faces in it. Null: for every face that may be drawn.
ColourBound boundOfTrade(const Scene& scene, const RenderRequest& request, const Frame* shown = nullptr);

// Bound between traced pictures that differ in depth and cutoff only, pixel by pixel. A picture that follows more rays adds their colours
// to those it had, and takes nothing away. Each colour is no brighter than its surface can be in all the light that there is. So every
// surface gets that brightness as its own colour, the lights are removed, and the twin traces both pictures. The difference of these is the
// most by which the pictures can differ.
class BoundOfRays {
public:
    BoundOfRays(const Scene& scene, const RenderRequest& base);
    struct Moves {
        bool proved = true;
        std::string why;                      // not proved
        std::vector<float> brighter, darker;  // three a pixel: largest difference from the base's linear light, either way
    };
    Moves of(const RenderRequest& request) const;

private:
    struct Glow {
        std::vector<float> linear;
        double rays = 0;  // most rays of a sample
    };
    Glow glowOf(const RenderRequest& request) const;

    Scene glowing_;
    RenderRequest base_;
    std::string why_;  // reason why nothing is proved
    Glow baseGlow_;
};

// Bound between two devices, or device and twin, that draw `request`: 0 but for the device's own functions. It is proved unless a light may
// touch a surface.
ColourBound boundOfNative(const Scene& scene, const RenderRequest& request, const Frame* shown = nullptr);

}  // namespace plumb
