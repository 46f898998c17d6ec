// SPDX-License-Identifier: MIT
// The notes' projection: corners to whole pixels of a canvas of samples, in binary64 on the host, the same for device and twin.
#pragma once

#include "pipeline/passes/scanline.h"
#include "pipeline/render/camera.h"

#include <cstddef>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace plumb {

// A polygon's corner before projection, relative to the eye in scene units: right, down, forward.
struct NotesCorner {
    glm::dvec3 view;
    glm::vec3 attributes;
};

// True when the polygon turns one way only, and once around: its direction in y changes twice at most.
bool isConvex(std::span<const gpu::ScanCorner> polygon);

class NotesProjection {
public:
    // `distance`: of the viewer, where Zps is 0.
    NotesProjection(const Pinhole& view, double distance);

    // The part of a polygon before the near plane, on whole pixels (rounded half to even); Z is not rounded (14.2).
    std::vector<gpu::ScanCorner> display(const std::vector<NotesCorner>& polygon) const;
    // Distance of a pixel along the view axis, from its Z: Zps in the fill's unit.
    double depthOf(float z) const { return distance_ * distance_ / (distance_ - double(z) / zUnit_); }
    // Direction to the sample, forward component 1. The notes' pixel (x, y) is the point (x, y) of the screen, not the middle of a cell.
    glm::dvec3 rayOf(size_t sample) const;

private:
    // Zps = d Z / (d + Z) with Z = w - d: 0 at distance d, d at infinity.
    double zpsOf(double w) const { return distance_ * (w - distance_) / w; }
    std::vector<NotesCorner> inFront(const std::vector<NotesCorner>& polygon) const;

    const Pinhole& view_;
    const double distance_;
    const double near_;   // near plane of the passes, rounded to float32
    const double zUnit_;  // power of two that brings the viewer's distance to [1, 2): the fill's Z keeps clear of float32's ends
};

}  // namespace plumb
