// SPDX-License-Identifier: MIT
#include "pipeline/command/warnings.h"

#include "pipeline/render/bounds/vertex_error.h"
#include "pipeline/scene/text.h"

#include <fmt/core.h>
#include <string>

namespace plumb {

void tellScene(const Options& options, const Scene& scene) {
    for (const std::string& ignored : scene.ignored) say(options, fmt::format("plumb: not drawn: {}", ignored));
    for (const std::string& warning : scene.warnings) say(options, fmt::format("plumb: warning: {}", warning));
}

void tellLeftToRays(const Options& options, const Scene& scene, const RenderRequest& request) {
    const std::string asked = leftToRays(scene, request);
    if (asked.empty()) return;
    if (options.strict)
        throw inputError(printable(scene.path),
                         fmt::format("{}; only --shading ray draws that, and --strict refuses to leave it out", asked));
    say(options, fmt::format("plumb: not drawn: reflection and refraction: {}; only --shading ray traces them", asked));
}

void warnOfMovedVertices(const Options& options, Scene& scene, const RenderRequest& request) {
    for (const VertexError& error : vertexErrors(scene, request)) {
        scene.warnings.push_back(sentenceOf(scene, error));
        say(options, fmt::format("plumb: warning: {}", scene.warnings.back()));
    }
}

void MovedVertices::tell(const Scene& scene, const RenderRequest& request, Json& sceneReport) {
    accuracy_ = Json::array();
    for (const VertexError& error : vertexErrors(scene, request)) {
        const std::string sentence = sentenceOf(scene, error);
        sceneReport["warnings"].push_back(sentence);
        accuracy_.push_back(sentence);
        if (told_.insert(error.object).second) say(options_, fmt::format("plumb: warning: {}", sentence));
    }
}

void MovedVertices::tell(const Plan& plan) {
    for (const std::string& sentence : plan.warnings)
        if (planned_.insert(sentence).second) say(options_, fmt::format("plumb: warning: {}", sentence));
}

void MovedVertices::addTo(Json& accuracy) const {
    for (const Json& sentence : accuracy_) accuracy["warnings"].push_back(sentence);
}

}  // namespace plumb
