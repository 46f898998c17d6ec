// SPDX-License-Identifier: MIT
// Parts of a traced picture that a scene may need, known before anything is traced.
#pragma once

#include "pipeline/render/camera.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <string>
#include <vector>

namespace plumb {

// Materials that a ray may meet, as indices into scene.materials, ascending.
std::vector<uint32_t> materialsOfRays(const Scene& scene);

// Rays that some hit may send on.
struct RayReach {
    bool mirrors = false, passes = false;  // mirrored and refracted rays, by the materials of the whole scene
    bool eyeSends = false;                 // true when a ray from the eye may meet a material that sends a ray on
};
RayReach rayReachOf(const Scene& scene, const RenderRequest& request, const Pinhole& view);

// Reason why no shadow ray of the scene meets anything; empty: one may.
std::string standsAlone(const Scene& scene);

}  // namespace plumb
