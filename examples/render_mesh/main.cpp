// SPDX-License-Identifier: MIT
// render_mesh SCENE OUT.{png,exr,npy}: draws a mesh or a scene file on the best device there is, and by the CPU twin where there is none.
#include <cstdio>
#include <plumbline/plumbline.hpp>

int main(int count, char** arguments) {
    if (count != 3) {
        std::fprintf(stderr, "usage: render_mesh SCENE OUT.{png,exr,npy}\n");
        return 2;
    }
    try {
        const plumb::Scene scene = plumb::openScene(arguments[1], {.view = "iso"});
        plumb::RenderRequest request = plumb::requestFor(scene);
        request.planes |= plumb::kPlaneLinear;  // for EXR

        plumb::Renderer renderer;
        const plumb::Picture picture = renderer.render(scene, request);
        picture.save(arguments[2]);
        std::printf("%s: %llu pixels covered, %.1f ms on %s\n", arguments[2], static_cast<unsigned long long>(picture.frame.coveredPixels),
                    picture.totalMs, picture.drawnBy.c_str());
        std::printf("%s\n", picture.reason.c_str());
        return 0;
    } catch (const plumb::Error& error) {
        std::fprintf(stderr, "render_mesh: %s\n", error.what());
        return int(error.exit());
    }
}
