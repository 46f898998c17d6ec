// SPDX-License-Identifier: MIT
// poses SCENE [COUNT]: depth, normal and object of a scene from COUNT cameras around it (100), by a resident scene and by renderGpu in turns. Prints the
// medians of both and ends with 1 where a byte differs. The first picture of each, which makes its pipelines, is not counted.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <glm/glm.hpp>
#include <plumbline/plumbline.hpp>
#include <vector>

namespace {

// A camera at the distance of `first`, in a direction that is another one for each index, evenly over the sphere (Fibonacci's lattice).
plumb::Camera cameraOf(const plumb::Camera& first, uint32_t index, uint32_t count) {
    const double height = 1 - (2 * index + 1.0) / count, round = std::sqrt(1 - height * height), turn = 2.399963229728653 * index;
    const glm::dvec3 centre = first.eye + first.forward * first.focusDistance;
    const glm::dvec3 direction(round * std::cos(turn), height, round * std::sin(turn));
    return plumb::lookAt(centre + first.focusDistance * direction, centre, {0, 1, 0}, first.fovYDegrees);
}

double millisecondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// Of all but the first.
double medianOf(std::vector<double> times) {
    if (times.size() > 1) times.erase(times.begin());
    std::sort(times.begin(), times.end());
    return times.empty() ? 0 : times[times.size() / 2];
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 2) {
        std::fprintf(stderr, "usage: poses SCENE [COUNT]\n");
        return 2;
    }
    try {
        const uint32_t poses = count > 2 ? uint32_t(std::strtoul(arguments[2], nullptr, 10)) : 100;
        plumb::Scene scene = plumb::openScene(arguments[1], {.size = {320, 240}});
        plumb::RenderRequest request = plumb::requestFor(scene);
        request.planes = plumb::kPlaneColour | plumb::kPlaneDepth | plumb::kPlaneNormal | plumb::kPlaneObject;
        plumb::Renderer renderer;
        if (renderer.device() == nullptr) throw plumb::Error(plumb::Exit::device, renderer.reason());

        const plumb::Camera first = *scene.camera;
        plumb::ResidentScene resident(*renderer.device(), scene, request);
        std::vector<double> residentMs, wholeMs;
        uint32_t uploads = 0, differing = 0;
        for (uint32_t i = 0; i < poses; ++i) {
            scene.camera = cameraOf(first, i, poses);
            auto start = std::chrono::steady_clock::now();
            const plumb::ResidentScene::Picture picture = resident.draw({.camera = scene.camera});
            residentMs.push_back(millisecondsSince(start));
            start = std::chrono::steady_clock::now();
            const plumb::RenderResult whole = plumb::renderGpu(*renderer.device(), scene, request);
            wholeMs.push_back(millisecondsSince(start));
            uploads += resident.resident() ? 0 : 1;
            const plumb::Frame& frame = *picture.frame;
            differing += frame.rgba != whole.frame.rgba || frame.depth != whole.frame.depth || frame.normal != whole.frame.normal ||
                         frame.object != whole.frame.object;
        }
        std::printf("%u poses of 320x240: resident %.2f ms a picture, renderGpu %.2f ms; %u uploads, %u pictures differ\n", poses,
                    medianOf(residentMs), medianOf(wholeMs), uploads, differing);
        return differing == 0 ? 0 : 1;
    } catch (const plumb::Error& error) {
        std::fprintf(stderr, "poses: %s\n", error.what());
        return int(error.exit());
    }
}
