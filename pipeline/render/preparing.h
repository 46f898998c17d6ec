// SPDX-License-Identifier: MIT
// The parts from which every way to draw prepares its pictures.
#pragma once

#include "pipeline/render/camera.h"
#include "pipeline/render/draw_list_of.h"
#include "pipeline/render/prepare.h"

#include <cstdint>
#include <string>

namespace plumb {

uint32_t sideOf(const RenderRequest& request);     // samples of a pixel along an axis
uint32_t shadingOf(const RenderRequest& request);  // gpu::kShading of a raster shading

// Each throws Error(input), for ways to draw that do not have it.
void refuseNoZBuffer(const Scene& scene);  // z_buffer = false
void refuseShapes(const Scene& scene);     // spheres and planes
// Where the first of the spheres and planes is stated.
std::string firstShapePlace(const Scene& scene);

// Prepares anew what depends on the scene's camera and on where its objects stand. False: an object comes into view that the list does not have, the
// front of one turns round, or a light changes its kind; `p` is then not to be drawn.
bool placeAgain(const Scene& scene, const RenderRequest& request, Prepared& p);

// A picture that is being prepared: the canvas, the camera, the background and the choices are there from the start. A way to draw adds what it takes
// of the scene and the steps of its plan.
class Preparing {
public:
    // `shading`: gpu::kShading of what is lit.
    Preparing(const Scene& scene, const RenderRequest& request, uint32_t shading);
    Preparing(const Preparing&) = delete;
    Preparing& operator=(const Preparing&) = delete;

    // States that what asks for rays is left out. Empty: nothing asks.
    void dropRays(const std::string& asked);
    // Lights, and a material where no object has one. None for what is not lit.
    void addLights();
    // Leaves out the parts of illumination that no light or no material of the list needs.
    void leaveOut();
    // States the choices that every way to draw has, and hands over the picture.
    Prepared finish();

    const Scene& scene;
    const RenderRequest& request;
    const Pinhole view;
    Prepared p;
    ListBuilder list;  // of p
};

}  // namespace plumb
