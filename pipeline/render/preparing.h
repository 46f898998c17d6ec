// SPDX-License-Identifier: MIT
// Common code of the techniques for preparing a picture.
#pragma once

#include "pipeline/render/camera.h"
#include "pipeline/render/draw_list_of.h"
#include "pipeline/render/drops.h"
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
    // `shading`: gpu::kShading of what is lit. `way`: kWay bit of the table of drops.
    Preparing(const Scene& scene, const RenderRequest& request, uint32_t shading, uint32_t way);
    Preparing(const Preparing&) = delete;
    Preparing& operator=(const Preparing&) = delete;

    // Chooses the number format in which the vertices of each object are transformed, and states where that is more than float32.
    void chooseArithmetic();
    // States in the plan that reflection and refraction are left out. `asked`: raysAskedBy(); empty: does nothing.
    void dropRays(const std::string& asked);
    // Adds the objects, but those that the table of drops leaves out; see ListBuilder::addObjects().
    void addObjects(bool keepOutside = false);
    // Adds the lights, but those that the table leaves out, and a material where no object has one. Adds no light where nothing is lit.
    void addLights();
    // Walks the rows of the table of drops for a stage.
    void drop(DropStage stage);
    // States the choices that every way to draw has, and hands over the picture.
    Prepared finish();

    const Scene& scene;
    const RenderRequest& request;
    const uint32_t way;
    const Pinhole view;
    Prepared p;
    ListBuilder list;  // builder of p.list
};

}  // namespace plumb
