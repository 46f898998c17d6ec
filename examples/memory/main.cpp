// SPDX-License-Identifier: MIT
// A box from memory: arrays become a mesh, an object, a picture and two files, and the depth of a pixel is read.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <plumbline/plumbline.hpp>
#include <vector>

int main() {
    try {
        const std::vector<float> positions = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
        const std::vector<uint32_t> triangles = {4, 5, 6, 4, 6, 7, 1, 0, 3, 1, 3, 2, 5, 1, 2, 5, 2, 6,
                                                 0, 4, 7, 0, 7, 3, 7, 6, 2, 7, 2, 3, 0, 1, 5, 0, 5, 4};

        plumb::Scene scene;
        const uint32_t red = plumb::addMaterial(scene, {.name = "red", .diffuse = {0.8f, 0.1f, 0.1f}});
        const uint32_t box = plumb::addMesh(scene, {.positions = positions, .triangles = triangles, .name = "box"}, red);
        plumb::addObject(scene, box);
        scene.lights.push_back({.direction = {1, 2, 3}});    // toward the light
        scene.camera = plumb::lookAt({3, 2, 5}, {0, 0, 0});  // from, at

        plumb::Renderer renderer;  // the best device there is, or the CPU twin: same bytes
        const plumb::Picture picture =
            renderer.render(scene, {.width = 320, .height = 240, .planes = plumb::kPlaneColour | plumb::kPlaneDepth});
        picture.save("box.png");
        picture.save("depth.npy", plumb::kPlaneDepth);

        const size_t column = 160, row = 120;
        std::printf("drawn by %s\n", picture.drawnBy.c_str());
        std::printf("%llu of %u pixels covered\n", static_cast<unsigned long long>(picture.frame.coveredPixels), 320u * 240u);
        std::printf("depth in the middle: %.6f\n", double(picture.frame.depth[row * picture.frame.width + column]));
        return 0;
    } catch (const plumb::Error& error) {
        std::fprintf(stderr, "memory: %s\n", error.what());
        return int(error.exit());
    }
}
