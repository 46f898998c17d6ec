// SPDX-License-Identifier: MIT
// Where everything of a render goes, decided and checked before anything is drawn.
#pragma once

#include "pipeline/command/stereo.h"
#include "pipeline/image/arrange.h"

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

namespace plumb {

struct OutputFile {
    std::string path;
    std::vector<Plane> aovs;
    std::optional<Eye> eye;      // eye of a stereo pair
    std::optional<Field> field;  // field of an interlaced picture
    std::optional<Inks> inks;    // a separation, of this ink
    size_t ink = 0;
};

struct OutputPlan {
    bool sheet = false;                          // all views in one picture
    std::vector<std::vector<OutputFile>> files;  // files of each view; of the sheet alone when there is one
    uint32_t planes = kPlaneColour;
    bool transparent = false;
};

// Throws Error(usage) for names that cannot hold what is asked for, lack a placeholder, or name two pictures.
OutputPlan outputPlanOf(const Options&, const std::vector<Viewpoint>&, glm::uvec2 size);

}  // namespace plumb
