// SPDX-License-Identifier: MIT
// Detail: a scene with as many triangles as a camera can tell, and no more. Meshes are simplified, and generated shapes have as few segments as keep
// a deviation on the screen.
//
// What is proved of an object that is redrawn, where no camera's near plane cuts it: every point of its surface that is seen has a point of the drawn
// surface within `pixels` of it on the screen, and the other way round. So its outline moves by no more. What is not covered is the rest of what makes
// a colour: normals between vertices, which of two parts of the surface is nearer, and shadows and mirrors of rays, which see it from elsewhere.
#pragma once

#include "pipeline/scene/scene.h"

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace plumb {

struct DetailRequest {
    double pixels = 0;                       // largest deviation that is allowed on the screen, above 0
    glm::uvec2 size{0};                      // of the pictures, in pixels
    std::vector<Camera> cameras;             // of all pictures that the scene will be drawn for; empty: the scene's
    uint32_t threads = 0;                    // 0: all
    bool keepNumbers = true;                 // meshes keep their binary64 positions (LoadOptions)
    std::function<bool(double)> onProgress;  // called with the finished share, 0 to 1; false cancels: Error(interrupted)
};

struct DetailRow {
    uint32_t object = 0;
    uint64_t triangles = 0, drawn = 0;  // of the scene, and of what is drawn for them
    uint32_t segments = 0;              // of a generated shape as it is drawn; 0: a mesh
    double deviation = 0;               // bound, in units of the mesh; of a mesh: what was allowed
    double pixels = 0;                  // bound of it on the screen; above what is asked only where a shape has no more segments
    std::string kept;                   // reason why the object is drawn as it is; empty: it is redrawn
};

struct Detail {
    Scene scene;                  // the scene as it is to be drawn: same objects, other meshes
    std::vector<DetailRow> rows;  // one an object
    std::vector<bool> redrawn;    // by object: its faces are not those of the scene
    std::string simplifier;       // "meshoptimizer 0.18"
    double ms = 0;                // host time of all this

    uint64_t triangles() const;
    uint64_t drawnTriangles() const;
    // For the plan: a line a redrawn object, the most a page holds, and one for the rest; then those that are kept, by reasons.
    std::vector<std::string> sentences(double pixels) const;
};

// A scene for a budget of deviation. Objects that share a mesh share the simplified one where their budgets are within a factor of 2. The scene itself
// is what errors are measured against: truthOf() takes it, not Detail::scene. Throws Error(usage) where `pixels` is not above 0.
Detail detailed(const Scene& scene, const DetailRequest& request);

// The scene with `segments` for every generated shape, rounded up to a number that its kind can have. Throws Error(usage) for a scene without one.
Detail tessellatedScene(const Scene& scene, uint32_t segments, bool keepNumbers = true);

}  // namespace plumb
