// SPDX-License-Identifier: MIT
#include "pipeline/render/plan_steps.h"

#include <cstdint>

namespace plumb {

namespace {

class Steps {
public:
    Steps(const RenderRequest& request, const Prepared& prepared, RunsOn side, Plan& plan)
        : request_(request), p_(prepared), side_(side), plan_(plan) {}

    // Triangles by the passes of the raster; `samples`: those of a pixel. The filled picture under a solid wire frame is taken for its depth and faces.
    void raster(uint32_t samples, bool underLines) {
        const bool device = side_ == RunsOn::device;
        if (device) add("clear", "tiles that no triangle touches show the background");
        add("transform", "vertices from object space to the screen");
        if (!underLines) illuminated();
        add("cull", p_.list.cullBackFaces ? "triangles that face away or lie outside the view are left out"
                                          : "triangles that lie outside the view are left out");
        add("setup", device ? "drawn triangles are listed, small ones in their tiles" : "drawn triangles are listed");
        if (device) {
            add("clip", "triangles that cross the near plane or leave the guard band are cut");
            add("bin", "medium triangles are listed in their tiles");
            add("bin strips", "large triangles are listed in their tiles, strip by strip");
        } else {
            fused("clip", "setup", "triangles that cross the near plane or leave the guard band are cut");
        }
        add("fill", "the nearest triangle of each sample");
        if (device && underLines) return;
        const char* shades =
            p_.choices.shading == gpu::kShadingPhong ? "illumination at each sample" : "the colour that a triangle carries, at each sample";
        if (device)
            fused("shade", "fill", shades);
        else
            add("shade", shades);
        colours(samples, side_, device ? "fill" : "");
    }

    void lines() {
        if (request_.wire == WireView::solid) raster(1, true);
        add("lines", "edges, pixel by pixel");
        colours(p_.side * p_.side, RunsOn::host, "");
    }

    void rays(bool cornersResolve) {
        add("trace", "rays through each sample, and what they are followed by");
        colours(cornersResolve ? 4 : p_.side * p_.side, side_, side_ == RunsOn::device ? "trace" : "");
    }

    void spheres() {
        add("spheres", "the nearest sphere of each pixel and its illumination, in parallel projection");
        colours(1, RunsOn::host, "");
    }

    void notes() {
        plan_.add({"project", RunsOn::host, "corners to whole pixels, by the notes' projection"});
        if (p_.choices.shading != gpu::kShadingPhong) illuminated();
        add("scanline", "the first and last column of each polygon in each row");
        if (side_ == RunsOn::device)
            add("scanpaint", "the nearest polygon of each pixel, row by row");
        else
            fused("scanpaint", "scanline", "the nearest polygon of each pixel, row by row");
        if (p_.choices.shading == gpu::kShadingPhong) add("illuminate", "illumination at each pixel");
        colours(p_.side * p_.side, RunsOn::host, "");
    }

private:
    void add(const char* name, const char* why) { plan_.add({name, side_, why}); }
    void fused(const char* name, const char* in, const char* why) { plan_.add({name, side_, why, in}); }

    void illuminated() {
        if (p_.choices.shading == gpu::kShadingFlat) add("illuminate", "one illumination a face");
        if (p_.choices.shading == gpu::kShadingGouraud) add("illuminate", "one illumination a vertex");
    }

    // Samples become pixels and linear light becomes code. `in`: the step whose kernel encodes single samples.
    void colours(uint32_t samples, RunsOn side, const char* in) {
        const char* encodes = request_.encoding == Encoding::linear ? "colours become bytes, in linear light" : "colours become sRGB";
        if (samples > 1) plan_.add({"resolve", side, "the samples of a pixel become one colour, in linear light"});
        plan_.add({"encode", side, encodes, samples > 1 ? "resolve" : in});
    }

    const RenderRequest& request_;
    const Prepared& p_;
    RunsOn side_;
    Plan& plan_;
};

}  // namespace

void planSteps(const Scene& scene, const RenderRequest& request, RunsOn side, Prepared& p) {
    Steps steps(request, p, side, p.plan);
    using Sampling = RayChoices::Sampling;
    if (request.shading == Shading::ray)
        return steps.rays(request.rays.sampling == Sampling::corners || request.rays.sampling == Sampling::adaptive);
    if (request.shading == Shading::wire) return steps.lines();
    if (drawsSpheres(scene, request)) return steps.spheres();
    if (request.fill == Fill::notes) return steps.notes();
    if (p.list.triangles.empty()) return p.plan.dropped.push_back({"every pass", "nothing to draw"});
    steps.raster(p.side * p.side, false);
}

}  // namespace plumb
