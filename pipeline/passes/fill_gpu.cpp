// SPDX-License-Identifier: MIT
#include "pipeline/passes/fill.h"

#include <spirv/fill.h>
#include <spirv/fill_native.h>
#include <spirv/fill_native_shuffle.h>
#include <spirv/fill_shuffle.h>
#include <spirv/fill_vectors.h>
#include <spirv/fill_vectors_shuffle.h>
#include <vector>

namespace plumb {

namespace {

// True when the invocations of a subgroup share the set-up of triangles by shuffles. Wide triangles need too many words for that.
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
    constants["kShading"] = choices.shading;
    constants["kDiffuse"] = choices.parts.diffuse;
    constants["kSpecular"] = choices.parts.specular;
    constants["kPointLights"] = choices.parts.point;
    constants["kOneMaterial"] = choices.oneMaterial;
    constants["kLightCount"] = choices.lightCount;
    constants["kEncoding"] = choices.encoding;
    constants["kPlanes"] = choices.planes;
    constants["kPrior"] = choices.prior;
    constants["kWide"] = choices.wide;
    constants["kColour"] = choices.colour;
    constants["kWrite"] = choices.write;
    constants["kPower"] = choices.parts.power;
    constants["kAffine"] = choices.affine;
    constants["kDepthBits"] = choices.depthBits;
    constants["kDistantViewer"] = distantViewer;
    constants["kUnitNormals"] = choices.unitNormals;
    constants["kCoarse"] = choices.coarse;
    constants["kLightKinds"] = choices.lightKinds;
    constants["kOne"] = choices.one;
    if (choices.vectors != gpu::kVectorsPixel) constants["kVectors"] = choices.vectors;
    if (shuffles(choices)) constants["kSubgroupSize"] = choices.subgroupSize;
    return constants;
}

}  // namespace

void prepareFill(Recorder& recorder, const FillChoices& choices, bool distantViewer, const Specialization& exact) {
    recorder.prepare(moduleOf(choices), constantsOf(choices, distantViewer, exact));
}

void recordFill(Recorder& recorder, const gpu::FillPush& push, const FillChoices& choices, const Specialization& exact,
                const FillBuffers& b, uint32_t firstTile) {
    const uint64_t tileOffset = uint64_t(firstTile) * sizeof(glm::uvec4);
    std::vector<Binding> bindings = {
        texels("draws", b.draws, View::texelU32x4),
        texels("screen", b.screen, View::texelU32x4),
        texels("attributes", b.attributes, View::texelF32x4),
        texels("tileRecords", b.tiles, View::texelU32x4, tileOffset, uint64_t(push.tileCount) * sizeof(glm::uvec4)),
        texels("entries", b.entries, View::texelU32),
        texels("triangleMaterials", b.triangleMaterials, View::texelU32),
        texels("materials", b.materials, View::texelF32x4),
        texels("lights", b.lights, View::texelF32x4),
        texels("encodeTable", b.encodeTable, View::texelU32),
        storage("Colours", b.colours, b.firstColour, b.colourCount),
        storage("Planes", b.planes)};
    if (choices.vectors != gpu::kVectorsPixel) bindings.push_back(texels("triangleCentres", b.triangleCentres, View::texelF32x4));
    recorder.dispatch("fill", moduleOf(choices), uint64_t(push.tileCount) * 8, push, bindings,
                      constantsOf(choices, push.toward != glm::vec3(0), exact));
}

}  // namespace plumb
