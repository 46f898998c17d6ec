// SPDX-License-Identifier: MIT
// Upper bound of the light that surfaces can get, and the positions at which it falls on them. For the bounds of choices (bound.h).
#pragma once

#include "pipeline/render/render.h"

#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

namespace plumb {

// Distance from a point to the nearest point of a triangle.
double distanceToTriangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

// Points at which a pixel may be lit: their distance from the stated triangle, and from the light.
//   Corners are snapped to 1/256 px: the point lies on a triangle whose corners stand at most sqrt(2)/512 px aside, at their own depths.
//   n/w is interpolated in float32: 12 u of the triangle's largest (tests/oracle/fill_oracle_test.cpp), so w is off by 12 u w / least w of
// itself. 40 u more cover the ray and the reciprocal. float32 may move a corner itself by 2^-20 of the triangle's reach. Rays meet the
// triangle itself.
class LitPoints {
public:
    using Corners = glm::dvec3[3];
    LitPoints(const Scene& scene, const RenderRequest& request);
    // Largest distance of a lit point from the triangle, wherever on it.
    double aside(const Corners& p) const;
    // Least distance of a lit point from the light.
    double fromLamp(const glm::dvec3& lamp, const Corners& p) const;

private:
    struct Extent {
        double reach = 0, least = std::numeric_limits<double>::infinity(), most = 0;  // distance from the eye; depth
    };
    Extent extentOf(const Corners& p) const;
    double shift(const Extent& e) const;
    double alongRay(const Extent& e, double reach) const;

    const Camera& camera_;
    double focal_ = 1, near_ = 1;
    bool traced_ = false;
};

// Share of a light that is left at a distance.
double fadeAt(const Light& light, double distance);

// Upper bound of the light of all lights that a surface of each material can get, in each channel: attenuation by the least distance to
// one.
std::vector<glm::dvec3> mostLightOfMaterials(const Scene& scene, const RenderRequest& request);

// Brightest colour that a surface of a material can have; N.L and the power are at most 1.
inline glm::dvec3 brightestOf(const Scene& scene, const Material& m, const glm::dvec3& light) {
    return glm::dvec3(m.ambient) * glm::dvec3(scene.ambient) + glm::dvec3(m.emission) +
           light * (glm::dvec3(m.diffuse) + glm::dvec3(m.specular));
}

inline bool isFinite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

inline constexpr const char* kLampTouches = "a light that fades with distance may touch a surface";

}  // namespace plumb
