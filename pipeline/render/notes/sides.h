// SPDX-License-Identifier: MIT
// The passes of the notes' polygons on either side: illumination of points, and the fill.
#pragma once

#include "pipeline/passes/scanline.h"
#include "pipeline/render/prepare.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

namespace plumb {

class StageCheck;

// Points of one object to be illuminated: positions and normals in its space.
struct NotesPoints {
    std::vector<glm::vec4> positions, normals;
    std::vector<uint32_t> materials;
};

// What differs between the sides.
class NotesSide {
public:
    virtual ~NotesSide() = default;
    virtual std::vector<glm::vec4> illuminate(const NotesPoints&,
                                              uint32_t record) = 0;  // kNone: points relative to the eye, in the world's axes
    virtual ScanCanvas paint(const ScanList&) = 0;
    // Adds the times of its passes, and states which had nothing to do.
    virtual void finish() {}
};

// Null: the twin.
std::unique_ptr<NotesSide> notesSideOf(Device* device, const Prepared& prepared, const RenderRequest& request, RenderResult& result);
// Side that runs each pass on both and compares them; what it gives is the twin's.
std::unique_ptr<NotesSide> checkedSideOf(Device& device, const Prepared& prepared, const RenderRequest& request, RenderResult& result,
                                         StageCheck& check);

}  // namespace plumb
