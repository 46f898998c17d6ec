// SPDX-License-Identifier: MIT
// A unit of its own, which the test of failures links without: it puts a renderer that fails in its place.
#include "pipeline/render/technique.h"

namespace plumb {

RenderResult renderGpu(Device& device, const Scene& scene, const RenderRequest& request) { return render(&device, scene, request); }

}  // namespace plumb
