// SPDX-License-Identifier: MIT
// Picture: what a Renderer drew, and how it becomes a file.
#pragma once

#include "pipeline/render/render.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace plumb {

// Owns its pixels: it outlives the scene and the renderer. The pixel in column x of row y, from the top left, is element y * width + x of
// a plane of one number a pixel (frame.depth), and elements 3 * (y * width + x) to + 2 of a plane of three (frame.normal).
struct Picture : RenderResult {
    std::string drawnBy;             // name of the device, or "CPU twin"
    std::string reason;              // one sentence: why that drew it
    uint32_t planes = kPlaneColour;  // Plane bits that the frame has
    Encoding encoding = Encoding::srgb;
    bool transparent = false;

    // Writes a file by its extension, whole or not at all; an existing one is replaced. .png: the colour. .exr: linear colour and every other
    // plane that the picture has and the format knows, or those of `planes`. .npy: one plane, the colour where `planes` is 0. Throws
    // Error(usage) for another extension and for a plane that the picture lacks, Error(failed) when the disk refuses.
    void save(const std::filesystem::path&, uint32_t planes = 0) const;
};

}  // namespace plumb
