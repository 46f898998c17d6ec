// SPDX-License-Identifier: MIT
// The light that surfaces can get at most, and where the points lie that it falls on. For the bounds of choices (bound.h).
#pragma once

#include "pipeline/render/render.h"

#include <glm/glm.hpp>
#include <limits>
#include <vector>

namespace plumb {

// From a point to the nearest of a triangle.
double distanceToTriangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

// How far from the stated triangle a point may lie that a pixel is lit at, and how near the lamp it may be for that.
//   Corners are snapped to 1/256 px: the point lies on a triangle whose corners stand at most sqrt(2)/512 px aside, at their own depths.
//   n/w is interpolated in float32: 12 u of the triangle's largest (tests/oracle/fill_oracle_test.cpp), so w is off by 12 u w / least w of itself. 40 u
//   more cover the ray and the reciprocal. float32 may move a corner itself by 2^-20 of the triangle's reach. Rays meet the triangle itself.
class LitPlaces {
public:
    using Corners = glm::dvec3[3];
    LitPlaces(const Scene& scene, const RenderRequest& request);
    // At most this far from the triangle, wherever on it.
    double aside(const Corners& p) const;
    // At least this far from the lamp.
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

// The share of a light that is left at this distance.
double fadeAt(const Light& light, double distance);

// The most light of all lamps that a surface of each material can get, in each channel: attenuation by the least distance to one.
std::vector<glm::dvec3> mostLightOfMaterials(const Scene& scene, const RenderRequest& request);

// The brightest that a surface of a material can be; N.L and the power are at most 1.
inline glm::dvec3 brightestOf(const Scene& scene, const Material& m, const glm::dvec3& light) {
    return glm::dvec3(m.ambient) * glm::dvec3(scene.ambient) + glm::dvec3(m.emission) +
           light * (glm::dvec3(m.diffuse) + glm::dvec3(m.specular));
}

inline constexpr const char* kLampTouches = "a light that fades with distance may touch a surface";

}  // namespace plumb
