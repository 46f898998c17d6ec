// SPDX-License-Identifier: MIT
// Stereo: two eyes instead of one camera (section 3 of the notes: two images from slightly different viewpoints).
// Both look along the camera's own direction, half the separation to its left and right, so no point is higher for one eye than for the
// other. Each sees a window that is moved by whole pixels. So a point at the distance of the framed centre is at the same pixel for both
// (within half a pixel each). Nearer things stand before the screen, farther ones behind it. The parallax in pixels at depth w is focal *
// separation * (1/w - 1/focus).
#pragma once

#include "pipeline/command/command.h"
#include "pipeline/command/views.h"
#include "pipeline/library/renderer.h"

#include <cstdint>
#include <glm/glm.hpp>

namespace plumb {

struct Stereo {
    StereoForm form = StereoForm::none;
    double separation = 0;  // scene units
    uint32_t shift = 0;     // pixels: each eye is drawn 2 * shift columns wider than the picture

    // Throws Error(usage) when the eyes are so far apart that their windows do not overlap.
    Stereo(const Options&, const Camera&, glm::uvec2 size);
    Json json() const;
};

enum class Eye { left, right };
const char* nameOf(Eye);

// Picture of one eye, `request` being that of the whole picture. Adds the object plane, by which covered pixels are counted.
RenderResult renderEye(Renderer&, Scene&, const Camera&, const RenderRequest&, const Stereo&, Eye);
// Both eyes in one picture: twice as wide for side-by-side. Times are of both, plan and counters of the left one.
RenderResult renderBothEyes(Renderer&, Scene&, const Camera&, const RenderRequest&, const Stereo&);

}  // namespace plumb
