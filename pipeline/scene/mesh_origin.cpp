// SPDX-License-Identifier: MIT
#include "pipeline/scene/mesh_origin.h"

#include <algorithm>
#include <cmath>

namespace plumb {

glm::dvec3 originOfBox(const glm::dvec3& low, const glm::dvec3& high) {
    const glm::dvec3 half = high * 0.5 - low * 0.5;
    const double largest = std::max({half.x, half.y, half.z});
    glm::dvec3 origin(0);
    if (!(largest > 0) || !std::isfinite(largest)) return origin;
    const double step = std::ldexp(1.0, std::ilogb(largest) - kOriginBits);
    for (int i = 0; i < 3; ++i) {
        if (!(std::max(std::abs(low[i]), std::abs(high[i])) > kNearHalfExtents * largest)) continue;
        origin[i] = std::nearbyint((low[i] * 0.5 + high[i] * 0.5) / step) * step;
    }
    return origin;
}

}  // namespace plumb
