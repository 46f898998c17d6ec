// SPDX-License-Identifier: MIT
// Moves of a whole scene: what the axes are made of. Each leaves a scene that a file could have stated, in binary64, as a loader leaves it.
#pragma once

#include "pipeline/scene/scene.h"

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>

namespace plumb::stress {

// Least and greatest corner of a box.
struct Box {
    glm::dvec3 low{0}, high{0};
    glm::dvec3 middle() const { return low * 0.5 + high * 0.5; }
};

// The point that the camera looks at.
glm::dvec3 centreOf(const Camera& camera);
// Largest magnitude of a coordinate.
double largestOf(const glm::dvec3& v);

// Takes every position of a mesh, as its file states it, to another one; the origin, the float32 positions and the boxes follow as in the loader.
// Normals stay.
void restate(TriangleMesh& mesh, const std::function<glm::dvec3(const glm::dvec3&)>& to);
// Adds a face without area at a place, which only the mesh's box knows of.
void addFarFace(TriangleMesh& mesh, const glm::dvec3& at);
// Cuts each triangle of a mesh into parts^2 alike ones, each a face of its own, with interpolated normals. The surface stays the same.
TriangleMesh cutFaces(const TriangleMesh& mesh, uint32_t parts);

// Moves everything: objects, shapes, point lights and the camera.
void translate(Scene& scene, const glm::dvec3& by);
// Makes everything `factor` times as large, seen from a camera that is moved alike: the picture stays the same. Faded lights get brighter alike.
void enlarge(Scene& scene, double factor);
// Applies a matrix of the world to the objects that have triangles.
void transformObjects(Scene& scene, const glm::dmat4& world);
// Stretches objects and point lights from the eye along the camera's axis. The camera's focal length is left to the caller.
void stretch(Scene& scene, double factor);
// Adds a copy of all objects and shapes behind the others, each point nearer to the eye by `gap` of its distance. The copy covers the same pixels.
void addLayer(Scene& scene, double gap);
// Moves point lights away from `centre` by `factor`. Faded lights get brighter, so that the centre is lit as before.
void moveLights(Scene& scene, const glm::dvec3& centre, double factor);
// Depth of the nearest corner of the objects' boxes along the camera's axis; at least the near plane's.
double nearestDepth(const Scene& scene);

}  // namespace plumb::stress
