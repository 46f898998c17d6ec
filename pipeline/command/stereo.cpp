// SPDX-License-Identifier: MIT
#include "pipeline/command/stereo.h"

#include "pipeline/command/request.h"
#include "pipeline/image/arrange.h"
#include "pipeline/image/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace plumb {

Stereo::Stereo(const Options& options, const Camera& camera, glm::uvec2 size) : form(options.stereo) {
    if (form == StereoForm::none) return;
    constexpr double kUsualShare = 1.0 / 30;  // of the distance looked at: comfortable for most scenes
    separation = options.eyeSeparation.value_or(camera.focusDistance * kUsualShare);
    const double focal = camera.focalPixels > 0 ? camera.focalPixels : double(size.y) / 2 / std::tan(glm::radians(camera.fovYDegrees) / 2);
    const double pixels = focal * separation / 2 / camera.focusDistance;
    if (!(pixels <= double(size.x) / 2))
        throw usageError(
            "--eye-separation: the eyes are so far apart that what they look at is in neither picture; the usual "
            "distance is 1/30 of that to the framed centre");
    shift = uint32_t(std::lround(pixels));
}

Json Stereo::json() const { return {{"form", nameOf(form)}, {"eyeSeparation", separation}, {"shiftPixels", shift}}; }

const char* nameOf(Eye eye) { return eye == Eye::left ? "left" : "right"; }

RenderResult renderEye(Renderer& renderer, Scene& scene, const Camera& camera, const RenderRequest& request, const Stereo& stereo,
                       Eye eye) {
    RenderRequest wide = request;
    wide.width += 2 * stereo.shift;
    wide.planes |= kPlaneObject;
    if (request.onProgress)
        wide.onProgress = [&request, before = eye == Eye::left ? 0.0 : 0.5](double done) { return request.onProgress(before + done / 2); };
    scene.camera = camera;
    scene.camera->eye += camera.right * (stereo.separation / (eye == Eye::left ? -2 : 2));
    RenderResult result = renderer.render(scene, wide);
    scene.camera = camera;
    // Window of an eye: a point straight ahead at the focus distance is `shift` columns right of the middle for the left eye.
    result.frame = columnsOf(result.frame, eye == Eye::left ? 2 * stereo.shift : 0, request.width);
    return result;
}

RenderResult renderBothEyes(Renderer& renderer, Scene& scene, const Camera& camera, const RenderRequest& request, const Stereo& stereo) {
    RenderResult both = renderEye(renderer, scene, camera, request, stereo, Eye::left);
    const RenderResult right = renderEye(renderer, scene, camera, request, stereo, Eye::right);
    if (stereo.form == StereoForm::anaglyph) {
        both.frame = anaglyphOf(both.frame, right.frame);
    } else {
        const std::array<Frame, 2> eyes = {both.frame, right.frame};
        both.frame = contactSheet(eyes, 2, backgroundPixel(request), {request.background.r, request.background.g, request.background.b});
    }
    for (const PassTime& time : right.times) {
        const auto same = std::find_if(both.times.begin(), both.times.end(), [&](const PassTime& t) { return t.pass == time.pass; });
        if (same == both.times.end()) {
            both.times.push_back(time);
        } else {
            same->ms += time.ms;
            same->dispatches += time.dispatches;
        }
    }
    both.totalMs += right.totalMs;
    return both;
}

}  // namespace plumb
