// SPDX-License-Identifier: MIT
// Meshes: what a reader returns (polygons as the file has them) and what the passes take (triangles).
// Object space: binary64 as read, float32 from the mesh's own origin as drawn. Indices are valid by construction of the readers.
#pragma once

#include "pipeline/scene/positions.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

namespace plumb {

inline constexpr uint32_t kNone = 0xffffffffu;

struct GeneratedShape;  // shape.h

// Phong material as OBJ/MTL names it. Colours are linear RGB in [0, 1]; Ns in [0, 1e6].
struct Material {
    std::string name = "default";
    glm::vec3 ambient{0.1f};       // Ka
    glm::vec3 diffuse{0.8f};       // Kd
    glm::vec3 specular{0.0f};      // Ks
    glm::vec3 emission{0.0f};      // Ke
    float shininess = 32.0f;       // Ns, specular exponent
    float opacity = 1.0f;          // d, 1 - Tr   (the raster passes draw opaque)
    float refractiveIndex = 1.0f;  // Ni; the notes' density, outside 1
    float reflect = 0.0f;          // weight of the mirrored ray (--shading ray)
    float transmit = 0.0f;         // weight of the refracted ray, and the share that a shadow ray keeps
    float local = -1.0f;           // weight of the local colour; negative: 1 minus the other two
    bool statesRays = false;       // reflect or transmit was stated above 0
    int illum = 2;
};

// Mesh as read: faces of n >= 3 corners. A corner names a position and perhaps a normal.
struct PolygonMesh {
    std::string name;
    Positions positions;
    std::vector<glm::vec3> normals;  // normals as the file has them, of any length
    struct Corner {
        uint32_t position;
        uint32_t normal = kNone;
    };
    std::vector<Corner> corners;
    std::vector<uint32_t> faceFirst;      // size faces + 1; corners of face f: [faceFirst[f], faceFirst[f+1])
    std::vector<uint32_t> faceMaterial;   // size faces, index into materials or kNone
    std::vector<uint32_t> faceSmoothing;  // size faces or empty; OBJ `s`: 0 = off (flat), kNone = not stated
    std::vector<Material> materials;
    std::vector<glm::vec3> colours;     // per position (PLY), or empty
    std::vector<std::string> ignored;   // features of the file that are not drawn, one entry a kind
    std::vector<std::string> warnings;  // counted ones, e.g. "material library 'x.mtl' is missing"
    std::string location;               // where the file states its faces: file:line:column, or the file; for messages
};

// Mesh as drawn. A vertex is a distinct (position, normal, material) triple; a face keeps its own record for flat shading.
struct TriangleMesh {
    std::string name;
    glm::dvec3 origin{0};              // origin of the positions below, in the object's space (mesh_origin.h); worldFromMesh() includes it
    std::vector<glm::vec3> positions;  // per vertex, relative to the origin
    std::vector<glm::vec3> normals;    // per vertex, unit length (+-2 ulp), never zero
    std::vector<uint32_t> vertexMaterial;  // per vertex, index into the scene's materials
    struct Triangle {
        uint32_t vertex[3];
        uint32_t face;
    };
    std::vector<Triangle> triangles;        // counter-clockwise seen from outside in a right-handed world
    std::vector<glm::vec3> faceCentre;      // per face: mean of its corners, relative to the origin
    std::vector<glm::vec3> faceNormal;      // per face: Newell's normal, unit; zero-area faces: (0,0,1), counted
    std::vector<uint32_t> faceMaterial;     // per face, index into the scene's materials
    std::vector<glm::uvec2> edges;          // each polygon edge once (by position), as vertex indices; for wire frames
    uint32_t degenerateFaces = 0;           // zero area
    uint32_t repairedNormals = 0;           // zero or opposite vertex normals replaced by the face normal
    uint32_t flushedDenormals = 0;          // |x| < 2^-126 set to +0
    uint32_t selfCrossingFaces = 0;         // no ear was left: the rest of the face was cut as a fan
    uint32_t uncutFaces = 0;                // concave and too large to triangulate: they have no triangles
    uint32_t firstSelfCrossing = kNone;     // index of the first self-crossing face
    std::string location;                   // where the file states its faces: file:line:column, or the file; for messages
    glm::vec3 boundsMin{0}, boundsMax{0};   // box of the positions, relative to the origin
    glm::dvec3 statedMin{0}, statedMax{0};  // box of the positions as the file states them, in the object's space
    glm::dvec3 lost{0};                     // largest distance of a vertex from the file's position, along each axis
    // Per vertex, the file's own positions for the truth; empty: origin + position (LoadOptions::keepNumbers). Code that moves positions
    // must empty it.
    std::vector<glm::dvec3> stated;
    std::shared_ptr<const GeneratedShape> shape;  // the curved surface that the triangles stand for; null: the triangles are the surface
    glm::dvec3 statedAt(size_t vertex) const { return stated.empty() ? origin + glm::dvec3(positions[vertex]) : stated[vertex]; }
};

}  // namespace plumb
