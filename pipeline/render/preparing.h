// SPDX-License-Identifier: MIT
// Common code of the techniques for preparing a picture.
#pragma once

#include "pipeline/render/camera.h"
#include "pipeline/render/draw_list_of.h"
#include "pipeline/render/prepare.h"

#include <cstdint>
#include <string>

namespace plumb {

uint32_t sideOf(const RenderRequest& request);     // samples of a pixel along an axis
uint32_t shadingOf(const RenderRequest& request);  // gpu::kShading of a raster shading

// Refusals of techniques that cannot draw what the comment names. They throw Error(input).
void refuseNoZBuffer(const Scene& scene);  // z_buffer = false
void refuseShapes(const Scene& scene);     // spheres and planes
// Location of the first sphere, or else of the first plane; for refusals.
std::string firstShapeLocation(const Scene& scene);

// Prepares anew what depends on the scene's camera and on where its objects stand. False: an object comes into view that the list does not have, the
// front of one turns round, or a light changes its kind; `p` is then not to be drawn.
bool placeAgain(const Scene& scene, const RenderRequest& request, Prepared& p);

// A picture that is being prepared. Canvas, camera, background and choices are there from the start. The technique adds the parts of the
// scene that it draws and the steps of its plan.
class Preparing {
public:
    // `shading`: gpu::kShading of what is lit.
    Preparing(const Scene& scene, const RenderRequest& request, uint32_t shading);
    Preparing(const Preparing&) = delete;
    Preparing& operator=(const Preparing&) = delete;

    // States in the plan that reflection and refraction are left out. `asked`: raysAskedBy(); empty: does nothing.
    void dropRays(const std::string& asked);
    // Adds the lights, and a material where no object has one. Adds no light where nothing is lit.
    void addLights();
    // Leaves out the parts of illumination that no light or no material of the list needs.
    void leaveOut();
    // States the choices that every way to draw has, and hands over the picture.
    Prepared finish();

    const Scene& scene;
    const RenderRequest& request;
    const Pinhole view;
    Prepared p;
    ListBuilder list;  // builder of p.list
};

}  // namespace plumb
