// SPDX-License-Identifier: MIT
#include "pipeline/scene/area_light.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb {

std::vector<Light> pointsOf(const AreaLight& area) {
    const uint32_t count = area.pointsU * area.pointsV;
    std::vector<Light> lights;
    lights.reserve(count);
    for (uint32_t j = 0; j < area.pointsV; ++j)
        for (uint32_t i = 0; i < area.pointsU; ++i) {
            Light light;
            light.directional = false;
            light.position = area.corner + area.u * ((i + 0.5) / area.pointsU) + area.v * ((j + 0.5) / area.pointsV);
            light.intensity = glm::vec3(glm::dvec3(area.intensity) / double(count));
            light.attenuation = area.attenuation;
            lights.push_back(light);
        }
    return lights;
}

}  // namespace plumb
