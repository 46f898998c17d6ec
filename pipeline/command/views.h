// SPDX-License-Identifier: MIT
// One scene, several pictures: which camera each has and where it goes.
#pragma once

#include "pipeline/cli/options.h"
#include "pipeline/render/frame.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <string>
#include <vector>

namespace plumb {

struct Viewpoint {
    std::string name;  // word of --view; "" for the scene's own camera
    Camera camera;     // with --stereo: midway between the eyes
    std::vector<Light> lights;
};

// The scene completed for `size` with the camera flags applied, and one Viewpoint a picture (at least one). A bare mesh
// without lights is lit anew for each camera, so that a view looks the same alone and in company.
std::vector<Viewpoint> viewsOf(Scene&, glm::uvec2 size, const Options&, bool bareMesh);
glm::uvec2 sizeOf(const Scene&, const Options&);

// '{n}', '{n:4}', '{view}', '{aov}', '{eye}', '{field}', '{ink}' filled in. A number is padded with zeros to `digits`, or as the placeholder says.
// Throws Error(usage) on a placeholder that is not known.
struct PlaceholderValues {
    uint32_t number = 0, digits = 1;
    std::string view, aov, eye, field, ink;
};
std::string filledIn(const std::string& pattern, const PlaceholderValues&);
bool hasPlaceholder(const std::string& pattern, const char* name);

}  // namespace plumb
