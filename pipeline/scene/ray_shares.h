// SPDX-License-Identifier: MIT
// What of a ray's colour a material takes from itself, from the mirrored and from the refracted ray.
#pragma once

#include "pipeline/scene/mesh.h"

#include <algorithm>

namespace plumb {

struct RayShares {
    float local = 1, reflect = 0, transmit = 0;  // at most 1 together
};

// As MTL numbers them: 3, 5 and 8 mirror; 4, 6, 7 and 9 are glass.
inline bool illumIsGlass(int illum) { return illum == 4 || illum == 6 || illum == 7 || illum == 9; }
inline bool illumMirrors(int illum) { return illum >= 3 && illum <= 9; }

// The share that is mirrored is the largest of Ks, of what glass does not let pass.
inline RayShares raySharesOf(const Material& m) {
    RayShares s{m.local, m.reflect, m.transmit};
    if (m.local < 0 && illumMirrors(m.illum)) {
        s.transmit = illumIsGlass(m.illum) ? 1 - m.opacity : 0.0f;
        s.reflect = std::min(std::max({m.specular.x, m.specular.y, m.specular.z}), 1 - s.transmit);
    }
    if (m.local < 0) s.local = std::max(0.0f, 1 - s.reflect - s.transmit);
    return s;
}

// Whether its file means it to be traced. Opacity alone does not: it is what the raster passes are known to draw opaque.
inline bool asksForRays(const Material& m) {
    const RayShares s = raySharesOf(m);
    return m.statesRays || (m.local < 0 && illumMirrors(m.illum) && (s.reflect > 0 || s.transmit > 0));
}

}  // namespace plumb
