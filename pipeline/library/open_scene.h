// SPDX-License-Identifier: MIT
// From a file to a scene that can be drawn, as the command does it.
#pragma once

#include "pipeline/render/render.h"
#include "pipeline/scene/load.h"

#include <filesystem>
#include <glm/glm.hpp>
#include <string>

namespace plumb {

struct OpenOptions {
    glm::uvec2 size{0};  // pixels; 0: as the scene states, else 640 x 480
    // "front", "iso", "az,el" in degrees: a camera framed that way. Empty: the scene's own, else a three-quarter view.
    std::string view;
    LoadOptions load;
};

// Loads and completes a scene file, a glTF or a mesh: what states no camera is framed, and a bare mesh without lights is lit. scene.size is
// the size that it was framed for. Throws Error(input) with the location in the file.
Scene openScene(const std::filesystem::path&, const OpenOptions& = {});

// Pixels that the scene states, or 640 x 480.
glm::uvec2 sizeFor(const Scene&);
// Shading that the scene states, or asks for where `fill` fills polygons. `asked` then says, in one sentence, what asks for rays.
Shading shadingFor(const Scene&, Fill fill, std::string& asked);
// A request with everything that the scene states of its picture: size, shading, fill, encoding, background, rays. A scene that only rays
// draw, or whose materials ask for rays, is traced.
RenderRequest requestFor(const Scene&);

}  // namespace plumb
