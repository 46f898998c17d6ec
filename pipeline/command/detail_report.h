// SPDX-License-Identifier: MIT
// --detail of the commands, and what they say of it.
#pragma once

#include "pipeline/cli/progress.h"
#include "pipeline/command/command.h"
#include "pipeline/command/views.h"
#include "pipeline/detail/detail.h"

#include <glm/glm.hpp>
#include <vector>

namespace plumb {

// The scene for --detail, seen from all views, shown as "detail" from one share of the progress to another. An interrupt ends it.
Detail detailOf(const Options& options, const Scene& scene, glm::uvec2 size, const std::vector<Viewpoint>& views, Progress& progress,
                double from = 0, double to = 1);
// `scene` has the names of the objects.
Json detailJson(const Detail& detail, double pixels, const Scene& scene);

}  // namespace plumb
