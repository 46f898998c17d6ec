// SPDX-License-Identifier: MIT
// What a picture of `plumb render` says about itself: in its file, in the report of --json, in --explain and in the line for people.
#pragma once

#include "pipeline/command/report.h"
#include "pipeline/command/stereo.h"
#include "pipeline/command/views.h"
#include "pipeline/image/image.h"
#include "pipeline/library/renderer.h"

#include <string>
#include <vector>

namespace plumb {

// Words in the picture's file. Neither device nor time nor folder: the same scene gives the same file on every machine.
Metadata metadataOf(const std::vector<SourceFile>&, const RenderRequest&, const Viewpoint&, const Stereo&);
// Text of --explain.
std::string explained(const Plan&);
// Number of triangles, spheres and planes, for people.
std::string contentOf(const Scene&, const RenderCounters&);
// Report of --json, without times and files, which are known when the picture is written.
Json pictureJson(const Renderer&, const Scene&, const std::vector<SourceFile>&, const Viewpoint&, const RenderRequest&, const RenderResult&,
                 const FrameFacts&, bool blank);

}  // namespace plumb
