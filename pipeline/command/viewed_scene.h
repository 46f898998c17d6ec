// SPDX-License-Identifier: MIT
// A scene as flags name it: its files, the size of its picture and the viewpoints it is seen from.
#pragma once

#include "pipeline/cli/options.h"
#include "pipeline/cli/progress.h"
#include "pipeline/command/report.h"
#include "pipeline/command/views.h"
#include "pipeline/scene/load.h"
#include "pipeline/scene/scene.h"

#include <glm/glm.hpp>
#include <vector>

namespace plumb {

struct ViewedScene {
    Scene scene;
    std::vector<SourceFile> sources;  // each file that was read
    glm::uvec2 size{0};               // pixels
    std::vector<Viewpoint> views;     // at least one
};

// What the inputs and the flags name. Says nothing; throws an Error with file and line on what cannot be read.
ViewedScene loadViews(const Options&, Progress&);
// loadViews() for a command that draws one picture: the scene has the camera and the lights of its only view. Throws Error(usage) where --view
// is given more than once; `command`: its name, which begins the sentence.
ViewedScene loadOneView(const Options&, Progress&, const char* command);

}  // namespace plumb
