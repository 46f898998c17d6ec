// SPDX-License-Identifier: MIT
// Capsules of `plumb verify --capsule` as folders.
#pragma once

#include "host/device.h"
#include "pipeline/cli/options.h"
#include "pipeline/cli/progress.h"
#include "pipeline/render/render.h"

#include <filesystem>
#include <string>

namespace plumb {

// Throws Error(usage) where the folder of --capsule is there already and is not empty, or its parent is not.
void refuseCapsuleFolder(const Options&);
// Reduces a picture that the sides draw differently in `pass`, and writes its capsule: a new folder, whole or not at all. Returns what to
// say of it, one line. `onProgress` as for reduce().
std::string writeCapsule(const Options&, Device&, const Scene&, const RenderRequest&, const std::string& pass,
                         const std::filesystem::path& folder, Progress& progress);

}  // namespace plumb
