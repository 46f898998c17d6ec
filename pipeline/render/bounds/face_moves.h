// SPDX-License-Identifier: MIT
// What the choices of a trade move in the pixels of each face that a raster picture may show (bound.h).
#pragma once

#include "pipeline/passes/draw_list.h"
#include "pipeline/render/bounds/bound_light.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>

namespace plumb {

class FaceMoves {
public:
    // Largest moves of a pixel in linear light, toward white and toward black. Infinite where a light may touch the face.
    struct Move {
        glm::dvec3 brighter{0}, darker{0};
    };
    using Wanted = std::function<bool(uint32_t object, uint32_t face)>;
    using Visit = std::function<void(uint32_t object, uint32_t face, const Move&)>;

    // Scene and request must outlive it.
    FaceMoves(const Scene& scene, const RenderRequest& request);

    // Calls `visit` for each triangle of a face that `wanted` says yes to.
    void each(const Wanted& wanted, const Visit& visit) const;

private:
    Move moveOf(const Material& m, const glm::dvec3 (&corner)[3], const glm::dvec3 (&normal)[3]) const;
    double flipBound(const Material& m, const Light& light, const glm::dvec3 (&corner)[3], double aside, double turned) const;

    const Scene& scene_;
    const RenderRequest& request_;
    const DrawList list_;
    const LitPoints points_;
    const bool native_, rough_, shorter_;
};

}  // namespace plumb
