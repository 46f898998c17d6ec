// SPDX-License-Identifier: MIT
#include "pipeline/render/raster/twin_frame.h"

#include "pipeline/passes/illuminate.h"
#include "pipeline/passes/transform.h"
#include "pipeline/render/stopwatch.h"

#include <cstdint>
#include <vector>

namespace plumb {

TwinGeometry twinGeometry(const DrawList& list, const FillChoices& choices, bool normals, uint32_t threads, std::vector<PassTime>* times) {
    TwinGeometry g;
    const uint32_t vertices = uint32_t(list.positions.size());
    g.screen.resize(vertices);
    g.carried.resize(vertices);
    if (list.numbers != Numbers::fp32) g.clipSpace.resize(vertices);
    const bool gouraud = choices.shading == gpu::kShadingGouraud && !normals;
    {
        const Stopwatch watch(times, "transform");
        for (const DrawList::Range& r : list.ranges) {
            const gpu::TransformPush push{0, r.firstVertex, r.vertexCount, r.record, list.viewport};
            transformCpu(push, normalsCarried(choices, normals), list.positions, list.normals, list.objects, g.screen, g.carried, threads,
                         {list.numbers, list.longs, g.clipSpace});
        }
    }
    if (gouraud || choices.shading == gpu::kShadingFlat) {
        const Stopwatch watch(times, "illuminate");
        if (!gouraud) g.faceColours.resize(list.facePositions.size());
        for (const DrawList::Range& r : list.ranges) {
            const gpu::IlluminatePush push{0,
                                           gouraud ? r.firstVertex : r.firstFace,
                                           gouraud ? r.vertexCount : r.faceCount,
                                           r.record,
                                           0,
                                           uint32_t(list.lights.size()),
                                           list.towardViewer};
            if (gouraud)
                illuminateCpu(push, choices.parts, list.positions, list.normals, list.vertexMaterial, list.objects, list.materials,
                              list.lights, g.carried, threads);
            else
                illuminateCpu(push, choices.parts, list.facePositions, list.faceNormals, list.faceMaterial, list.objects, list.materials,
                              list.lights, g.faceColours, threads);
        }
    }
    {
        const Stopwatch watch(times, "cull");
        g.records.resize((list.triangles.size() + gpu::kTrianglesPerLane - 1) / gpu::kTrianglesPerLane);
        cullCpu({0, uint32_t(list.triangles.size()), list.cullBackFaces, list.frame}, list.triangles, g.screen, g.records, threads);
    }
    const Stopwatch watch(times, "setup");
    g.places = placeDraws(g.records, list, vertices);
    g.draws.resize(g.places.drawCount);
    g.screen.resize(vertices + g.places.clippedVertices);
    g.carried.resize(vertices + g.places.clippedVertices);
    g.clipKinds.resize(g.places.jobs.size());
    setupCpu(g.records, g.places, list.triangles, g.screen, g.draws, threads);
    clipCpu({0, uint32_t(g.places.jobs.size()), list.cullBackFaces, list.frame, list.viewport}, g.places.jobs, list.triangles,
            list.positions, list.objects, g.screen, g.carried, g.draws, g.clipKinds, threads, g.clipSpace);
    return g;
}

}  // namespace plumb
