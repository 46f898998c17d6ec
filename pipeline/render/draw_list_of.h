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

    // Number format of the vertices of each object of the scene; float32 without a call. Before addObjects() and placeObjects().
    void setPrecisions(std::vector<Precision> precisions);
    // Every object that prepared.leftOut does not name, and the counters of objects, vertices and triangles. `keepOutside`:
    // every object that the passes can count with, for other cameras.
    void addObjects(bool keepOutside = false);
    // Places the objects of the list anew, for the scene's camera and matrices as they are. False: the list is not that of this view, or an object needs another number format.
    bool placeObjects();
    // The materials of the scene's spheres.
    void addSphereMaterials();
    void addLights();

private:
    void addObject(uint32_t index);
    void addStreams(const TriangleMesh& mesh);
    void addFaces(const TriangleMesh& mesh);
    void addCentres(const TriangleMesh& mesh, const glm::dmat4& worldFromMesh);
    bool isTurned(const glm::dmat4& worldFromMesh) const;
    void addLight(const Light& stated);
    uint32_t slotOf(uint32_t material);  // index into list.materials; appends the material when it is met first

    const Scene& scene_;
    const RenderRequest& request_;
    const Pinhole& view_;
    Prepared& p_;
    DrawList& list_;
    std::vector<Precision> precisions_;  // one an object of the scene; empty: float32
    std::vector<uint32_t> slots_;        // index into list.materials of each material of the scene, or kNone
};

}  // namespace plumb
