// SPDX-License-Identifier: MIT
// The table of the ways to draw: which one draws a request, and what each refuses before a device is opened.
#include "pipeline/render/technique.h"

#include "host/error.h"
#include "tests/support/ray_scenes.h"

#include <gtest/gtest.h>
#include <cstdint>
#include <functional>
#include <string>

namespace plumb::test {
namespace {

Scene triangles() { return soup({64, 48}, 1, 20, 12); }

Scene spheres() {
    Scene s = rayScene();
    s.camera->focalPixels = 500;
    s.spheres.push_back({});
    s.spheres[0].radius = 10;
    return s;
}

RenderRequest requestOf(Shading shading, Fill fill = Fill::exact) {
    RenderRequest r;
    r.width = 64;
    r.height = 48;
    r.shading = shading;
    r.fill = fill;
    return r;
}

std::string refusalOf(const Scene& scene, const RenderRequest& request) {
    try {
        refuse(scene, request);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

std::string nameFor(const Scene& scene, const RenderRequest& request) { return techniqueOf(scene, request).name; }

TEST(Technique, TheFirstThatDrawsARequestIsChosen) {
    const Scene mesh = triangles(), balls = spheres();
    for (const Shading shading : {Shading::unlit, Shading::flat, Shading::gouraud, Shading::phong}) {
        EXPECT_EQ(nameFor(mesh, requestOf(shading)), "raster");
        EXPECT_EQ(nameFor(mesh, requestOf(shading, Fill::notes)), "notes");
    }
    EXPECT_EQ(nameFor(mesh, requestOf(Shading::wire)), "wire");
    EXPECT_EQ(nameFor(mesh, requestOf(Shading::wire, Fill::notes)), "wire");
    EXPECT_EQ(nameFor(mesh, requestOf(Shading::ray)), "rays");
    EXPECT_EQ(nameFor(balls, requestOf(Shading::ray)), "rays");
    EXPECT_EQ(nameFor(balls, requestOf(Shading::phong, Fill::notes)), "spheres");
    EXPECT_EQ(nameFor(balls, requestOf(Shading::phong)), "raster") << "which refuses them";
}

TEST(Technique, NoneDrawsWhatComesOfComparingItsPicture) {
    for (const Shading shading : {Shading::phong, Shading::ray, Shading::wire})
        for (const Plane plane : {kPlaneError, kPlaneCertified}) {
            RenderRequest request = requestOf(shading);
            const Technique& technique = techniqueOf(triangles(), request);
            EXPECT_EQ(technique.planes & plane, 0u) << technique.name;
            EXPECT_EQ(refusalOf(triangles(), request), "");
            request.planes |= plane;
            EXPECT_NE(refusalOf(triangles(), request).find("plumb render --aov"), std::string::npos) << nameOf(plane);
        }
}

TEST(Technique, WhatItDoesNotHaveIsOneSentenceWithoutADevice) {
    const auto change = [](RenderRequest request, const std::function<void(RenderRequest&)>& body) {
        body(request);
        return request;
    };
    Scene noZBuffer = triangles();
    noZBuffer.zBuffer = false;
    Scene stated = triangles();  // as a file that states both
    stated.distantViewer = true, stated.viewerLocation = "s.toml:3:10";
    stated.fill = Fill::notes, stated.fillLocation = "s.toml:4:8";
    const RenderRequest phong = requestOf(Shading::phong), rays = requestOf(Shading::ray), notes = requestOf(Shading::phong, Fill::notes);
    struct Row {
        Scene scene;
        RenderRequest request;
        const char* says;
    };
    const Row rows[] = {
        {triangles(), change(phong, [](auto& r) { r.samples = 2; }), "--samples takes 1, 4 or 16"},
        {triangles(), change(phong, [](auto& r) { r.width = 0; }), "--size"},
        {triangles(), change(phong, [](auto& r) { r.width = 70000; }), "beyond the exact grid"},
        {spheres(), phong, "only --shading ray draws"},
        {noZBuffer, phong, "z_buffer = false"},
        {noZBuffer, rays, "z_buffer = false"},
        {triangles(), change(phong, [](auto& r) { r.trade = {.vectors = Trade::Vectors::face, .coarse = true}; }), "leave rate=1/2 out"},
        {triangles(), change(phong, [](auto& r) { r.trade = {.vectors = Trade::Vectors::vertex, .nativeEncode = true}; }), "own functions"},
        {triangles(), change(phong, [](auto& r) { r.trade.coarse = true, r.knobs.chunkTriangles = 7; }),
         "--limit-chunk 7 cuts its 20 triangles"},
        {triangles(), change(rays, [](auto& r) { r.distantViewer = true; }), "--viewer distant"},
        {triangles(), change(rays, [](auto& r) { r.fill = Fill::notes; }), "--fill notes"},
        {stated, change(rays, [](auto& r) { r.distantViewer = true; }), "s.toml:3:10: viewer = \"distant\" is"},
        {stated, change(rays, [](auto& r) { r.fill = Fill::notes; }), "s.toml:4:8: fill = \"notes\" is"},
        {triangles(), change(rays, [](auto& r) { r.trade.affine = true; }), "--trade"},
        {triangles(), change(rays, [](auto& r) { r.rays.jitterShadow = 0.6f; }), "--jitter"},
        {triangles(), change(rays, [](auto& r) { r.rays.cutLevels = true; }), "--levels cut"},
        {triangles(), change(notes, [](auto& r) { r.trade.affine = true; }), "the axis specular"},
        {spheres(), change(notes, [](auto& r) { r.shading = Shading::gouraud; }), "--shading phong"},
        {spheres(), change(notes, [](auto& r) { r.samples = 4; }), "one sample a pixel"},
        {triangles(), change(requestOf(Shading::wire), [](auto& r) { r.width = 17000; }), "at most 16384x16384 samples"},
    };
    for (const Row& row : rows) EXPECT_NE(refusalOf(row.scene, row.request).find(row.says), std::string::npos) << row.says;
    // The same without what is refused draws: no sentence stands for everything.
    for (const RenderRequest& request : {phong, rays, notes, requestOf(Shading::wire)}) EXPECT_EQ(refusalOf(triangles(), request), "");
    EXPECT_EQ(refusalOf(spheres(), notes), "");
    EXPECT_EQ(refusalOf(spheres(), rays), "");
    EXPECT_EQ(refusalOf(stated, rays), "") << "the request overrides both";
    EXPECT_EQ(refusalOf(noZBuffer, notes), "") << "polygons in their order";
    EXPECT_EQ(refusalOf(triangles(), change(phong, [](auto& r) { r.trade.coarse = true, r.knobs.chunkTriangles = 20; })), "")
        << "one chunk";
}

}  // namespace
}  // namespace plumb::test
