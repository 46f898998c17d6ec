// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/twin_frame.h"

#include "pipeline/passes/illuminate.h"
#include "pipeline/passes/transform.h"

#include <cstdint>
#include <vector>

namespace plumb {

TwinPasses::TwinPasses(const DrawList& list, const FillChoices& choices, bool normals, uint32_t threads, TwinGeometry& geometry)
    : list_(list), choices_(choices), normals_(normals), threads_(threads), g_(geometry) {}

bool TwinPasses::illuminates() const {
    return choices_.shading == gpu::kShadingFlat || (choices_.shading == gpu::kShadingGouraud && !normals_);
}

void TwinPasses::transform() {
    const size_t vertices = list_.positions.size();
    g_.screen.resize(vertices);
    g_.attributes.resize(vertices);
    if (list_.anyLong) g_.clipSpace.assign(vertices, glm::vec4(0));
    for (const DrawList::Range& r : list_.ranges) {
        const gpu::TransformPush push{0, r.firstVertex, r.vertexCount, r.record, list_.viewport};
        transformCpu(push, normalsOfTransform(choices_, normals_), list_.positions, list_.normals, list_.objects, g_.screen, g_.attributes,
                     threads_, {r.precision, list_.longs, g_.clipSpace});
    }
}

void TwinPasses::illuminate() {
    const bool vertices = choices_.shading == gpu::kShadingGouraud;
    if (!vertices) g_.faceColours.resize(list_.facePositions.size());
    for (const DrawList::Range& r : list_.ranges) {
        const gpu::IlluminatePush push{0,
                                       vertices ? r.firstVertex : r.firstFace,
                                       vertices ? r.vertexCount : r.faceCount,
                                       r.record,
                                       0,
                                       uint32_t(list_.lights.size()),
                                       list_.towardViewer};
        if (vertices)
            illuminateCpu(push, choices_.parts, list_.positions, list_.normals, list_.vertexMaterial, list_.objects, list_.materials,
                          list_.lights, g_.attributes, threads_);
        else
            illuminateCpu(push, choices_.parts, list_.facePositions, list_.faceNormals, list_.faceMaterial, list_.objects, list_.materials,
                          list_.lights, g_.faceColours, threads_);
    }
}

void TwinPasses::cull() {
    g_.records.resize((list_.triangles.size() + gpu::kTrianglesPerLane - 1) / gpu::kTrianglesPerLane);
    cullCpu({0, uint32_t(list_.triangles.size()), list_.cullBackFaces, list_.frame}, list_.triangles, g_.screen, g_.records, threads_);
}

void TwinPasses::setUp() {
    const uint32_t vertices = uint32_t(list_.positions.size());
    g_.slots = drawSlotsOf(g_.records, list_, vertices);
    g_.draws.resize(g_.slots.drawCount);
    g_.screen.resize(vertices + g_.slots.clippedVertices);
    g_.attributes.resize(vertices + g_.slots.clippedVertices);
    g_.clipKinds.resize(g_.slots.jobs.size());
    setupCpu(g_.records, g_.slots, list_.triangles, g_.screen, g_.draws, threads_);
    clipCpu({0, uint32_t(g_.slots.jobs.size()), list_.cullBackFaces, list_.frame, list_.viewport}, g_.slots.jobs, list_.triangles,
            list_.positions, list_.objects, g_.screen, g_.attributes, g_.draws, g_.clipKinds, threads_, g_.clipSpace);
}

TwinGeometry twinGeometry(const DrawList& list, const FillChoices& choices, bool normals, uint32_t threads) {
    TwinGeometry g;
    TwinPasses passes(list, choices, normals, threads, g);
    passes.transform();
    if (passes.illuminates()) passes.illuminate();
    passes.cull();
    passes.setUp();
    return g;
}

}  // namespace plumb
