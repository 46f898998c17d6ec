// SPDX-License-Identifier: MIT
// The draw list of a scene: its objects inside the view with their materials, and its lights.
#pragma once

#include "pipeline/render/camera.h"
#include "pipeline/render/prepare.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb {

// Adds to `prepared`.list. Throws Error(input) for what reaches further than the passes count.
class ListBuilder {
public:
    ListBuilder(const Scene& scene, const RenderRequest& request, const Pinhole& view, Prepared& prepared);

    // Every object with a part inside the view (with keepEverything: every object), and the counters of objects, vertices and triangles.
    void addObjects();
    // The materials of the scene's spheres.
    void addSphereMaterials();
    void addLights();

private:
    void addObject(uint32_t index);
    void addStreams(const TriangleMesh& mesh);
    void addFaces(const TriangleMesh& mesh, const glm::dmat4& worldFromMesh);
    void addLight(const Light& stated);
    uint32_t slotOf(uint32_t material);  // of the list's materials, appended when it is met first

    const Scene& scene_;
    const RenderRequest& request_;
    const Pinhole& view_;
    Prepared& p_;
    DrawList& list_;
    std::vector<uint32_t> slots_;  // of each material of the scene
};

}  // namespace plumb
