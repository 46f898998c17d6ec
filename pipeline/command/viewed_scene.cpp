// SPDX-License-Identifier: MIT
#include "pipeline/command/viewed_scene.h"

#include "host/error.h"
#include "pipeline/command/request.h"
#include "pipeline/library/open_scene.h"

#include <fmt/core.h>

namespace plumb {

ViewedScene loadViews(const Options& options, Progress& progress) {
    const LoadOptions how = loadOptionsOf(options, &progress);
    ViewedScene viewed;
    viewed.scene = loadScene({options.inputs.begin(), options.inputs.end()}, how);
    viewed.sources = sourcesOf(options.inputs, how);
    const bool bareMesh = isBareMesh(options.inputs[0], how);
    how.once->clear();
    progress.clear();
    viewed.size = sizeOf(viewed.scene, options);
    viewed.views = viewsOf(viewed.scene, viewed.size, options, bareMesh);
    return viewed;
}

ViewedScene loadOneView(const Options& options, Progress& progress, const char* command) {
    if (options.views.size() > 1) throw usageError(fmt::format("{} looks from one viewpoint: give --view once at most", command));
    ViewedScene viewed = loadViews(options, progress);
    viewed.scene.camera = viewed.views[0].camera;
    viewed.scene.lights = viewed.views[0].lights;
    return viewed;
}

}  // namespace plumb
