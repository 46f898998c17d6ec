// SPDX-License-Identifier: MIT
// What a command says of a picture on standard error: what of the scene is not drawn, and what is less accurate than a reader may think.
#pragma once

#include "pipeline/command/command.h"
#include "pipeline/render/render.h"

#include <cstdint>
#include <set>
#include <string>

namespace plumb {

// What of the files is not drawn, and the warnings of their readers.
void tellScene(const Options& options, const Scene& scene);

// What only rays would show of the scene. Throws Error(input) with --strict.
void tellLeftToRays(const Options& options, const Scene& scene, const RenderRequest& request);

// Vertices that float32 moves too far: among the warnings of the scene, and said on standard error.
void warnOfMovedVertices(const Options& options, Scene& scene, const RenderRequest& request);

// Warnings of moved vertices: in the JSON of each view, on standard error once an object.
class MovedVertices {
public:
    explicit MovedVertices(const Options& options) : options_(options) {}
    // Adds them to the warnings of the scene's report.
    void tell(const Scene& scene, const RenderRequest& request, Json& sceneReport);
    // Warnings of a plan, each once.
    void tell(const Plan& plan);
    // Adds what was told of the last view to the warnings of a report's "accuracy".
    void addTo(Json& accuracy) const;

private:
    const Options& options_;
    std::set<uint32_t> told_;
    std::set<std::string> planned_;
    Json accuracy_ = Json::array();
};

}  // namespace plumb
