// SPDX-License-Identifier: MIT
// Focal length and near plane of a camera. They are computed here only, because their last bits are part of a picture.
#pragma once

#include "pipeline/scene/scene.h"

#include <cmath>

namespace plumb {

// Focal length in samples, for a picture `height` samples high with `side` samples a pixel along an axis.
inline double focalOf(const Camera& camera, double height, double side = 1) {
    return camera.focalPixels > 0 ? camera.focalPixels * side : height / 2 / std::tan(camera.fovYDegrees * 3.14159265358979323846 / 360);
}

// Distance of the near plane in scene units: as stated, or the largest power of two not above 2^-10 of the distance to the framed centre.
inline double nearOf(const Camera& camera) {
    return camera.near > 0 ? camera.near : std::exp2(std::floor(std::log2(camera.focusDistance)) - 10);
}

}  // namespace plumb
