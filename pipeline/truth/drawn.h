// SPDX-License-Identifier: MIT
// A scene in the numbers that the traced passes receive: float32, relative to the eye, in units of the near plane. What is drawn differs
// from the truth of this scene by the passes' own arithmetic alone.
#pragma once

#include "pipeline/scene/scene.h"

namespace plumb::truth {

struct DrawnScene {
    Scene scene;      // eye at the origin, objects without a matrix
    double unit = 1;  // length of a scene unit in it; a power of two
};

// Colours stay as they are: materials have float32 already. The camera's axes stay in binary64.
DrawnScene asDrawn(const Scene& scene);

}  // namespace plumb::truth
