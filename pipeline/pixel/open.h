// SPDX-License-Identifier: MIT
// `plumb pixel`: one pixel, polygon or vertex of a picture opened into the lecture notes' chain, with the values of the device and of the twin
// as their passes left them. Sides that part are told by the first line on which they do.
#pragma once

#include "host/device.h"
#include "pipeline/pixel/line.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>

namespace plumb {

// What is to be opened. Without a pixel: a face or a vertex of an object.
struct Asked {
    std::optional<glm::uvec2> pixel;  // column and row from the top left
    std::optional<uint32_t> face;     // face of the object's mesh, in the order of its file
    std::optional<uint32_t> vertex;   // vertex of the object's mesh
    uint32_t object = 0;              // object of the scene, for `face` and `vertex`
    // Point that the ray from the eye was given to pass through, world: the notes count t in its distance. None: the point of the screen.
    std::optional<glm::dvec3> through;
};

// A picture, drawn once by each side, whose pixels are opened one after another.
class PixelOpener {
public:
    PixelOpener() = default;
    virtual ~PixelOpener() = default;
    PixelOpener(const PixelOpener&) = delete;
    PixelOpener& operator=(const PixelOpener&) = delete;

    // What is asked for is in the picture (checkAsked).
    virtual OpenedPixel open(const Asked& asked) = 0;
    virtual const Frame& twin() const = 0;
    virtual const Frame* device() const = 0;  // null: no device draws
};

// Throws Error(usage), one sentence, for a pixel outside the picture, or an object, polygon or vertex that the scene does not have.
void checkAsked(const Scene& scene, const RenderRequest& request, const Asked& asked);

// Draws the picture and prepares to open its pixels. `device` null: its column says so. The scene and the device outlive the opener. Throws as
// renderCpu() and renderGpu() do, and Error(usage) for pictures of another kind
// than --fill exact: wire frames, --fill notes, --shading ray.
std::unique_ptr<PixelOpener> openerOf(Device* device, const std::string& whyNoDevice, const Scene& scene, const RenderRequest& request);

}  // namespace plumb
