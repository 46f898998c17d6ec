// SPDX-License-Identifier: MIT
#include "pipeline/passes/fill.h"

#include <spirv/fill.h>
#include <spirv/fill_native.h>
#include <spirv/fill_native_shuffle.h>
#include <spirv/fill_shuffle.h>
#include <spirv/fill_vectors.h>
#include <spirv/fill_vectors_shuffle.h>

namespace plumb {

namespace {

// Wide triangles need more words than are worth shuffling.
bool shuffles(const FillChoices& choices) {
    return !choices.one && choices.subgroupSize >= 8 && choices.subgroupSize <= 64 && !choices.wide;
}

const Module& moduleOf(const FillChoices& choices) {
    const bool native = choices.parts.power == gpu::kPowerNative || choices.encoding == gpu::kEncodeNative;
    if (choices.vectors != gpu::kVectorsPixel) return shuffles(choices) ? spirv::fill_vectors_shuffle : spirv::fill_vectors;
    if (native) return shuffles(choices) ? spirv::fill_native_shuffle : spirv::fill_native;
    return shuffles(choices) ? spirv::fill_shuffle : spirv::fill;
}

Specialization constantsOf(const FillChoices& choices, bool distantViewer, const Specialization& exact) {
    Specialization constants = exact;
    constants[2] = choices.shading;
    constants[3] = choices.parts.diffuse;
    constants[4] = choices.parts.specular;
    constants[5] = choices.parts.point;
    constants[6] = choices.oneMaterial;
    constants[7] = choices.lightCount;
    constants[8] = choices.encoding;
    constants[9] = choices.planes;
    constants[10] = choices.prior;
    constants[11] = choices.wide;
    constants[12] = choices.colour;
    constants[13] = choices.write;
    constants[15] = choices.parts.power;
    constants[16] = choices.affine;
    constants[17] = choices.depthBits;
    constants[18] = distantViewer;
    constants[20] = choices.unitNormals;
    constants[21] = choices.coarse;
    constants[24] = choices.lightKinds;
    constants[25] = choices.one;
    if (choices.vectors != gpu::kVectorsPixel) constants[30] = choices.vectors;
    if (shuffles(choices)) constants[14] = choices.subgroupSize;
    return constants;
}

}  // namespace

void prepareFill(Recorder& recorder, const FillChoices& choices, bool distantViewer, const Specialization& exact) {
    recorder.prepare(moduleOf(choices), constantsOf(choices, distantViewer, exact));
}

void recordFill(Recorder& recorder, const gpu::FillPush& push, const FillChoices& choices, const Specialization& exact,
                const FillBuffers& b, uint32_t firstTile) {
    const uint64_t tileOffset = uint64_t(firstTile) * sizeof(glm::uvec4);
    if (choices.vectors != gpu::kVectorsPixel) {
        recorder.dispatch("fill", moduleOf(choices), uint64_t(push.tileCount) * 8, push,
                          {texels(b.draws, View::texelU32x4), texels(b.screen, View::texelU32x4), texels(b.carried, View::texelF32x4),
                           texels(b.tiles, View::texelU32x4, tileOffset, uint64_t(push.tileCount) * sizeof(glm::uvec4)),
                           texels(b.entries, View::texelU32), texels(b.triangleMaterials, View::texelU32),
                           texels(b.materials, View::texelF32x4), texels(b.lights, View::texelF32x4),
                           texels(b.encodeTable, View::texelU32), storage(b.colours, b.firstColour, b.colourCount), storage(b.planes),
                           texels(b.places, View::texelF32x4)},
                          constantsOf(choices, push.toward != glm::vec3(0), exact));
        return;
    }
    recorder.dispatch("fill", moduleOf(choices), uint64_t(push.tileCount) * 8, push,
                      {texels(b.draws, View::texelU32x4), texels(b.screen, View::texelU32x4), texels(b.carried, View::texelF32x4),
                       texels(b.tiles, View::texelU32x4, tileOffset, uint64_t(push.tileCount) * sizeof(glm::uvec4)),
                       texels(b.entries, View::texelU32), texels(b.triangleMaterials, View::texelU32),
                       texels(b.materials, View::texelF32x4), texels(b.lights, View::texelF32x4),
                       texels(b.encodeTable, View::texelU32), storage(b.colours, b.firstColour, b.colourCount), storage(b.planes)},
                      constantsOf(choices, push.toward != glm::vec3(0), exact));
}

}  // namespace plumb
