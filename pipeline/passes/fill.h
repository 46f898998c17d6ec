// SPDX-License-Identifier: MIT
// Fill, shade and encode. Contracts: shaders/shared/fill.h, shade.h, encode.h. One kernel on the device; the twin fills by exact
// integer scan-line spans, then shades each visible pixel once.
#pragma once

#include "host/recorder.h"
#include "pipeline/passes/draw_list.h"
#include "pipeline/passes/transform.h"
#include "shaders/shared/encode.h"
#include "shaders/shared/vectors.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace plumb {

// Choices of the fill kernel: parts that the plan lets it leave out, and outputs that it writes.
struct FillChoices {
    uint32_t shading = gpu::kShadingPhong;
    gpu::ShadeParts parts{true, true, true, gpu::kPowerExact};
    bool oneMaterial = false;
    bool keepNormals = false;                 // vertices get world normals although no pixel is shaded by one
    uint32_t lightCount = 0, lightKinds = 0;  // number and kinds of few lights (shared/fill.h); 0: any number of lights
    bool affine = false;                      // attributes without perspective
    uint32_t depthBits = 32;                  // 32: float32; gpu::kDepthStandard: float32 of 1 - n/w; 16, 24: fixed point
    bool unitNormals = true;                  // false: normals are used as interpolated, not normalised
    uint32_t vectors = gpu::
        kVectorsPixel;  // where directions are made (shared/vectors.h). Others need lightCount and lightKinds, and neither coarse nor native
    bool coarse = false;  // Phong: one shaded pixel in 2 x 2
    uint32_t encoding = gpu::kEncodeSrgb;
    uint32_t planes = 0;  // gpu::kFillPlane bits that the plane buffer holds
    uint32_t write = 0;   // bits of `planes` that this dispatch writes
    bool prior = false, wide = false, colour = true;
    bool one = false;           // every list of the dispatch has one entry
    uint32_t subgroupSize = 0;  // device: 0 = every invocation sets up every triangle; else shared by shuffles
};

// Normals that the transform leaves for these choices. `always`: world normals whatever the shading (normal plane).
inline Normals normalsOfTransform(const FillChoices& choices, bool always) {
    if (always) return Normals::direction;
    if (choices.shading != gpu::kShadingPhong) return choices.keepNormals ? Normals::direction : Normals::none;
    return choices.unitNormals ? Normals::direction : Normals::unit;
}
// Choices with which the normals of a picture of another shading are drawn.
inline FillChoices forNormals(FillChoices choices) {
    choices.shading = gpu::kShadingPhong;
    choices.parts = {false, false, false, gpu::kPowerExact};
    choices.unitNormals = true;
    choices.coarse = false;
    choices.vectors = gpu::kVectorsPixel;
    return choices;
}
// Kinds of a window's few lights, as FillChoices::lightKinds.
inline uint32_t kindsOf(std::span<const gpu::LightRecord> lights) {
    PLUMB_ASSERT(lights.size() <= gpu::kUnrolledLights);
    uint32_t kinds = 0;
    for (size_t i = 0; i < lights.size(); ++i) kinds |= gpu::lightKind(uint32_t(i), lights[i].kind != 0, uint32_t(lights[i].attenuation));
    return kinds;
}
// Lights that one dispatch adds up.
inline uint32_t lightsPerWindow(const FillChoices& choices) {
    return choices.vectors == gpu::kVectorsPixel ? gpu::kLightsPerWindow : gpu::kUnrolledLights;
}

// Twin, first half: z bits (of `depthBits`) and drawn triangle + 1 (0: none) of every pixel of a frame.
void fillCpu(const gpu::FrameBox& frame, std::span<const gpu::DrawTriangle> draws, std::span<const gpu::ScreenVertex> screen,
             std::span<int> z, std::span<uint32_t> draw, uint32_t threads, uint32_t depthBits = 32);

// Twin, second half: linear colour (3 floats a pixel) and, when asked for, unit normals of the covered pixels.
void shadeCpu(const gpu::FrameBox& frame, const DrawList& list, const FillChoices& choices, std::span<const gpu::DrawTriangle> draws,
              std::span<const gpu::ScreenVertex> screen, std::span<const glm::vec4> attributes, std::span<const int> z,
              std::span<const uint32_t> draw, std::span<float> linear, std::span<float> normal, uint32_t threads);

struct FillBuffers {
    const Buffer<gpu::DrawTriangle>& draws;
    const Buffer<gpu::ScreenVertex>& screen;
    const Buffer<glm::vec4>& attributes;
    const Buffer<glm::uvec4>& tiles;  // tile x | y << 16, first entry, entries
    const Buffer<uint32_t>& entries;
    const Buffer<uint32_t>& triangleMaterials;
    const Buffer<gpu::MaterialRecord>& materials;
    const Buffer<gpu::LightRecord>& lights;
    const Buffer<uint32_t>& encodeTable;
    const Buffer<glm::uvec4>& colours;
    const Buffer<glm::uvec4>& planes;
    const Buffer<glm::vec4>& triangleCentres;   // centres of the triangles' faces; kVectorsFace
    uint64_t firstColour = 0, colourCount = 0;  // the band's part of colours; 0: all
};
// Begins to make the pipeline of a recordFill() with these choices.
void prepareFill(Recorder& recorder, const FillChoices& choices, bool distantViewer, const Specialization& exact);
void recordFill(Recorder& recorder, const gpu::FillPush& push, const FillChoices& choices, const Specialization& exact,
                const FillBuffers& buffers, uint32_t firstTile);

}  // namespace plumb
