// SPDX-License-Identifier: MIT
#include "host/binary64.h"
#include "pipeline/suite/scenes.h"
#include "pipeline/suite/suite.h"

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace plumb::suite {

namespace {

template <Scene (*build)(View)>
Scene seen(uint32_t width, uint32_t height) {
    return build({width, height});
}

Scene sheetOf12(View v) { return sheet(v, 12); }

// Mirrors and glass: spheres, a board, a plane that is bounded, and a mesh behind them.
Scene raysOf(View v, bool mesh, bool glass) {
    Scene s = mesh ? sheet(v, 6) : litScene();
    Random r(29);
    s.materials[0].reflect = 0.3f;
    s.materials[1].reflect = 0.4f;
    if (glass) s.materials[1].transmit = 0.5f, s.materials[1].refractiveIndex = 1.5f;
    for (Material& m : s.materials) m.statesRays = m.reflect > 0 || m.transmit > 0;
    for (uint32_t i = 0; i < 5; ++i) {
        SphereShape sphere;
        sphere.centre = glm::dvec3(v.pointAt(r(0.1, 0.9) * v.width, r(0.1, 0.9) * v.height, r(2.5, 4)));
        sphere.radius = r(0.1, 0.4);
        sphere.material = i % 3;
        s.spheres.push_back(sphere);
    }
    PlaneShape board;
    board.point = {0, -0.6, 0};
    board.square = 0.3;
    board.otherMaterial = 1;
    s.planes.push_back(board);
    PlaneShape wall;
    wall.point = {0, 0, -7};
    wall.normal = {0, 0, 1};
    wall.u = {1, 0, 0};
    wall.v = {0, 1, 0};
    wall.uMin = wall.vMin = -1;
    wall.uMax = wall.vMax = 1;
    s.planes.push_back(wall);
    s.lights.resize(2);
    s.shading = Shading::ray;
    return s;
}
Scene raysOfShapes(View v) { return raysOf(v, false, false); }
Scene raysOfGlass(View v) { return raysOf(v, false, true); }
Scene raysOfMesh(View v) { return raysOf(v, true, false); }

// The notes' viewer, who counts in pixels.
Scene notesSpheres(View v) {
    Scene s = litScene();
    s.leftHanded = true;
    s.camera->forward = {0, 0, 1};
    s.lights.resize(2);
    s.lights[0].direction = {1, 2, -3};
    s.lights[1].position = {40, 60, -20};
    Random r(31);
    for (uint32_t i = 0; i < 24; ++i) {
        SphereShape sphere;
        sphere.radius = std::floor(r(3, 24));
        sphere.centre = {std::floor(r(-0.5, 0.5) * v.width), std::floor(r(-0.5, 0.5) * v.height), r(60, 200)};
        sphere.material = i % 3;
        s.spheres.push_back(sphere);
    }
    return s;
}

void unlit(RenderRequest& r) { r.shading = Shading::unlit; }
void flat(RenderRequest& r) { r.shading = Shading::flat; }
void gouraud(RenderRequest& r) { r.shading = Shading::gouraud; }
void phong(RenderRequest& r) { r.shading = Shading::phong; }
void rays(RenderRequest& r) { r.shading = Shading::ray; }
void notes(RenderRequest& r) { r.fill = Fill::notes; }
void notesFlat(RenderRequest& r) { flat(r), notes(r); }
void notesGouraud(RenderRequest& r) { gouraud(r), notes(r); }
void notesPhong(RenderRequest& r) { phong(r), notes(r); }
void fourSamples(RenderRequest& r) { gouraud(r), r.samples = 4; }
void nativeResolved(RenderRequest& r) { phong(r), r.samples = 4, r.trade.nativeEncode = true; }
void nativePower(RenderRequest& r) { phong(r), r.trade.specular = Trade::Specular::native; }
void nativeVertices(RenderRequest& r) { gouraud(r), r.trade.specular = Trade::Specular::native; }
void notesNative(RenderRequest& r) { notesPhong(r), r.trade.specular = Trade::Specular::native; }
void vectorsOfVertices(RenderRequest& r) { phong(r), r.trade.vectors = Trade::Vectors::vertex; }
void integers(RenderRequest& r) { phong(r), r.trade.precision = Precision::blockInteger; }
void binary64(RenderRequest& r) { phong(r), r.trade.precision = Precision::fp64; }
void cheap(RenderRequest& r) {
    phong(r);
    r.trade.specular = Trade::Specular::schlick;
    r.trade.subpixelBits = 4;
    r.trade.depthBits = 16;
    r.trade.affine = r.trade.coarse = true;
    r.trade.unitNormals = false;
}
void wire(RenderRequest& r, WireView view) { r.shading = Shading::wire, r.wire = view; }
void wireSeenThrough(RenderRequest& r) { wire(r, WireView::seeThrough); }
void wireCulled(RenderRequest& r) { wire(r, WireView::culled), r.wirePerPolygon = true; }
void wireSolid(RenderRequest& r) { wire(r, WireView::solid); }

constexpr PictureTest kPictures[] = {
    {"soup-phong", 131, 67, seen<soupSmall>, phong},
    {"soup-gouraud", 131, 67, seen<soupSmall>, gouraud},
    {"soup-flat", 131, 67, seen<soupSmall>, flat},
    {"soup-unlit", 131, 67, seen<soupLarge>, unlit},
    {"large-flat", 131, 67, seen<soupLarge>, flat},
    {"centres-flat", 131, 67, seen<throughCentres>, flat},
    {"equal-depths-phong", 131, 67, seen<equalDepths>, phong},
    {"degenerate-flat", 131, 67, seen<degenerate>, flat},
    {"huge-phong", 131, 67, seen<huge>, phong},
    {"clipped-phong", 131, 67, seen<signPatterns>, phong},
    {"clipped-gouraud", 131, 67, seen<signPatterns>, gouraud},
    {"inside-flat", 131, 67, seen<inside>, flat},
    {"sheet-four-samples", 131, 67, seen<sheetOf12>, fourSamples},
    {"sheet-native-resolved", 131, 67, seen<sheetOf12>, nativeResolved},
    {"sheet-native-power", 131, 67, seen<sheetOf12>, nativePower},
    {"sheet-native-vertices", 131, 67, seen<sheetOf12>, nativeVertices},
    {"sheet-vectors-of-vertices", 131, 67, seen<sheetOf12>, vectorsOfVertices},
    {"clipped-integers", 131, 67, seen<signPatterns>, integers},
    {"clipped-binary64", 131, 67, seen<signPatterns>, binary64},
    {"sheet-cheap", 131, 67, seen<sheetOf12>, cheap},
    {"wire-seen-through", 131, 67, seen<signPatterns>, wireSeenThrough},
    {"wire-inside", 131, 67, seen<inside>, wireSeenThrough},
    {"wire-culled", 131, 67, seen<sheetOf12>, wireCulled},
    {"wire-solid", 131, 67, seen<soupLarge>, wireSolid},
    {"wire-solid-sheet", 131, 67, seen<sheetOf12>, wireSolid},
    {"wire-solid-equal-depths", 131, 67, seen<equalDepths>, wireSolid},
    {"wire-solid-centres", 131, 67, seen<throughCentres>, wireSolid},
    {"notes-clipped", 131, 67, seen<signPatterns>, notesGouraud},
    {"notes-degenerate", 131, 67, seen<degenerate>, notesFlat},
    {"notes-centres", 131, 67, seen<throughCentres>, notesGouraud},
    {"notes-flat", 131, 67, seen<soupLarge>, notesFlat},
    {"notes-gouraud", 131, 67, seen<sheetOf12>, notesGouraud},
    {"notes-phong", 131, 67, seen<soupSmall>, notesPhong},
    {"notes-equal-depths", 131, 67, seen<equalDepths>, notesFlat},
    {"notes-inside", 131, 67, seen<inside>, notesFlat},
    {"notes-spheres", 131, 67, seen<notesSpheres>, notesPhong},
    {"notes-spheres-native", 131, 67, seen<notesSpheres>, notesNative},
    {"rays-shapes", 67, 41, seen<raysOfShapes>, rays},
    {"rays-glass", 67, 41, seen<raysOfGlass>, rays},
    {"rays-mesh", 67, 41, seen<raysOfMesh>, rays},
    {"plain-phong", 131, 67, seen<soupSmall>, phong, kPlainLimits},
    {"plain-native-power", 131, 67, seen<sheetOf12>, nativePower, kPlainLimits},
    {"plain-vectors-of-vertices", 131, 67, seen<sheetOf12>, vectorsOfVertices, kPlainLimits},
    {"plain-rays", 67, 41, seen<raysOfMesh>, rays, kPlainLimits},
    {"emulated-clipped-phong", 131, 67, seen<signPatterns>, phong, kEmulatedLimits},
    {"emulated-gouraud", 131, 67, seen<soupSmall>, gouraud, kEmulatedLimits},
};

}  // namespace

std::span<const PictureTest> pictureTests() { return kPictures; }

RenderRequest requestOf(const PictureTest& test, uint32_t threads) {
    RenderRequest request;
    request.width = test.width;
    request.height = test.height;
    request.threads = threads;
    test.choose(request);
    return request;
}

std::string lacks(Device& device, const PictureTest& test) {
    return requestOf(test, 1).trade.precision == Precision::fp64 ? lacksBinary64(device) : std::string();
}

}  // namespace plumb::suite
