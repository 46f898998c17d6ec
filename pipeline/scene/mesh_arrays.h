// SPDX-License-Identifier: MIT
// A scene from memory: meshes from arrays, materials and objects, without a file. Every refusal is Error(input), one sentence that names
// the array, the number and what was expected.
#pragma once

#include "pipeline/scene/scene.h"

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>

namespace plumb {

// A mesh of triangles as it lies in memory. The arrays are the caller's, and are read by addMesh() only.
struct MeshArrays {
    std::span<const float> positions;     // x, y, z of each vertex, in the object's own units; 3 numbers a vertex, at most 2^100
    std::span<const uint32_t> triangles;  // 3 vertices a triangle, from 0, counter-clockwise as seen from outside
    std::span<const float> normals = {};  // x, y, z of each vertex, of any length; empty: made from the faces by creaseDegrees
    double creaseDegrees = 60;            // the edge of two faces that meet at a smaller angle is smooth; 0 to 180
    std::string name = "mesh";
};

// Appends a material and returns its index. Colours are linear RGB from 0 to 1.
uint32_t addMaterial(Scene&, const Material&);
// Appends a mesh of one material and returns its index. kNone: the scene's first material, made where there is none. Faces without area and
// normals that cannot be used are counted in scene.warnings.
uint32_t addMesh(Scene&, const MeshArrays&, uint32_t material = kNone);
// Appends an object, a mesh placed in the world, and returns its index, which is its object_id in pictures. world = worldFromObject *
// object, with column vectors. kNone: the mesh's own materials. Another one is shown by a copy of the mesh, one for all such objects.
uint32_t addObject(Scene&, uint32_t mesh, const glm::dmat4& worldFromObject = glm::dmat4(1), uint32_t material = kNone);

}  // namespace plumb
