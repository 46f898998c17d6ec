// SPDX-License-Identifier: MIT
#include "pipeline/passes/draw_list.h"

#include "host/error.h"

#include <algorithm>
#include <glm/glm.hpp>

namespace plumb {

DrawList chunkOf(const DrawList& list, uint32_t first, uint32_t count) {
    DrawList chunk;
    chunk.objects = list.objects;
    chunk.anyLong = list.anyLong;
    chunk.longs = list.longs;
    chunk.materials = list.materials;
    chunk.lights = list.lights;
    chunk.viewport = list.viewport;
    chunk.frame = list.frame;
    chunk.cullBackFaces = list.cullBackFaces;
    chunk.rayOrigin = list.rayOrigin;
    chunk.rayX = list.rayX;
    chunk.rayY = list.rayY;
    chunk.towardViewer = list.towardViewer;
    chunk.firstTriangle = list.firstTriangle + first;
    constexpr uint32_t kUnused = 0xffffffffu;
    for (const DrawList::Range& range : list.ranges) {
        const uint32_t begin = std::max(range.firstTriangle, first);
        const uint32_t end = std::min(range.firstTriangle + range.triangleCount, first + count);
        if (begin >= end) continue;
        DrawList::Range r;
        r.sceneObject = range.sceneObject;
        r.record = range.record;
        r.precision = range.precision;
        r.firstVertex = uint32_t(chunk.positions.size());
        r.firstTriangle = uint32_t(chunk.triangles.size());
        r.triangleCount = end - begin;
        r.firstFace = uint32_t(chunk.facePositions.size());
        std::vector<uint32_t> newVertex(range.vertexCount, kUnused);
        std::vector<uint32_t> newFace(range.faceCount, kUnused);
        for (uint32_t t = begin; t < end; ++t) {
            glm::uvec4 corners = list.triangles[t];
            for (int i = 0; i < 3; ++i) {
                uint32_t& slot = newVertex[corners[i] - range.firstVertex];
                if (slot == kUnused) {
                    slot = uint32_t(chunk.positions.size());
                    chunk.positions.push_back(list.positions[corners[i]]);
                    chunk.normals.push_back(list.normals[corners[i]]);
                    chunk.vertexMaterial.push_back(list.vertexMaterial[corners[i]]);
                }
                corners[i] = slot;
            }
            chunk.triangles.push_back(corners);
            const uint32_t face = list.triangleFace[t];
            uint32_t& slot = newFace[face - range.firstFace];
            if (slot == kUnused) {
                slot = uint32_t(chunk.facePositions.size());
                chunk.facePositions.push_back(list.facePositions[face]);
                chunk.faceNormals.push_back(list.faceNormals[face]);
                if (!list.faceCentres.empty()) chunk.faceCentres.push_back(list.faceCentres[face]);
                chunk.faceMaterial.push_back(list.faceMaterial[face]);
                chunk.facePrimitive.push_back(list.facePrimitive[face]);
            }
            chunk.triangleFace.push_back(slot);
        }
        r.vertexCount = uint32_t(chunk.positions.size()) - r.firstVertex;
        r.faceCount = uint32_t(chunk.facePositions.size()) - r.firstFace;
        chunk.ranges.push_back(r);
    }
    PLUMB_ASSERT(chunk.triangles.size() == count);
    return chunk;
}

}  // namespace plumb
