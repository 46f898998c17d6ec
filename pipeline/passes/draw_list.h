// SPDX-License-Identifier: MIT
// Input of the passes: every drawn object of a scene, flattened for one picture. Device and twin read the same list.
#pragma once

#include "pipeline/choices/trade.h"
#include "shaders/shared/fill.h"
#include "shaders/shared/illuminate.h"
#include "shaders/shared/long_transform.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace plumb {

struct DrawList {
    // One object: ranges into the streams below; `record` indexes `objects`.
    struct Range {
        uint32_t sceneObject = 0, record = 0;
        uint32_t firstVertex = 0, vertexCount = 0;
        uint32_t firstTriangle = 0, triangleCount = 0;
        uint32_t firstFace = 0, faceCount = 0;
        uint32_t firstEdge = 0, edgeCount = 0;
        bool turned = false;                    // its triangles are listed in the other order than in the mesh
        Precision precision = Precision::fp32;  // number format in which its vertices are transformed
    };
    std::vector<Range> ranges;
    std::vector<gpu::ObjectRecord> objects;
    bool anyLong = false;                       // true when the precision of some range is not fp32
    std::vector<gpu::LongRecord> longs;         // one an object where anyLong; zeros for objects in fp32
    std::vector<glm::vec4> positions, normals;  // per vertex, object space; w unused
    std::vector<uint32_t> vertexMaterial;
    std::vector<glm::uvec4> triangles;                  // vertices counter-clockwise as seen from the front, material
    std::vector<uint32_t> triangleFace;                 // index into the face stream
    std::vector<glm::vec4> facePositions, faceNormals;  // flat shading: one point a face
    std::vector<glm::vec4> faceCentres;                 // centre of each face relative to the eye, world axes; only for directions of faces
    std::vector<uint32_t> faceMaterial, facePrimitive;  // primitive_id of a face
    std::vector<glm::uvec2> edges;                      // wire frame
    std::vector<uint32_t> edgeFace;                     // index into the face stream for each edge; only when hidden lines are removed
    std::vector<uint32_t> sphereMaterial;               // material of each sphere of the scene; --fill notes only
    std::vector<gpu::MaterialRecord> materials;
    std::vector<gpu::LightRecord> lights;
    gpu::Viewport viewport{};
    gpu::FrameBox frame{};  // the whole frame, in samples
    uint32_t cullBackFaces = 1;
    glm::vec3 rayOrigin{0}, rayX{0}, rayY{0};
    glm::vec3 towardViewer{0};   // unit vector toward a distant viewer; 0: the viewer is at the origin
    uint32_t firstTriangle = 0;  // index in the whole list of this chunk's first triangle
};

// Chunk of the triangles [first, first + count) as a list of its own: vertices and faces that they use, renumbered in order of first use.
DrawList chunkOf(const DrawList& list, uint32_t first, uint32_t count);

}  // namespace plumb
