// SPDX-License-Identifier: MIT
// Shares of a ray's colour: a material's own colour, the mirrored and the refracted ray.
#pragma once

#include "pipeline/scene/mesh.h"

#include <algorithm>

namespace plumb {

struct RayShares {
    float local = 1, reflect = 0, transmit = 0;  // weights, 0 to 1; their sum is at most 1
};

// Kinds of MTL's illum: 3, 5 and 8 mirror; 4, 6, 7 and 9 are glass.
inline bool illumIsGlass(int illum) { return illum == 4 || illum == 6 || illum == 7 || illum == 9; }
inline bool illumMirrors(int illum) { return illum >= 3 && illum <= 9; }

// Shares of a material. By its illum it mirrors the largest of Ks, at most what glass does not let pass.
inline RayShares raySharesOf(const Material& m) {
    RayShares s{m.local, m.reflect, m.transmit};
    if (m.local < 0 && illumMirrors(m.illum)) {
        s.transmit = illumIsGlass(m.illum) ? 1 - m.opacity : 0.0f;
        s.reflect = std::min(std::max({m.specular.x, m.specular.y, m.specular.z}), 1 - s.transmit);
    }
    if (m.local < 0) s.local = std::max(0.0f, 1 - s.reflect - s.transmit);
    return s;
}

// True when the file means the material to be traced. Opacity alone does not mean it, because the raster passes are known to draw it
// opaque.
inline bool asksForRays(const Material& m) {
    const RayShares s = raySharesOf(m);
    return m.statesRays || (m.local < 0 && illumMirrors(m.illum) && (s.reflect > 0 || s.transmit > 0));
}

}  // namespace plumb
