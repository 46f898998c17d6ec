// SPDX-License-Identifier: MIT
// render_mesh MESH OUT.png: draws a mesh on the best device there is, and by the CPU twin where there is none.
#include <cstdio>
#include <glm/glm.hpp>
#include <plumbline/plumbline.hpp>

int main(int count, char** arguments) {
    if (count != 3) {
        std::fprintf(stderr, "usage: render_mesh MESH OUT.{png,exr,npy}\n");
        return 2;
    }
    try {
        const glm::uvec2 size(640, 480);
        plumb::Scene scene = plumb::loadScene({arguments[1]}, {});
        plumb::completeScene(scene, size, "iso", plumb::isBareMesh(arguments[1]));

        plumb::RenderRequest request;
        request.width = size.x;
        request.height = size.y;
        request.planes = plumb::kPlaneColour | plumb::kPlaneLinear;

        const plumb::DeviceChoice choice = plumb::Device::choose({});
        plumb::RenderResult result;
        if (choice.twin) {
            result = plumb::renderCpu(scene, request);
        } else {
            plumb::Device device = plumb::Device::open(choice, {});
            result = plumb::renderGpu(device, scene, request);
        }
        plumb::writeFrame(arguments[2], result.frame, plumb::kPlaneColour, {}, {{"Software", "render_mesh"}});
        std::printf("%s: %llu pixels covered, %.1f ms; %s\n", arguments[2], static_cast<unsigned long long>(result.frame.coveredPixels),
                    result.totalMs, choice.reason.c_str());
        return 0;
    } catch (const plumb::Error& error) {
        std::fprintf(stderr, "render_mesh: %s\n", error.what());
        return int(error.exit());
    }
}
